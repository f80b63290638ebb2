#pragma once
// The cells of a sweep: every combination of its grid's values, its list's entries and its samples that its
// constraints allow, each with a name, the keys that it sets and what stands for all that it is.

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_file.h"
#include "pipeline/sweep/sweep_file.h"

namespace cloth::pipeline {

struct CellValue {
    std::string key;
    std::string text;   ///< TOML
    double number = 0;  ///< NaN where it is none
    SweepPlace place;
};

struct Cell {
    std::string name;  ///< that of its folder
    std::int64_t sample = -1;
    std::vector<CellValue> values;  ///< of all that differs between cells, one per SweepCells::keys
    std::vector<double> columns;    ///< one per SweepFile::columns
    Overrides overrides;            ///< of the base scene, in the order in which they act
    std::string key;                ///< equal where the same run is asked for
};

struct SweepCells {
    std::vector<std::string> keys;  ///< of grid, list, samples and derived, in this order
    std::vector<Cell> cells;
    std::int64_t left_out = 0;  ///< by constraints
};

/// Every cell, each checked as a scene. Throws Error(invalid_scene) for the first that cannot be one (a key
/// that there is not, a value out of its range), for two of one name, for more than a million, for an
/// expression with a name that nothing has, and where the constraints leave none.
SweepCells cells_of(const SweepFile& sweep);

/// The scene of a cell.
SceneFile load_cell(const SweepFile& sweep, const Cell& cell);

}  // namespace cloth::pipeline
