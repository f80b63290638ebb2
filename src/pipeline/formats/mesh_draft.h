#pragma once
// From what a mesh file holds to a mesh that is right: what all readers share.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sim/scene/scene.h"

namespace cloth::pipeline {

/// Where in a file something is wrong; line 0: no line can be named.
struct FilePlace {
    const std::filesystem::path& path;
    std::size_t line = 0;

    /// Throws Error(invalid_scene): "path:line: message".
    [[noreturn]] void fail(const std::string& message) const;
    /// As fail(), of a face that is no triangle.
    [[noreturn]] void fail_polygon(std::size_t face, std::int64_t corners) const;
};

/// A mesh as it is read; indices are checked once all vertices are known.
struct MeshDraft {
    std::vector<std::array<double, 3>> positions;        ///< [m]
    std::vector<std::array<std::int64_t, 3>> triangles;  ///< counted from 0
    std::vector<std::size_t> lines;                      ///< of each triangle; empty where there are none
};

/// Throws Error(invalid_scene) without vertices, without faces where they are wanted, and where a face refers
/// to a vertex that is not there.
MeshData checked_mesh(const MeshDraft& draft, const std::filesystem::path& path, bool faces_wanted);

}  // namespace cloth::pipeline
