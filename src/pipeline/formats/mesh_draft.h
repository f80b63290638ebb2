#pragma once
// From what a mesh file holds to a mesh that is right: what all readers share.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <span>
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
};

/// A mesh as it is read; its faces are polygons, indices are checked once all vertices are known.
struct MeshDraft {
    std::vector<std::array<double, 3>> positions;
    std::vector<std::int64_t> corners;  ///< of all faces, one behind the other, counted from 0
    std::vector<std::size_t> ends;      ///< of each face: where its corners end
    std::vector<std::size_t> lines;     ///< of each face; empty where there are none
    std::vector<std::string> notes;     ///< what the file has and a mesh does not
    /// Texture coordinates of each of `corners`, NaN for one that has none; empty where none has.
    std::vector<std::array<double, 2>> uv;
    /// Faces that the file names, rising, by the name of their material, group or object.
    std::map<std::string, std::vector<std::size_t>> parts;

    std::size_t face_count() const { return ends.size(); }
    /// The corners of a face.
    std::span<const std::int64_t> face(std::size_t f) const {
        const std::size_t begin = f == 0 ? 0 : ends[f - 1];
        return {corners.data() + begin, ends[f] - begin};
    }
    void add_face(std::span<const std::int64_t> face) {
        corners.insert(corners.end(), face.begin(), face.end());
        ends.push_back(corners.size());
    }
};

/// A mesh from a file, and what a user should know of how it became one.
struct LoadedMesh {
    MeshData mesh;
    std::vector<std::string> notes;
};

/// A mesh to be written. What has no rows is left out.
struct MeshOut {
    /// A sheet of one cloth's.
    struct Object {
        std::string name;
        Eigen::Index first_vertex, vertex_count, first_triangle, triangle_count;
    };
    MeshOut(const MeshData& mesh) : positions(mesh.positions), triangles(mesh.triangles) {}
    MeshOut(const Points& all_positions, const Triangles& all_triangles)
        : positions(all_positions), triangles(all_triangles) {}

    const Points& positions;
    const Triangles& triangles;
    Points normals{};               ///< of unit length, one a vertex
    TexturePoints uv{};             ///< texture coordinates, one a vertex
    std::vector<Object> objects{};  ///< one behind the other, or none
};

/// Cuts polygons into triangles, which a note tells, and writes names of parts with _ for blanks and signs
/// that an OBJ could not hold; without `faces_wanted` there are vertices alone. Throws
/// Error(invalid_scene) without vertices or wanted faces, and where one of these has fewer than three
/// corners, refers to a vertex that is not there or cannot be cut.
LoadedMesh checked_mesh(MeshDraft draft, const std::filesystem::path& path, bool faces_wanted);

}  // namespace cloth::pipeline
