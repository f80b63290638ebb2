#pragma once
// The tables of a scene file with their fields, as they stand in a scene. Reading, writing, the list of keys,
// the JSON Schema and comparison walk them.

#include <list>
#include <string>

#include "pipeline/scene_file/field.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

struct Table {
    std::string name;     ///< "cloth", "cloth.fabric"; "": the root's own keys
    std::string path;     ///< "cloth[0]", "cloth[0].fabric"
    bool listed = false;  ///< one of a list
    Fields fields;

    /// "[simulation]", "[[cloth]]".
    std::string header() const { return listed ? "[[" + name + "]]" : "[" + name + "]"; }
    /// The last part of the name.
    std::string key() const { return name.substr(name.rfind('.') + 1); }
};
using Tables = std::list<Table>;

/// "cloth[2]".
std::string entry(const std::string& table, std::size_t index);

/// Every table that `file` has, in the order of writing; their fields stand in `file`, the names of its
/// meshes and textures in `files`.
Tables tables_of(SceneFile& file, FileNames& files);

/// A scene that has one of every table.
SceneFile scene_of_each();

/// The tables of the root, by name.
struct RootTable {
    std::string name;
    bool listed;
};
const std::vector<RootTable>& root_tables();

}  // namespace cloth::pipeline
