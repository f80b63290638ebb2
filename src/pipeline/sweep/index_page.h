#pragma once
// index.html of a sweep: a table of its cells that can be sorted, their pictures, and plots of a measure
// against a key. One file that needs nothing but its neighbours.

#include "pipeline/sweep/results.h"

namespace cloth::pipeline {

/// The page as text. Pictures, reports, the movie and logs are linked where they are in the folder.
std::string index_page(const SweepResults& results, const SweepFolder& folder);

void write_index_page(const SweepResults& results, const SweepFolder& folder);

}  // namespace cloth::pipeline
