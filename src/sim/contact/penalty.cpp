#include "sim/contact/penalty.h"

#include <algorithm>
#include <cmath>

namespace cloth {

template <class F>
void ColliderContactEnergy::for_each_contact(const VecX& x, const F& body) const {
    for (const Collider& collider : colliders_) {
        for (int i = 0; i < x.size() / 3; ++i) {
            const SurfacePoint s = collider.shape->distance(x.segment<3>(3 * i));
            if (s.distance < collider.offset) body(collider, i, s);
        }
    }
}

ColliderContactEnergy::ColliderContactEnergy(const std::vector<ColliderDesc>& colliders,
                                             const std::vector<std::uint8_t>& collider_on, const VecX& start,
                                             double stiffness, double time_step, double sliding_speed)
    : stiffness_(stiffness), sliding_way_(sliding_speed * time_step) {
    for (std::size_t c = 0; c < colliders.size(); ++c) {
        if (!collider_on[c]) continue;
        colliders_.push_back({make_shape(colliders[c]), colliders[c].contact_offset, colliders[c].friction});
    }
    for_each_contact(start, [&](const Collider& collider, int i, const SurfacePoint& s) {
        friction_.push_back({i, s.normal, start.segment<3>(3 * i),
                             collider.friction * stiffness_ * (collider.offset - s.distance)});
    });
}

double ColliderContactEnergy::value(const VecX& x) const {
    double sum = 0.0;
    for_each_contact(x, [&](const Collider& collider, int, const SurfacePoint& s) {
        const double depth = collider.offset - s.distance;
        sum += 0.5 * stiffness_ * depth * depth;
    });
    for (const Friction& f : friction_) {
        Vec3 u = x.segment<3>(3 * f.vertex) - f.start;
        u -= f.normal * f.normal.dot(u);
        const double y = u.norm();
        sum += f.force * (y < sliding_way_ ? 0.5 * y * y / sliding_way_ : y - 0.5 * sliding_way_);
    }
    return sum;
}

void ColliderContactEnergy::add_gradient(const VecX& x, VecX& g) const {
    for_each_contact(x, [&](const Collider& collider, int i, const SurfacePoint& s) {
        g.segment<3>(3 * i) -= stiffness_ * (collider.offset - s.distance) * s.normal;
    });
    for (const Friction& f : friction_) {
        Vec3 u = x.segment<3>(3 * f.vertex) - f.start;
        u -= f.normal * f.normal.dot(u);
        g.segment<3>(3 * f.vertex) += f.force / std::max(u.norm(), sliding_way_) * u;
    }
}

void ColliderContactEnergy::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    for_each_contact(x, [&](const Collider& collider, int i, const SurfacePoint& s) {
        Mat3& block = H.blocks[pattern_->diagonal(i)];
        const Mat3 nn = s.normal * s.normal.transpose();
        block += stiffness_ * nn;
        if (kind == HessianKind::exact) {
            // -k (d̂ - d) d²d/dx²: negative semi-definite, so a projection drops it.
            block -= stiffness_ * (collider.offset - s.distance) / s.level_radius * (Mat3::Identity() - nn);
        }
    });
    for (const Friction& f : friction_) {
        const Mat3 tangent = Mat3::Identity() - f.normal * f.normal.transpose();
        const Vec3 u = tangent * (x.segment<3>(3 * f.vertex) - f.start);
        const double y = u.norm();
        Mat3& block = H.blocks[pattern_->diagonal(f.vertex)];
        block += f.force / std::max(y, sliding_way_) * tangent;
        if (y >= sliding_way_) block -= f.force / (y * y * y) * u * u.transpose();
    }
}

}  // namespace cloth
