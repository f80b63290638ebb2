#pragma once
// One movie of all cells beside each other: a contact sheet that moves.

#include "pipeline/sweep/results.h"
#include "pipeline/sweep/run_sweep.h"

namespace cloth::pipeline {

/// How `count` pictures of width:height = `aspect` are laid out in a movie of at most 3840x2160 pixels.
struct SheetGrid {
    int columns = 1, rows = 1;
    int width = 0, height = 0;  ///< of a picture [pixel], at most `widest` wide
};
SheetGrid sheet_grid(int count, double aspect, int widest);

/// Makes the movie of all cells that have pictures, each held on its last one; a movie of the same pictures
/// is kept. False, and no movie: no cell has any, or `options.stop` ended it.
bool write_sheet_movie(const SweepResults& results, const SweepFolder& folder, const SweepOptions& options);

}  // namespace cloth::pipeline
