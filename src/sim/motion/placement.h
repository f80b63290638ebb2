#pragma once
// Where what moves by command stands at a time.

#include <memory>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Where a collider stands: p → R p + t.
struct Placement {
    Mat3 rotation = Mat3::Identity();
    Vec3 translation = Vec3::Zero();
    /// Of a mesh that bends: what p is of each vertex (mesh_cache.h); null: where the shape has it.
    std::shared_ptr<const Points> bent{};

    Vec3 operator()(const Vec3& p) const { return rotation * p + translation; }
};

/// Where a collider has gone at `time` from where it stands without keys and spin.
Placement placement_at(const ColliderDesc& collider, double time);
std::vector<Placement> placements_at(const std::vector<ColliderDesc>& colliders, double time);

}  // namespace cloth
