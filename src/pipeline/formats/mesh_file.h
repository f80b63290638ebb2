#pragma once
// Meshes from files of any format. How they are written: exporters.h.

#include <filesystem>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// Keeps the file's vertices and their order (an OBJ's `v` lines, a PLY's vertex list), joins nothing, drops
/// nothing, cuts polygons into triangles, and reads coordinates as doubles where the format has them as text.
/// Throws Error(invalid_scene): missing, no regular file, empty, or malformed.
LoadedMesh read_mesh(const std::filesystem::path& path);

/// Only the vertices, as a start pose needs them: the file need not have faces.
LoadedMesh read_points(const std::filesystem::path& path);

}  // namespace cloth::pipeline
