#pragma once
// Wavefront OBJ, in and out.

#include <filesystem>
#include <string>
#include <string_view>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// The file's own vertices (`v`) in their order, texture coordinates of corners, and parts: what `o`, `g` and
/// `usemtl` name; normals and the like are passed over. Throws Error(invalid_scene) naming `path` and line.
MeshDraft read_obj(std::string_view text, const std::filesystem::path& path);

/// Numbers with the digits that give the same doubles when they are read.
std::string obj_text(const MeshData& mesh);
std::string obj_text(const MeshOut& mesh);

}  // namespace cloth::pipeline
