#pragma once
// Mesh formats other than OBJ and PLY, by assimp.

#include <filesystem>
#include <string>

#include "base/child.h"
#include "pipeline/formats/mesh_draft.h"

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

/// Leaves the importer no reader but those of the extension: left alone it asks all of them, and some crash
/// or hang over what is not theirs.
void keep_readers_of(const std::string& extension, Assimp::Importer& importer);

/// The same in this process, as it is: for tests that look for the readers' own faults.
MeshDraft import_unguarded(const std::filesystem::path& path, const std::string& extension);

}  // namespace cloth::pipeline
