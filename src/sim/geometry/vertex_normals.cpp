#include "sim/geometry/vertex_normals.h"

namespace cloth {

Points vertex_normals(const Points& positions, const Triangles& triangles) {
    Points normals = Points::Zero(positions.rows(), 3);
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Vec3 a = positions.row(triangles(t, 0)), b = positions.row(triangles(t, 1)),
                   c = positions.row(triangles(t, 2));
        // A crossed product is twice a triangle's area long.
        const Vec3 weighted = (b - a).cross(c - a);
        for (int k = 0; k < 3; ++k) normals.row(triangles(t, k)) += weighted.transpose();
    }
    for (auto normal : normals.rowwise()) {
        const double length = normal.norm();
        if (length > 0.0) {
            normal /= length;
        } else {
            normal = Vec3::UnitY().transpose();
        }
    }
    return normals;
}

}  // namespace cloth
