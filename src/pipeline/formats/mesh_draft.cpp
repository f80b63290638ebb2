#include "pipeline/formats/mesh_draft.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/triangulate.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The triangles of face `f`, whose vertices are all there.
std::vector<std::array<int, 3>> triangles_of(const MeshDraft& draft, std::size_t f, const FilePlace& place) {
    const auto face = draft.face(f);
    std::vector<Vec3> polygon;
    for (const std::int64_t v : face) {
        const auto& p = draft.positions[static_cast<std::size_t>(v)];
        polygon.emplace_back(p[0], p[1], p[2]);
    }
    const auto cut = triangulate(polygon);
    if (cut.empty())
        place.fail(
            fmt::format("face {} (counted from 0) has {} corners and no triangles: it crosses itself or has "
                        "no area; triangulate the mesh in a modeller",
                        f, face.size()));
    return cut;
}

void check_face(const MeshDraft& draft, std::size_t f, const FilePlace& place) {
    const auto face = draft.face(f);
    if (face.size() < 3)
        place.fail(
            fmt::format("face {} (counted from 0) has {} corners; a face has three or more", f, face.size()));
    if (face.size() > most_corners)
        place.fail(
            fmt::format("face {} (counted from 0) has {} corners, more than {}: triangulate the mesh in a "
                        "modeller",
                        f, face.size(), most_corners));
    for (const std::int64_t v : face) {
        if (v < 0 || v >= static_cast<std::int64_t>(draft.positions.size()))
            place.fail(fmt::format("face {} refers to vertex {}; there are {}, both counted from 0", f, v,
                                   draft.positions.size()));
    }
}

/// A name that an OBJ can hold.
std::string plain(std::string name) {
    for (char& c : name) {
        const auto code = static_cast<unsigned char>(c);
        if (code <= ' ' || code == 0x7f || c == '#' || c == '\\') c = '_';
    }
    return name;
}

}  // namespace

void FilePlace::fail(const std::string& message) const {
    const std::string place = path.string() + (line ? fmt::format(":{}", line) : "");
    throw Error(ExitCode::invalid_scene, one_line(place + ": " + message));
}

LoadedMesh checked_mesh(MeshDraft draft, const fs::path& path, bool faces_wanted) {
    const std::size_t n = draft.positions.size();
    const FilePlace whole{path};
    if (n == 0) whole.fail("has no vertices");
    if (faces_wanted && draft.face_count() == 0) whole.fail("has no faces");
    if (std::max(n, draft.corners.size()) > static_cast<std::size_t>(std::numeric_limits<int>::max() / 3))
        whole.fail("is too large");
    LoadedMesh loaded{.mesh = {}, .notes = std::move(draft.notes)};
    MeshData& mesh = loaded.mesh;
    mesh.positions.resize(static_cast<Eigen::Index>(n), 3);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t k = 0; k < 3; ++k) {
            mesh.positions(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(k)) =
                draft.positions[i][k];
        }
    }
    if (!faces_wanted) return loaded;
    std::vector<std::array<int, 3>> triangles;
    std::vector<std::array<std::size_t, 3>> corners;  // of each triangle, in the draft
    std::vector<std::size_t> first_triangle;          // of each face
    std::size_t polygons = 0, pieces = 0;
    for (std::size_t f = 0; f < draft.face_count(); ++f) {
        const FilePlace place{path, draft.lines.empty() ? 0 : draft.lines[f]};
        check_face(draft, f, place);
        const auto face = draft.face(f);
        const auto vertex = [&](int corner) {
            return static_cast<int>(face[static_cast<std::size_t>(corner)]);
        };
        const auto add = [&](int a, int b, int c) {
            const std::size_t first = f == 0 ? 0 : draft.ends[f - 1];
            const auto corner = [&](int k) { return first + static_cast<std::size_t>(k); };
            triangles.push_back({vertex(a), vertex(b), vertex(c)});
            corners.push_back({corner(a), corner(b), corner(c)});
        };
        first_triangle.push_back(triangles.size());
        if (face.size() == 3) {
            add(0, 1, 2);
            continue;
        }
        const auto cut = triangles_of(draft, f, place);
        for (const auto& [a, b, c] : cut) add(a, b, c);
        ++polygons;
        pieces += cut.size();
    }
    first_triangle.push_back(triangles.size());
    mesh.triangles.resize(static_cast<Eigen::Index>(triangles.size()), 3);
    for (std::size_t t = 0; t < triangles.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k)
            mesh.triangles(static_cast<Eigen::Index>(t), static_cast<Eigen::Index>(k)) = triangles[t][k];
    }
    if (!draft.uv.empty()) {
        mesh.uv.resize(static_cast<Eigen::Index>(3 * corners.size()), 2);
        for (std::size_t t = 0; t < corners.size(); ++t)
            for (std::size_t k = 0; k < 3; ++k)
                mesh.uv.row(static_cast<Eigen::Index>(3 * t + k)) << draft.uv[corners[t][k]][0],
                    draft.uv[corners[t][k]][1];
    }
    std::map<std::string, std::set<int>> parts;
    for (const auto& [name, faces] : draft.parts)
        for (const std::size_t f : faces)
            for (std::size_t t = first_triangle[f]; t < first_triangle[f + 1]; ++t)
                parts[plain(name)].insert(static_cast<int>(t));
    for (const auto& [name, of] : parts) mesh.parts.push_back({name, {of.begin(), of.end()}});
    if (polygons > 0)
        loaded.notes.push_back(fmt::format("{} of more than three corners cut into {} triangles",
                                           plural(polygons, "face"), pieces));
    return loaded;
}

}  // namespace cloth::pipeline
