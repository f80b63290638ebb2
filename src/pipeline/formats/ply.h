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

/// ASCII; numbers with 17 significant digits, so that reading gives the same doubles.
std::string ply_text(const MeshData& mesh);

}  // namespace cloth::pipeline
