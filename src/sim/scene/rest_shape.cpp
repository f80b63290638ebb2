#include "sim/scene/rest_shape.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <Eigen/Geometry>

namespace cloth {
namespace {

/// Twice the signed area of triangle `t` on the map.
double twice_area(const TexturePoints& uv, Eigen::Index t) {
    const Vec2 a = uv.row(3 * t + 1) - uv.row(3 * t), b = uv.row(3 * t + 2) - uv.row(3 * t);
    return a.x() * b.y() - a.y() * b.x();
}

std::string triangle_text(Eigen::Index t) {
    return "triangle " + std::to_string(t) + " (counted from 0)";
}

}  // namespace

void check_uv(const MeshData& mesh, const std::string& key) {
    const TexturePoints& uv = mesh.uv;
    if (uv.rows() == 0)
        throw SceneError(key, "is \"uv\", but the mesh has no texture coordinates; unwrap it in a modeller");
    // An edge of the mesh, from its lower vertex to its higher one: the first triangle's corners there.
    struct Side {
        Eigen::Index triangle;
        Vec2 low, high;
        bool left;  ///< of low → high on the map
    };
    std::map<std::array<int, 2>, Side> sides;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        if (!uv.middleRows(3 * t, 3).allFinite())
            throw SceneError(key, "is \"uv\", but " + triangle_text(t) + " has no texture coordinates");
        double longest = 0.0;
        for (int k = 0; k < 3; ++k)
            longest = std::max(longest, (uv.row(3 * t + k) - uv.row(3 * t + (k + 1) % 3)).squaredNorm());
        const double area = twice_area(uv, t);
        if (!(std::abs(area) > 1e-7 * longest))
            throw SceneError(
                key, "is \"uv\", but " + triangle_text(t) + " has no area there; unwrap it in a modeller");
        for (int k = 0; k < 3; ++k) {
            const int a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
            const Vec2 at_a = uv.row(3 * t + k), at_b = uv.row(3 * t + (k + 1) % 3);
            const bool up = a < b;
            const Side side{t, up ? at_a : at_b, up ? at_b : at_a, (area > 0.0) == up};
            const auto [other, first] =
                sides.emplace(std::array<int, 2>{std::min(a, b), std::max(a, b)}, side);
            if (first) continue;
            const Side& o = other->second;
            if (o.low == side.low && o.high == side.high && o.left == side.left)
                throw SceneError(key, "is \"uv\", but there " + triangle_text(t) +
                                          " lies folded over triangle " + std::to_string(o.triangle) +
                                          ", with which it shares an edge; unwrap the mesh without overlaps");
        }
    }
}

double natural_uv_scale(const MeshData& mesh) {
    double area = 0.0, map_area = 0.0;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const Vec3 a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                   c = mesh.positions.row(mesh.triangles(t, 2));
        area += (b - a).cross(c - a).norm();
        map_area += std::abs(twice_area(mesh.uv, t));
    }
    return std::sqrt(area / map_area);
}

Points rest_corners(const ClothDesc& cloth, const MeshData& rest) {
    const Eigen::Index corners = 3 * rest.triangles.rows();
    Points X(corners, 3);
    if (cloth.rest == RestShape::uv) {
        const double scale = cloth.uv_scale ? *cloth.uv_scale : natural_uv_scale(rest);
        X << scale * rest.uv, VecX::Zero(corners);
        return X;
    }
    for (Eigen::Index i = 0; i < corners; ++i)
        X.row(i) = rest.positions.row(rest.triangles(i / 3, static_cast<int>(i % 3)));
    return X;
}

const MeshPart* find_part(const MeshData& mesh, const std::string& name) {
    const auto found = std::find_if(mesh.parts.begin(), mesh.parts.end(),
                                    [&](const MeshPart& part) { return part.name == name; });
    return found == mesh.parts.end() ? nullptr : &*found;
}

std::string unknown_part(const MeshData& mesh, const std::string& name) {
    std::string known;
    for (const MeshPart& part : mesh.parts) known += (known.empty() ? "" : ", ") + part.name;
    return "has no part \"" + name + "\"; " +
           (known.empty() ? "its mesh names none: materials and groups of a file are parts"
                          : "its parts: " + known);
}

std::vector<int> part_of_triangles(const Scene& scene, std::size_t cloth, const MeshData& rest) {
    std::vector<int> of(static_cast<std::size_t>(rest.triangles.rows()), -1);
    for (std::size_t p = 0; p < scene.parts.size(); ++p) {
        if (static_cast<std::size_t>(scene.parts[p].cloth) != cloth) continue;
        const MeshPart* part = find_part(rest, scene.parts[p].name);
        if (part == nullptr)
            throw SceneError(
                "part[" + std::to_string(p) + "].name",
                "cloth \"" + scene.cloths[cloth].name + "\" " + unknown_part(rest, scene.parts[p].name));
        for (const int t : part->triangles) of[static_cast<std::size_t>(t)] = static_cast<int>(p);
    }
    return of;
}

}  // namespace cloth
