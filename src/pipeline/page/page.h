#pragma once
// One self-contained HTML page about runs or goldens: its texts are beside this file, what it shows is JSON.

#include <nlohmann/json_fwd.hpp>
#include <string>

namespace cloth::pipeline {

/// The page that shows `data`, whose form base.js, golden.js and unpack.js tell. It loads nothing; texts in
/// `data` may hold anything.
std::string page_text(const nlohmann::ordered_json& data);

/// "data:image/png;base64,…"
std::string picture_url(std::string_view png);

}  // namespace cloth::pipeline
