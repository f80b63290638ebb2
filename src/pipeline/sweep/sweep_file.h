#pragma once
// A sweep: one scene in many variants. TOML → SweepFile, strict as scene files are: every fault with file,
// line, column and key.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/sweep/expression.h"
#include "pipeline/sweep/sampling.h"

namespace cloth::pipeline {

/// Where a value comes from, for messages.
struct SweepPlace {
    unsigned line = 1, column = 1;
};

/// A key of the scene, or a variable, as the sweep's file names it.
struct SweptKey {
    std::string key;
    SweepPlace place;
};
struct Setting : SweptKey {
    std::string value;  ///< TOML
};
struct GridKey : SweptKey {
    std::vector<std::string> values;  ///< TOML
};
struct ListEntry {
    std::string name;  ///< empty: none was given
    std::vector<Setting> settings;
};
struct SampledKey : SweptKey {
    Distribution distribution;
};
/// Each part is a number or an expression of other keys; a list where the key is one.
struct DerivedKey : SweptKey {
    bool list = false;
    std::vector<Expression> parts;
};
struct Constraint {
    SweepPlace place;
    Expression condition;
};

enum class CellPictures { all, last, none };

/// [results]
struct ResultsDesc {
    std::vector<std::string> measures;  ///< names; empty in a file: all
    CellPictures pictures = CellPictures::all;
    bool movies = false;         ///< of each cell
    bool sheet = true;           ///< one movie of all cells, where they have all pictures
    double pedestal_radius = 0;  ///< of what carries the cloth, for the drape coefficient [m]
};

struct SweepFile {
    std::string name;            ///< the file's, without .toml
    std::filesystem::path path;  ///< of the file
    std::string text;            ///< of the file
    int version = 1;
    std::string scene;  ///< name or path, as load_scene() takes it
    std::string description;
    std::string cell_name;               ///< pattern of the cells' names; empty: the usual
    std::vector<std::string> variables;  ///< names that are no keys of the scene
    std::vector<Setting> set;
    std::vector<GridKey> grid;
    std::vector<ListEntry> list;
    int samples = 0;
    std::uint32_t seed = 0;
    std::vector<SampledKey> sampled;
    std::vector<DerivedKey> derived;
    std::vector<Constraint> constraints;
    std::vector<std::pair<std::string, Expression>> columns;  ///< numbers of the scene to be told beside
    ResultsDesc results;

    bool is_variable(const std::string& key) const;
    /// "drape.toml:3:1".
    std::string at(const SweepPlace& place) const;
};

/// Throws Error(invalid_scene).
SweepFile load_sweep(const std::filesystem::path& path);

/// The same of a text that `path` stands for, in messages and for what it names.
SweepFile parse_sweep(const std::string& text, const std::filesystem::path& path);

}  // namespace cloth::pipeline
