#pragma once
// Colliders as geometry: their surfaces, where they stand at a time, and all that contact sees of a scene.

#include <vector>

#include "sim/barrier_contact.h"
#include "sim/model.h"
#include "sim/scene.h"

namespace cloth {

/// Surface of a box, a cylinder or a mesh where it stands at the start. A cylinder is a prism of 64 sides
/// through the mean of its inner and outer radius: off by 0.06 % of the radius at most.
MeshData collider_surface(const ColliderDesc& collider);

/// Ends of a capsule's axis at the start [m].
std::array<Vec3, 2> capsule_ends(const ColliderDesc& collider);

/// Where a collider has gone at `time` from where it stands without keys and spin.
Placement placement_at(const ColliderDesc& collider, double time);
std::vector<Placement> placements_at(const std::vector<ColliderDesc>& colliders, double time);

/// Cloths and colliders as contact sees them: a sphere is a point and a capsule an edge with a radius, both
/// exact; a plane is a half-space; the others are their triangles.
ContactSystem make_contact_system(const Model& model);

/// Thrown where a step starts with things that overlap.
class OverlapError : public std::runtime_error {
  public:
    OverlapError(const std::string& message, std::vector<int> numbers,
                 std::vector<std::array<Vec3, 3>> corners)
        : std::runtime_error(message), cloth_triangles(std::move(numbers)), triangles(std::move(corners)) {}
    std::vector<int> cloth_triangles;            ///< over all cloths
    std::vector<std::array<Vec3, 3>> triangles;  ///< corners of cloth's and colliders', as they stand [m]
};

/// Throws OverlapError where anything overlaps at x, naming up to ten pairs.
void require_no_overlap(const Model& model, const BarrierContact& contact, const VecX& x);

}  // namespace cloth
