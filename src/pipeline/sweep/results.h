#pragma once
// What a sweep gives: a table of its cells in CSV and NumPy's npz, and a plot of it.

#include <filesystem>
#include <string>
#include <vector>

#include "base/plot.h"
#include "pipeline/sweep/cells.h"
#include "pipeline/sweep/sweep_folder.h"

namespace cloth::pipeline {

/// A cell and what has become of it.
struct ResultRow {
    const Cell* cell;
    const CellRecord* record;  ///< null: it has not come to its end
    std::string status() const { return record ? word(record->status) : "missing"; }
};

/// One column of the table: a key, an expression of keys, or a measure.
struct ResultColumn {
    std::string name, unit;
    bool measure = false;
    std::vector<double> numbers;     ///< one per row; NaN where there is none
    std::vector<std::string> texts;  ///< one per row; as TOML has them, without the quotes of a text
    bool numeric = true;             ///< every cell that has a value has a number
};

struct SweepResults {
    SweepResults() = default;
    SweepResults(SweepResults&&) = default;  // rows point into cells and records
    SweepResults& operator=(SweepResults&&) = default;
    const SweepFile* sweep = nullptr;
    SweepCells cells;
    CellRecords records;
    std::vector<ResultRow> rows;        ///< in the order of the cells
    std::vector<ResultColumn> columns;  ///< keys, then expressions, then measures
};

/// The records that are of these cells as they are now; of all others nothing is told.
SweepResults results_of(const SweepFile& sweep, SweepCells cells, const CellRecords& records);

/// cell, status, sample, one column each, frames, last_frame, reason. RFC 4180, numbers to their last bit.
std::string results_csv(const SweepResults& results);

/// cells, status, sample, and an array per column: doubles, or texts where it has some; units of them.
void write_results_npz(const SweepResults& results, const std::filesystem::path& file);

/// A plot of a column against another, of the cells that are done: axes are logarithmic where numbers span
/// more than a factor of fifty. Where a key is a text of at most six values, each is a series. Throws
/// Error(usage) for a column that there is not or that has no numbers.
Plot plot_of(const SweepResults& results, const std::string& x, const std::string& y);

}  // namespace cloth::pipeline
