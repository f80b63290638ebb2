#pragma once
// Wavefront OBJ, in and out.

#include <filesystem>
#include <string>
#include <string_view>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// The file's own vertices (`v`) in their order; normals, materials and the like are passed over. Throws
/// Error(invalid_scene) naming `path` and line.
MeshDraft read_obj(std::string_view text, const std::filesystem::path& path);

/// Numbers with 17 significant digits, so that reading gives the same doubles.
std::string obj_text(const MeshData& mesh);

}  // namespace cloth::pipeline
