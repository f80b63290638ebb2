#pragma once
// Colliders as geometry, where they stand at the start.

#include <array>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Surface of a box, a cylinder or a mesh where it stands at the start. A cylinder is a prism of 64 sides
/// through the mean of its inner and outer radius: off by 0.06 % of the radius at most.
MeshData collider_surface(const ColliderDesc& collider);

/// Ends of a capsule's axis at the start [m].
std::array<Vec3, 2> capsule_ends(const ColliderDesc& collider);

/// How far from its surface's points, ends of its axis or centre a collider's contact begins [m].
double contact_reach(const ColliderDesc& collider);

}  // namespace cloth
