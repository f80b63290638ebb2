#include "sim/motion/carrier.h"

#include <limits>

#include "sim/geometry/collide.h"
#include "sim/motion/placement.h"

namespace cloth {
namespace {

using Corners = std::array<Vec3, 3>;

Corners corners_at(const Placement& placement, const std::array<int, 3>& corners) {
    const auto at = [&](int k) {
        return placement(placement.bent->row(corners[static_cast<std::size_t>(k)]).transpose());
    };
    return {at(0), at(1), at(2)};
}

/// Columns: along the first edge, across it, off the plane; of a triangle without area some way across.
Mat3 frame_of(const Corners& x) {
    const Vec3 along = (x[1] - x[0]).normalized();
    Vec3 off = along.cross(x[2] - x[0]);
    off = off.norm() > 0.0 ? Vec3(off.normalized()) : along.unitOrthogonal();
    Mat3 frame;
    frame << along, off.cross(along), off;
    return frame;
}

Vec3 point_of(const Corners& x, const std::array<double, 3>& weights) {
    return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2];
}

}  // namespace

Carrier::Carrier(const ColliderDesc& collider, const std::vector<Vec3>& start) : collider_(collider) {
    const Placement placement = placement_at(collider_, 0.0);
    for (const Vec3& p : start) {
        Hold& hold = holds_.emplace_back();
        if (!placement.bent) {
            hold.off = placement.rotation.transpose() * (p - placement.translation);
            continue;
        }
        double least = std::numeric_limits<double>::infinity();
        const Triangles& triangles = collider_.mesh->triangles;
        for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
            const std::array<int, 3> corners{triangles(t, 0), triangles(t, 1), triangles(t, 2)};
            const Corners x = corners_at(placement, corners);
            const Nearest nearest = nearest_vertex_face({p, x[0], x[1], x[2]});
            if (!(nearest.distance_squared < least)) continue;
            least = nearest.distance_squared;
            hold.corners = corners;
            hold.weights = {-nearest.weights[1], -nearest.weights[2], -nearest.weights[3]};
            hold.off = frame_of(x).transpose() * (p - point_of(x, hold.weights));
        }
    }
}

std::vector<Vec3> Carrier::places(double time) const {
    const Placement placement = placement_at(collider_, time);
    std::vector<Vec3> all;
    for (const Hold& hold : holds_) {
        if (!placement.bent) {
            all.push_back(placement(hold.off));
            continue;
        }
        const Corners x = corners_at(placement, hold.corners);
        all.push_back(point_of(x, hold.weights) + frame_of(x) * hold.off);
    }
    return all;
}

}  // namespace cloth
