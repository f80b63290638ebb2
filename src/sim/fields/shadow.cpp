#include "sim/fields/shadow.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace cloth {

double shadow_area(const VecRef& positions, const Triangles& triangles, double cell) {
    if (triangles.rows() == 0) return 0.0;
    // In cells, seen from above.
    const auto place = [&](int vertex) {
        return Vec2(positions(3 * vertex) / cell, positions(3 * vertex + 2) / cell);
    };
    Vec2 low = place(triangles(0, 0)), high = low;
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) {
            low = low.cwiseMin(place(triangles(t, i)));
            high = high.cwiseMax(place(triangles(t, i)));
        }
    }
    const Vec2 origin(std::floor(low.x()), std::floor(low.y()));
    const double columns = std::floor(high.x()) - origin.x() + 1,
                 rows = std::floor(high.y()) - origin.y() + 1;
    if (!(columns * rows < 268435456.0))
        throw std::invalid_argument("the cloth is spread too wide for its shadow's area");
    const auto nx = static_cast<std::size_t>(columns), ny = static_cast<std::size_t>(rows);
    std::vector<bool> covered(nx * ny, false);
    const auto side = [](const Vec2& a, const Vec2& b, const Vec2& c) {
        return (b - a).x() * (c - a).y() - (b - a).y() * (c - a).x();
    };
    for (int t = 0; t < triangles.rows(); ++t) {
        std::array<Vec2, 3> p;
        for (int i = 0; i < 3; ++i) p[i] = place(triangles(t, i)) - origin;
        const double sign = side(p[0], p[1], p[2]) < 0.0 ? -1.0 : 1.0;
        const Vec2 first = p[0].cwiseMin(p[1]).cwiseMin(p[2]), last = p[0].cwiseMax(p[1]).cwiseMax(p[2]);
        for (auto j = static_cast<std::size_t>(first.y()); j <= static_cast<std::size_t>(last.y()); ++j) {
            for (auto i = static_cast<std::size_t>(first.x()); i <= static_cast<std::size_t>(last.x()); ++i) {
                const Vec2 c(static_cast<double>(i) + 0.5, static_cast<double>(j) + 0.5);
                if (sign * side(p[0], p[1], c) >= 0.0 && sign * side(p[1], p[2], c) >= 0.0 &&
                    sign * side(p[2], p[0], c) >= 0.0)
                    covered[j * nx + i] = true;
            }
        }
    }
    return cell * cell * static_cast<double>(std::count(covered.begin(), covered.end(), true));
}

double surface_area(const VecRef& positions, const Triangles& triangles) {
    double area = 0.0;
    for (int t = 0; t < triangles.rows(); ++t) {
        const Vec3 a = positions.segment<3>(3 * triangles(t, 0)),
                   b = positions.segment<3>(3 * triangles(t, 1)),
                   c = positions.segment<3>(3 * triangles(t, 2));
        area += 0.5 * (b - a).cross(c - a).norm();
    }
    return area;
}

double drape_coefficient(double shadow, double pedestal, double flat) {
    return 100.0 * (shadow - pedestal) / (flat - pedestal);
}

}  // namespace cloth
