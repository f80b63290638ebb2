#pragma once
// What passes through what, found without the code of contact.

#include <algorithm>
#include <array>
#include <vector>

#include "sim/geometry/collide.h"
#include "sim/motion/placement.h"
#include "sim/shapes/shapes.h"
#include "sim/simulation.h"

namespace cloth::testing {

/// Every triangle of the cloth against every other and against colliders'.
inline int crossing_triangles(const Simulation& simulation) {
    const Model& model = simulation.model();
    std::vector<std::array<Vec3, 3>> triangles;
    std::vector<std::array<int, 3>> corners;
    const VecX& x = simulation.state().positions;
    for (int t = 0; t < model.triangle_count(); ++t) {
        corners.push_back({model.triangles(t, 0), model.triangles(t, 1), model.triangles(t, 2)});
        triangles.push_back({});
        for (int k = 0; k < 3; ++k) triangles.back()[k] = x.segment<3>(3 * corners.back()[k]);
    }
    const std::size_t cloth = triangles.size();
    for (const ColliderDesc& collider : model.scene.colliders) {
        const Placement placement = placement_at(collider, simulation.state().time);
        const ContactPrimitive primitive = make_shape(collider, placement)->primitive();
        for (const auto& triangle : primitive.triangles) {
            triangles.push_back({});
            for (int k = 0; k < 3; ++k) triangles.back()[k] = placement(primitive.points[triangle[k]]);
        }
    }
    std::vector<std::array<Vec3, 2>> boxes;
    for (const auto& t : triangles) {
        boxes.push_back({t[0].cwiseMin(t[1]).cwiseMin(t[2]), t[0].cwiseMax(t[1]).cwiseMax(t[2])});
    }
    int found = 0;
    for (std::size_t i = 0; i < cloth; ++i) {
        for (std::size_t j = i + 1; j < triangles.size(); ++j) {
            if ((boxes[i][0].array() > boxes[j][1].array()).any()) continue;
            if ((boxes[j][0].array() > boxes[i][1].array()).any()) continue;
            bool shared = false;
            for (int a = 0; a < 3 && j < cloth; ++a) {
                for (int b = 0; b < 3; ++b) shared = shared || corners[i][a] == corners[j][b];
            }
            if (!shared) found += triangles_cross(triangles[i], triangles[j]);
        }
    }
    return found;
}

/// Points spread over the cloth's triangles that lie inside a sphere, a capsule or a half-space.
inline int points_inside(const Simulation& simulation) {
    const Model& model = simulation.model();
    const VecX& x = simulation.state().positions;
    int found = 0;
    for (const ColliderDesc& c : model.scene.colliders) {
        const Placement placement = placement_at(c, simulation.state().time);
        const Vec3 center = placement(c.center), normal = placement.rotation * c.normal.normalized();
        std::array<Vec3, 2> ends{center, center};
        if (c.shape == Shape::capsule) {
            const ContactPrimitive segment = make_shape(c)->primitive();
            ends = {placement(segment.points[0]), placement(segment.points[1])};
        }
        if (c.shape != Shape::capsule && c.shape != Shape::sphere && c.shape != Shape::plane) continue;
        const Vec3 axis = ends[1] - ends[0];
        auto inside = [&](const Vec3& p) {
            if (c.shape == Shape::plane) return normal.dot(p - center) < 0.0;
            const double square = axis.squaredNorm();
            const double s = square > 0.0 ? std::clamp(axis.dot(p - ends[0]) / square, 0.0, 1.0) : 0.0;
            return (p - ends[0] - s * axis).norm() < c.radius;
        };
        constexpr int cuts = 5;
        for (int t = 0; t < model.triangle_count(); ++t) {
            const auto corner = [&](int k) { return Vec3(x.segment<3>(3 * model.triangles(t, k))); };
            const Vec3 a = corner(0), u = (corner(1) - a) / cuts, v = (corner(2) - a) / cuts;
            for (int i = 0; i <= cuts; ++i) {
                for (int j = 0; i + j <= cuts; ++j) found += inside(a + i * u + j * v);
            }
        }
    }
    return found;
}

}  // namespace cloth::testing
