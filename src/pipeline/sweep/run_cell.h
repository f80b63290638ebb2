#pragma once
// One cell's run: what the process of a cell does.

#include <atomic>
#include <cstdint>

#include "pipeline/run/run_options.h"
#include "pipeline/sweep/sweep_folder.h"

namespace cloth::pipeline {

/// Runs a cell in its folder and measures it; never throws but for what nobody can tell of (std::bad_alloc).
/// Where `options.stop` ended it, the record's key is empty. Lines for its log go to `options.tell`.
CellRecord run_cell(const SweepFile& sweep, const SweepFolder& folder, const Cell& cell,
                    const RunOptions& options);

}  // namespace cloth::pipeline
