#pragma once
// What several shapes are made of. Internal.

#include <array>

#include "sim/shapes/shapes.h"

namespace cloth {

/// A sphere whose halves stand apart by the way between `ends`, the lower first; its poles point along
/// `turn`'s second axis.
Surface round_surface(const std::array<Vec3, 2>& ends, const Mat3& turn, double radius);

/// Each triangle with corners and normals of its own.
Surface flat_surface(const MeshData& mesh);

/// p → center + R (scale p)
MeshData placed(MeshData mesh, const Vec3& center, const Mat3& R, double scale = 1.0);

/// The triangles of a mesh, and how far outside of them contact begins [m].
ContactPrimitive triangle_primitive(const MeshData& mesh, double radius);

}  // namespace cloth
