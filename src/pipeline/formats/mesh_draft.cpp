#include "pipeline/formats/mesh_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "base/text.h"
#include "pipeline/formats/error.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

void FilePlace::fail(const std::string& message) const {
    const std::string place = path.string() + (line ? fmt::format(":{}", line) : "");
    throw Error(ExitCode::invalid_scene, one_line(place + ": " + message));
}

void FilePlace::fail_polygon(std::size_t face, std::int64_t corners) const {
    fail(
        fmt::format("face {} (counted from 0) has {} corners; a cloth has triangles only: triangulate the "
                    "mesh first",
                    face, corners));
}

MeshData checked_mesh(const MeshDraft& draft, const fs::path& path, bool faces_wanted) {
    const std::size_t n = draft.positions.size(), m = draft.triangles.size();
    const FilePlace whole{path};
    if (n == 0) whole.fail("has no vertices");
    if (faces_wanted && m == 0) whole.fail("has no faces");
    if (std::max(n, m) > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        whole.fail("is too large");
    MeshData mesh;
    mesh.positions.resize(static_cast<Eigen::Index>(n), 3);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            mesh.positions(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                draft.positions[i][k];
        }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(m), 3);
    for (std::size_t t = 0; t < m; ++t) {
        for (std::size_t k = 0; k < 3; ++k) {
            const std::int64_t v = draft.triangles[t][k];
            if (v < 0 || v >= static_cast<std::int64_t>(n)) {
                const FilePlace place{path, draft.lines.empty() ? 0 : draft.lines[t]};
                place.fail(
                    fmt::format("face {} refers to vertex {}; there are {}, both counted from 0", t, v, n));
            }
            mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = static_cast<int>(v);
        }
    }
    return mesh;
}

}  // namespace cloth::pipeline
