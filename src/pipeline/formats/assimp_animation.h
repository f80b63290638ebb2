#pragma once
// Meshes that bend by an animation, as glTF, FBX and Collada have them, by assimp.

#include <filesystem>
#include <string>

#include "base/child.h"
#include "pipeline/formats/mesh_cache_file.h"

namespace cloth::pipeline {

/// The file's first animation, 60 frames a second: nodes move, skeletons bend, morph targets mix. Positions,
/// scales and weights go linearly between keys, rotations along the shortest way. Vertices are those of
/// import_by_assimp() in their order, faces are cut into triangles. `extension` as there. Throws
/// Error(invalid_scene): no animation, a vertex of a skeleton that no bone holds, and as import_by_assimp().
LoadedCache import_animation(const std::filesystem::path& path, const std::string& extension,
                             ChildLimits limits = {});

}  // namespace cloth::pipeline
