#pragma once
// PLY, in and out.

#include <filesystem>
#include <string>
#include <string_view>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// The file's own vertices in their order, from ASCII or binary; other elements and properties are passed
/// over. Throws Error(invalid_scene) naming `path` and, in ASCII, the line.
MeshDraft read_ply(std::string_view bytes, const std::filesystem::path& path);

/// Binary, lower byte first; positions as doubles. Normals are nx ny nz, texture coordinates s t; where there
/// are objects, each face has the number of its own as `object`.
std::string ply_bytes(const MeshOut& mesh);

}  // namespace cloth::pipeline
