#pragma once
// report.html: a kept run, or two beside each other, as one self-contained page (pipeline/page).

#include <cstdint>
#include <filesystem>
#include <optional>

#include "pipeline/run/run_options.h"

namespace cloth::pipeline {

/// Makes report.html in the folder of a run, from what is kept there. Throws Error(other) where it holds no
/// run or no states, or cannot be written; Error(interrupted).
void write_run_page(const std::filesystem::path& out, const RunOptions& options);

/// The same where the run itself has just been made, unless options.page says no: what goes wrong is told and
/// fails nothing.
void leave_run_page(const std::filesystem::path& out, const RunOptions& options);

/// What two runs differ by.
struct RunDifference {
    std::int64_t common = 0;            ///< frames that both keep
    std::optional<std::int64_t> first;  ///< of them whose states differ in any bit
    double largest = 0;                 ///< distance of a vertex from itself [m]
    std::int64_t largest_frame = 0;
    bool comparable = true;  ///< both have as many vertices
};

/// Writes the page `file` of two runs: where they first part, and by how much. Throws as write_run_page();
/// Error(usage) where `file` is something else than such a page.
RunDifference write_comparison_page(const std::filesystem::path& a, const std::filesystem::path& b,
                                    const std::filesystem::path& file, const RunOptions& options);

}  // namespace cloth::pipeline
