#include "sim/contact/moving_colliders.h"

#include <algorithm>

namespace cloth {

MovingColliders::MovingColliders(const ContactSystem& system)
    : system_(system),
      body_on_(system.mesh.bodies.size(), 1),
      positions_(system.rest.tail(system.rest.size() - 3 * system.cloth_vertices)),
      targets_(positions_) {
    int count = 0;
    for (const ContactBody& body : system.mesh.bodies) {
        if (body.collider) count = std::max(count, body.index + 1);
    }
    for (const auto& plane : system.planes) {
        count = std::max(count, plane.collider + 1);
        planes_.push_back({plane.point, plane.normal});
    }
    first_vertex_.assign(system_.mesh.bodies.size(), -1);
    for (int v = system_.mesh.vertex_count() - 1; v >= 0; --v) first_vertex_[system_.mesh.vertex_body[v]] = v;
    plane_targets_ = planes_;
    from_.resize(count);
    to_.resize(count);
    on_.assign(count, 1);
}

void MovingColliders::begin(const std::vector<Placement>& from, const std::vector<Placement>& to,
                            const std::vector<std::uint8_t>& on) {
    const int n = system_.cloth_vertices;
    from_ = from;
    to_ = to;
    on_ = on;
    for (std::size_t b = 0; b < body_on_.size(); ++b) {
        const ContactBody& body = system_.mesh.bodies[b];
        body_on_[b] = !body.collider || on_[body.index];
    }
    for (int v = n; v < system_.mesh.vertex_count(); ++v) {
        const int c = system_.collider_of(v);
        const Vec3 p = system_.rest.segment<3>(3 * v);
        const int own = v - first_vertex_[system_.mesh.vertex_body[v]];
        const auto place = [&](const Placement& at) { return at(at.bent ? Vec3(at.bent->row(own)) : p); };
        positions_.segment<3>(3 * (v - n)) = place(from_[c]);
        targets_.segment<3>(3 * (v - n)) = place(to_[c]);
    }
    placed_ = positions_ == targets_;
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const auto& plane = system_.planes[p];
        const Placement &start = from_[plane.collider], &end = to_[plane.collider];
        planes_[p] = {start(plane.point), start.rotation * plane.normal};
        plane_targets_[p] = {end(plane.point), end.rotation * plane.normal};
        placed_ = placed_ && planes_[p].point == plane_targets_[p].point &&
                  planes_[p].normal == plane_targets_[p].normal;
    }
}

void MovingColliders::place(double share) {
    if (share >= 1.0) {
        positions_ = targets_;
        planes_ = plane_targets_;
        placed_ = true;
        return;
    }
    positions_ += share * (targets_ - positions_);
    for (std::size_t p = 0; p < planes_.size(); ++p) {
        const Plane& target = plane_targets_[p];
        planes_[p].point += share * (target.point - planes_[p].point);
        planes_[p].normal = ((1.0 - share) * planes_[p].normal + share * target.normal).normalized();
    }
}

Vec3 MovingColliders::way_in_stage(int collider, const Vec3& p) const {
    const Placement &from = from_[collider], &to = to_[collider];
    const Vec3 at_rest = from.rotation.transpose() * (p - from.translation);
    return to(at_rest) - p;
}

}  // namespace cloth
