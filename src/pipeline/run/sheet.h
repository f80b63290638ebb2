#pragma once
// Several pictures in one: a contact sheet of a run, and two runs beside each other in one movie.

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/run/run.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/image/image.h"

namespace cloth::pipeline {

/// `count` of them, evenly spread from the first to the last; all where there are no more.
std::vector<std::int64_t> spread(const std::vector<std::int64_t>& frames, int count);

/// Pictures of one size row by row, a line of text under each. Throws std::invalid_argument where their sizes
/// differ or there is not one text each.
render::Image contact_sheet(const std::vector<render::Image>& pictures, const std::vector<std::string>& texts,
                            int columns);

struct SheetOptions {
    std::optional<FrameSpan> span;  ///< default: all kept frames
    int count = 12;                 ///< pictures taken from them
    int columns = 0;                ///< 0: as many as rows, or one more
    bool own_size = false;          ///< pictures as large as the scene says instead of 320 pixels wide
};
struct SheetSummary {
    std::filesystem::path file;
    int pictures = 0, width = 0, height = 0;
};
/// Draws the sheet of the run in `out` into `file`, a PNG. Captions are left out, in small pictures curves
/// too.
SheetSummary write_sheet(const std::filesystem::path& out, const std::filesystem::path& file,
                         const SheetOptions& sheet, const Overrides& overrides, const RunOptions& options);

struct ComparisonSummary {
    std::int64_t frames = 0;
    int width = 0, height = 0;
    double playback_rate = 0;
};
/// Draws the runs in two folders beside each other, at equal times, as long as both last, into `movie`. Size,
/// rate and quality are the first run's; colours and automatic framing are shared. `labels` stand at the top.
ComparisonSummary write_comparison(const std::array<std::filesystem::path, 2>& runs,
                                   const std::filesystem::path& movie,
                                   const std::array<std::string, 2>& labels, const Overrides& overrides,
                                   const RunOptions& options);

}  // namespace cloth::pipeline
