#pragma once
// Meshes that bend, from files: PC2, MDD, sequences of OBJ or PLY, and NumPy's .npz.

#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace cloth::pipeline {

struct LoadedCache {
    MeshCache cache;
    std::vector<std::string> notes;
};

/// By the extension:
/// - .pc2 and .mdd as point_cache.h has them; a PC2 tells no times;
/// - .obj and .ply: `path` is the first of a sequence, as walk_0001.obj; those that count up from it follow.
/// The
///   first tells the triangles;
/// - .glb, .gltf, .fbx, .dae: import_animation();
/// - .npz: vertices (frames, n, 3), also called positions; faces (m, 3), also called triangles, may be left
///   out; times (frames), or fps, also called frame_rate.
/// Throws Error(invalid_scene) naming the file: missing, malformed, cut short, of another kind, without
/// frames; a number that is not finite; frames of different vertices; times that do not rise.
LoadedCache read_mesh_cache(const std::filesystem::path& path);

/// As an .npz with every digit. Throws Error(other).
void write_mesh_cache(const MeshCache& cache, const std::filesystem::path& path);

}  // namespace cloth::pipeline
