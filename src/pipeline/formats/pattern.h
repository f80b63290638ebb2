#pragma once
// Sewing patterns: GarmentCode's JSON (Korosteleva and Sorkine-Hornung 2023, GarmentCode: Programming
// Parametric Sewing Patterns), panels with curved edges, placed around a body and stitched.

#include <filesystem>

#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

/// Usual length of a pattern's edges [m].
inline constexpr double usual_pattern_edge = 0.02;

/// Panels filled with triangles of about `edge_length` [m] and placed as the file says, in metres; texture
/// coordinates are the panels' own, in metres. Parts are the panels and their labels. Stitched edges have as
/// many vertices on both sides, whatever their lengths: what is longer is gathered, which a note tells.
/// Throws Error(invalid_scene).
LoadedMesh read_pattern(const std::filesystem::path& path, double edge_length);

}  // namespace cloth::pipeline
