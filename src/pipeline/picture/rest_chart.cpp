#include "pipeline/picture/rest_chart.h"

#include <cmath>

namespace cloth::pipeline {

Eigen::Matrix<double, Eigen::Dynamic, 2> rest_chart(const Points& rest, const Triangles& triangles) {
    Vec3 normal = Vec3::Zero();
    for (Eigen::Index t = 0; t < triangles.rows(); ++t) {
        const Vec3 a = rest.row(triangles(t, 0)), b = rest.row(triangles(t, 1)),
                   c = rest.row(triangles(t, 2));
        normal += (b - a).cross(c - a);
    }
    normal =
        normal.norm() > 0 ? Vec3(normal.normalized()) : Vec3(Vec3::UnitZ());  // closed: any plane will do
    const Vec3 along = std::abs(normal.x()) < 0.9 ? Vec3::UnitX() : Vec3(-Vec3::UnitZ());
    const Vec3 u = (along - along.dot(normal) * normal).normalized(), v = normal.cross(u);
    Eigen::Matrix<double, Eigen::Dynamic, 2> chart(rest.rows(), 2);
    chart << rest * u, rest * v;
    return chart;
}

}  // namespace cloth::pipeline
