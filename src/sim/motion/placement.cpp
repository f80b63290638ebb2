#include "sim/motion/placement.h"

#include "base/portable_math.h"
#include "sim/motion/mesh_cache.h"
#include "sim/motion/pins.h"
#include "sim/scene/mesh.h"

namespace cloth {
namespace {

/// Turn by |degrees| about the axis `degrees`.
Mat3 turn(const Vec3& degrees) {
    const double angle = degrees.norm();
    if (angle == 0.0) return Mat3::Identity();
    const Vec3 k = degrees / angle;
    const double c = cos_degrees(angle), s = sin_degrees(angle);
    Mat3 K;
    K << 0.0, -k.z(), k.y(), k.z(), 0.0, -k.x(), -k.y(), k.x(), 0.0;
    return c * Mat3::Identity() + s * K + (1.0 - c) * k * k.transpose();
}

}  // namespace

Placement placement_at(const ColliderDesc& collider, double time) {
    Placement p;
    if (collider.cache) p.bent = std::make_shared<const Points>(cached_vertices(collider, time));
    if (collider.path.empty() && collider.spin.isZero(0.0)) return p;
    const MotionKey key = motion_at(collider.path, time);
    p.rotation = rotation_matrix(key.rotate) * turn(time * collider.spin);
    p.translation = collider.center + key.translate - p.rotation * collider.center;
    return p;
}

std::vector<Placement> placements_at(const std::vector<ColliderDesc>& colliders, double time) {
    std::vector<Placement> all;
    for (const ColliderDesc& c : colliders) all.push_back(placement_at(c, time));
    return all;
}

}  // namespace cloth
