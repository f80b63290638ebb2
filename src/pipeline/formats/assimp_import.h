#pragma once
// Mesh formats other than OBJ and PLY, by assimp.

#include <filesystem>
#include <string>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// All meshes of the file together, where its nodes put them; coordinates are floats. An STL's triangles that
/// meet in equal coordinates share a vertex. `extension` is in lower case, with its dot. Throws
/// Error(invalid_scene).
MeshDraft import_by_assimp(const std::filesystem::path& path, const std::string& extension);

}  // namespace cloth::pipeline
