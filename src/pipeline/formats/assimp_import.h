#pragma once
// Mesh formats other than OBJ and PLY, by assimp.

#include <assimp/matrix4x4.h>

#include <filesystem>
#include <functional>
#include <string>

#include "base/child.h"
#include "pipeline/formats/mesh_draft.h"

struct aiScene;
namespace Assimp {
class Importer;
}  // namespace Assimp

namespace cloth::pipeline {

/// All meshes of the file together, where its nodes put them; coordinates are floats. An STL's triangles that
/// meet in equal coordinates share a vertex. Loose points and lines are passed over, as are animations, which
/// a note tells. `extension` is in lower case, with its dot: it alone says which of assimp's readers is
/// asked, and that runs in a child process. Throws Error(invalid_scene), also where the reader crashes or
/// passes a limit; 0 of memory: three quarters of what is there.
MeshDraft import_by_assimp(const std::filesystem::path& path, const std::string& extension,
                           ChildLimits limits = {});

/// The file as the readers of its extension have it, for as long as the importer lives. No others are asked:
/// some crash or hang over what is not theirs. Throws Error(invalid_scene).
const aiScene& open_scene(Assimp::Importer& importer, const std::filesystem::path& path,
                          const std::string& extension);

/// What read() gives in a child process. Throws Error(invalid_scene) with the text of its Error, or where the
/// child crashes or passes a limit; 0 of memory: three quarters of what is there.
std::string read_in_child(const std::filesystem::path& path, const std::string& extension, ChildLimits limits,
                          const std::function<std::string()>& read);

Eigen::Matrix4d matrix_of(const aiMatrix4x4& m);

/// The same in this process, as it is: for tests that look for the readers' own faults.
MeshDraft import_unguarded(const std::filesystem::path& path, const std::string& extension);

}  // namespace cloth::pipeline
