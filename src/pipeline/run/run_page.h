#pragma once
// report.html: a kept run, or two beside each other, as one self-contained page (pipeline/page).

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>

#include "pipeline/run/run_options.h"

namespace cloth::pipeline {

/// Makes report.html in the folder of a run, from what is kept there. Throws Error(other) where it holds no
/// run or no states, or cannot be written; Error(interrupted). `golden`: what base.js calls so, or none.
void write_run_page(const std::filesystem::path& out, const RunOptions& options,
                    const nlohmann::ordered_json* golden = nullptr);

/// The same where the run itself has just been made, unless options.page says no: what goes wrong is told and
/// fails nothing.
void leave_run_page(const std::filesystem::path& out, const RunOptions& options);

/// How far the vertices of a frame are from themselves in another run.
struct FrameDistance {
    std::int64_t frame = 0;
    double largest = 0, rms = 0;  ///< greatest and root mean square [m]
    std::string vertex;           ///< the farthest: "vertex 12 of cloth sheet"
};

/// What two runs differ by.
struct RunDifference {
    std::int64_t common = 0;             ///< frames that both keep
    std::optional<FrameDistance> first;  ///< of them whose states differ in any bit
    FrameDistance farthest;
    std::string incomparable;  ///< why their states cannot be compared; empty: they can

    bool same() const { return incomparable.empty() && common > 0 && !first; }
};

/// Writes the page `file` of two runs: where they first part, and by how much. Throws as write_run_page();
/// Error(usage) where `file` is something else than such a page.
RunDifference write_comparison_page(const std::filesystem::path& a, const std::filesystem::path& b,
                                    const std::filesystem::path& file, const RunOptions& options);

}  // namespace cloth::pipeline
