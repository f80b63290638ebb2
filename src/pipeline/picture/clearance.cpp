#include "pipeline/picture/clearance.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "sim/motion/placement.h"

namespace cloth::pipeline {
namespace {

using Triangle = std::array<Vec3, 3>;

std::vector<std::array<int, 3>> triangle_list(const Triangles& triangles, int first_vertex) {
    std::vector<std::array<int, 3>> list;
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        list.push_back(
            {triangles(t, 0) - first_vertex, triangles(t, 1) - first_vertex, triangles(t, 2) - first_vertex});
    return list;
}

/// Between two triangles, as far as it is below `reach`, else at least that [m].
double distance(const Triangle& a, const Triangle& b, double reach) {
    if (triangles_cross(a, b)) return 0.0;
    double least = reach * reach;
    const auto meet = [&](PairKind kind, const FourPoints& x) {
        if (!boxes_apart(kind, x, reach)) least = std::min(least, nearest(kind, x).distance_squared);
    };
    for (int i = 0; i < 3; ++i) {
        meet(PairKind::vertex_face, {a[i], b[0], b[1], b[2]});
        meet(PairKind::vertex_face, {b[i], a[0], a[1], a[2]});
        for (int k = 0; k < 3; ++k) meet(PairKind::edge_edge, {a[i], a[(i + 1) % 3], b[k], b[(k + 1) % 3]});
    }
    return std::sqrt(least);
}

}  // namespace

Clearance::Clearance(const Model& model, std::optional<double> ground) : model_(model) {
    std::vector<Vec3> points;
    first_vertex_.assign(model.scene.colliders.size(), -1);
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& cloth = model.cloths[c];
        mesh_.add_body({.collider = false, .index = static_cast<int>(c)}, cloth.vertex_count,
                       triangle_list(model.triangles.middleRows(cloth.first_triangle, cloth.triangle_count),
                                     cloth.first_vertex));
    }
    for (int v = 0; v < model.vertex_count(); ++v) points.emplace_back(model.rest_positions.row(v));
    for (std::size_t c = 0; c < model.scene.colliders.size(); ++c) {
        const ColliderDesc& collider = model.scene.colliders[c];
        if (!collider.drawn) continue;
        const auto shape = make_shape(collider);
        if (const auto primitive = shape->primitive(); primitive.half_space) {
            planes_.push_back(
                {static_cast<int>(c), primitive.half_space->point, primitive.half_space->normal});
            continue;
        }
        const Surface surface = shape->surface();
        first_vertex_[c] = mesh_.vertex_count();
        mesh_.add_body({.collider = true, .index = static_cast<int>(c)},
                       static_cast<int>(surface.positions.rows()), triangle_list(surface.triangles, 0));
        for (Eigen::Index v = 0; v < surface.positions.rows(); ++v)
            points.emplace_back(surface.positions.row(v));
    }
    if (ground) planes_.push_back({-1, *ground * Vec3::UnitY(), Vec3::UnitY()});
    at_start_.resize(3 * static_cast<Eigen::Index>(points.size()));
    for (std::size_t v = 0; v < points.size(); ++v)
        at_start_.segment<3>(3 * static_cast<Eigen::Index>(v)) = points[v];
    broad_phase_.emplace(mesh_, at_start_);
}

Clearance::Room Clearance::find(const State& state, const std::vector<double>& reach) const {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    const int cloth_vertices = model_.vertex_count(), cloth_faces = model_.triangle_count();
    Room room{std::vector<double>(cloth_faces, infinity), std::vector<double>(cloth_faces, infinity)};
    if (std::all_of(reach.begin(), reach.end(), [](double r) { return r == 0.0; })) return room;
    std::vector<Placement> placements;
    for (const ColliderDesc& collider : model_.scene.colliders)
        placements.push_back(placement_at(collider, state.time));
    const auto is_on = [&](int collider) { return collider < 0 || state.collider_on[collider] != 0; };

    VecX x = at_start_;
    x.head(3 * cloth_vertices) = state.positions;
    std::vector<std::uint8_t> body_on;
    for (const ContactBody& body : mesh_.bodies) body_on.push_back(!body.collider || is_on(body.index));
    for (std::size_t c = 0; c < placements.size(); ++c) {
        if (!placements[c].bent || first_vertex_[c] < 0) continue;
        const Points bent = make_shape(model_.scene.colliders[c], placements[c])->surface().positions;
        x.segment(3 * first_vertex_[c], bent.size()) = Eigen::Map<const VecX>(bent.data(), bent.size());
    }
    parallel_for(mesh_.vertex_count() - cloth_vertices, [&](int i) {
        const int v = cloth_vertices + i;
        x.segment<3>(3 * v) = placements[mesh_.bodies[mesh_.vertex_body[v]].index](Vec3(x.segment<3>(3 * v)));
    });
    const auto corners = [&](int face) {
        Triangle t;
        for (int k = 0; k < 3; ++k) t[k] = x.segment<3>(3 * mesh_.faces[face][k]);
        return t;
    };

    std::vector<double> vertex_reach(mesh_.vertex_count(), 0.0);
    for (int t = 0; t < cloth_faces; ++t)
        for (const int v : mesh_.faces[t]) vertex_reach[v] = std::max(vertex_reach[v], reach[t]);
    std::vector<MovingBox> boxes(mesh_.vertex_count());
    parallel_for(mesh_.vertex_count(), [&](int v) {
        const Vec3 place = x.segment<3>(3 * v);
        boxes[v] = MovingBox(place, place, vertex_reach[v]);
    });
    const auto pairs = broad_phase_->face_pairs(mesh_, boxes, body_on);
    std::vector<double> gaps(pairs.size());
    const auto reach_of = [&](int face) { return face < cloth_faces ? reach[face] : 0.0; };
    parallel_for(static_cast<int>(pairs.size()), [&](int p) {
        const auto [f, g] = pairs[p];
        gaps[p] = distance(corners(f), corners(g), reach_of(f) + reach_of(g));
    });

    const auto bound = [](double& value, double by) { value = std::min(value, by); };
    for (std::size_t p = 0; p < pairs.size(); ++p) {
        const auto [f, g] = pairs[p];  // f < g: f is cloth's
        const double whole = reach_of(f) + reach_of(g);
        if (!(gaps[p] < whole)) continue;
        for (const int face : {f, g}) {
            if (face >= cloth_faces) continue;
            const double share = gaps[p] * (reach[face] / whole);
            bound(room.all[face], share);
            if (g < cloth_faces) bound(room.layers[face], share);
        }
    }
    for (const Plane& plane : planes_) {
        if (!is_on(plane.collider)) continue;
        const Placement at = plane.collider < 0 ? Placement{} : placements[plane.collider];
        const Vec3 point = at(plane.point), normal = at.rotation * plane.normal;
        parallel_for(cloth_faces, [&](int t) {
            double low = infinity, high = -infinity;
            for (const Vec3& corner : corners(t)) {
                low = std::min(low, normal.dot(corner - point));
                high = std::max(high, normal.dot(corner - point));
            }
            const double gap = low > 0 ? low : high < 0 ? -high : 0.0;
            if (gap < reach[t]) bound(room.all[t], gap);
        });
    }
    return room;
}

}  // namespace cloth::pipeline
