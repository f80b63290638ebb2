#pragma once
// What a comparison with goldens found, as an HTML page that holds its pictures. Internal to this room.

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "pipeline/golden/golden.h"
#include "render/image/image.h"

namespace cloth::pipeline {

/// The command that makes a scene's goldens anew.
std::string bless_command(const std::string& scene);

/// The page's part of one frame: its pictures are there only while it is made; nullptr: none. `moved`: the
/// frame's own state, where that is not the golden one.
nlohmann::ordered_json row_json(const GoldenRow& row, const render::Image* golden,
                                const render::Image* actual, const render::Image* moved = nullptr);

/// The page's part of all of them; pictures that find no room in `most` bytes are taken out, those of frames
/// that agree first.
nlohmann::ordered_json page_part(const GoldenResult& result, nlohmann::ordered_json rows, std::size_t most);

/// Writes `out`/golden.html with the parts of all frames, and gives its path. Throws Error(other).
std::filesystem::path write_page(const GoldenResult& result, nlohmann::ordered_json rows,
                                 const std::filesystem::path& out);

}  // namespace cloth::pipeline
