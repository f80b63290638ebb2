#pragma once
// Colliders as geometry, where they stand at the start: what is drawn, how far away it is, what contact
// meets.
//
// A new shape is an entry of Shape with its fields (scene.h), its name in scene files, and one file here that
// makes it; the compiler lists the switch in shapes.cpp that does not know it.

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/motion/placement.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Triangles to draw.
struct Surface {
    Points positions, normals;  ///< shape (n, 3) [m] and of unit length
    Triangles triangles;
    bool endless = false;  ///< the middle of a plane that has no edge
};

/// Of a point in space: its distance from a shape's surface, and the outward normal of the nearest point
/// there.
struct SurfacePoint {
    double distance;  ///< negative inside; of a mesh, which may be open, without sign [m]
    Vec3 normal;      ///< gradient of the distance, where that has one
    /// Radius of the level surface through the point, of shapes with one curvature alone: the distance's
    /// second derivative is (1 - nnᵀ)/radius [m].
    double level_radius = std::numeric_limits<double>::infinity();
};

/// What contact meets: a half-space, or points, segments and triangles. It begins `radius` outside of them.
struct ContactPrimitive {
    struct HalfSpace {
        Vec3 point, normal;
    };
    double radius = 0.0;  ///< [m]
    std::optional<HalfSpace> half_space{};
    std::vector<Vec3> points{};
    std::vector<std::array<int, 2>> segments{};
    std::vector<std::array<int, 3>> triangles{};  ///< counter-clockwise from outside
};

class ColliderShape {
  public:
    virtual ~ColliderShape() = default;
    virtual Surface surface() const = 0;
    virtual SurfacePoint distance(const Vec3& point) const = 0;
    /// A sphere is a point and a capsule a segment, both exact.
    virtual ContactPrimitive primitive() const = 0;
};

/// A mesh that bends is as it is at time 0.
std::unique_ptr<const ColliderShape> make_shape(const ColliderDesc& collider);
/// As it is bent in a placement, without the placement's own turn and shift.
std::unique_ptr<const ColliderShape> make_shape(const ColliderDesc& collider, const Placement& placement);

}  // namespace cloth
