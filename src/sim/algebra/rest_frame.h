#pragma once
// Coordinates in the plane of a triangle at rest. Internal.

#include "sim/algebra/types.h"

namespace cloth {

struct RestFrame {
    Vec3 normal, t0, t1;  ///< orthonormal and right-handed; t0 and t1 span the plane
    double area;          ///< [m²]

    /// Components of a vector along t0 and t1.
    Vec2 in_plane(const Vec3& way) const { return {t0.dot(way), t1.dot(way)}; }
};

/// t0 along `warp`, laid onto the plane; where it is zero or stands upright on the plane, along the first
/// edge. Requires a triangle of non-zero area.
RestFrame make_rest_frame(const Vec3& X0, const Vec3& X1, const Vec3& X2, const Vec3& warp = Vec3::Zero());

/// Row i: gradient of shape function i in the frame [1/m].
Mat32 shape_gradients(const RestFrame& frame, const Vec3& X0, const Vec3& X1, const Vec3& X2);

}  // namespace cloth
