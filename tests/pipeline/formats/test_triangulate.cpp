// Polygons into triangles: no area lost or added, nothing turned over, whatever the shape.

#include <catch2/catch.hpp>
#include <cmath>
#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "pipeline/formats/triangulate.h"
#include "sim/scene/mesh.h"

using namespace cloth;
using namespace cloth::pipeline;
using Corners = std::vector<std::array<int, 3>>;

namespace {

std::vector<Vec3> flat(std::initializer_list<Vec2> corners) {
    std::vector<Vec3> polygon;
    for (const Vec2& c : corners) polygon.emplace_back(c.x(), c.y(), 0.0);
    return polygon;
}

/// Twice the signed area in the plane z = 0.
double area(const Vec3& a, const Vec3& b, const Vec3& c) {
    return (b - a).cross(c - a).z();
}

/// Checks that the triangles fill a polygon in z = 0 that is wound counter-clockwise.
void check_filled(const std::vector<Vec3>& polygon) {
    const Corners triangles = triangulate(polygon);
    REQUIRE(triangles.size() == polygon.size() - 2);
    double whole = 0.0, sum = 0.0;
    for (std::size_t i = 1; i + 1 < polygon.size(); ++i)
        whole += area(polygon[0], polygon[i], polygon[i + 1]);
    for (const auto& [a, b, c] : triangles) {
        const double each = area(polygon[static_cast<std::size_t>(a)], polygon[static_cast<std::size_t>(b)],
                                 polygon[static_cast<std::size_t>(c)]);
        CHECK(each > 0.0);
        sum += each;
    }
    // Triangles of one winding whose areas sum to the polygon's cover it once.
    CHECK(sum == Approx(whole).epsilon(1e-9));
}

}  // namespace

TEST_CASE("a square is cut from its first corner, a concave polygon where it is open", "[triangulate]") {
    CHECK(triangulate(flat({{0, 0}, {1, 0}, {1, 1}, {0, 1}})) == Corners{{0, 1, 2}, {0, 2, 3}});
    // A slanted quad by its short diagonal.
    CHECK(triangulate(flat({{0, 0}, {4, 0}, {6, 1}, {2, 1}})).size() == 2);
    check_filled(flat({{0, 0}, {2, -1}, {0.5, 0}, {2, 1}}));
    check_filled(flat({{0, 0}, {3, 0}, {3, 3}, {2, 3}, {2, 1}, {1, 1}, {1, 3}, {0, 3}}));  // a U
}

TEST_CASE("corners on a straight edge make no triangle without area", "[triangulate]") {
    check_filled(flat({{0, 0}, {1, 0}, {2, 0}, {2, 1}, {0, 1}}));
    check_filled(flat({{0, 0}, {1, 0}, {2, 0}, {1, 1}}));
    check_filled(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}, {3, 1}, {2, 1}, {1, 1}, {0, 1}}));
}

TEST_CASE("a cut to a hole has two banks at one place", "[triangulate]") {
    check_filled(flat({{0, 0}, {3, 0}, {3, 3}, {0, 3}, {0, 0}, {1, 1}, {1, 2}, {2, 2}, {2, 1}, {1, 1}}));
}

TEST_CASE("stars of many corners are filled, in any plane and at any size", "[triangulate]") {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> radius(0.2, 1.0);
    for (const int n : {5, 17, 200, 1000}) {
        std::vector<Vec3> star;
        for (int i = 0; i < n; ++i) {
            const double angle = 2.0 * 3.14159265358979 * i / n;
            star.emplace_back(Vec3(std::cos(angle), std::sin(angle), 0.0) * radius(random));
        }
        check_filled(star);
        const Mat3 R = rotation_matrix({20, 50, 70});
        for (const double size : {1e-9, 1e9}) {
            std::vector<Vec3> moved;
            for (const Vec3& p : star) moved.push_back(size * (R * p + Vec3(1, 2, 3)));
            CHECK(triangulate(moved).size() == star.size() - 2);
        }
    }
}

TEST_CASE("what crosses itself or has no area is not cut", "[triangulate]") {
    CHECK(triangulate(flat({{0, 0}, {1, 1}, {1, 0}, {0, 1}})).empty());  // a bow tie
    CHECK(triangulate(flat({{0, 0}, {3, 0}, {0, 1}, {3, 2}, {0, 2.5}})).size() != 3);
    CHECK(triangulate(flat({{0, 0}, {1, 0}, {2, 0}, {3, 0}})).empty());
    CHECK(triangulate(flat({{1, 1}, {1, 1}, {1, 1}, {1, 1}})).empty());
    CHECK(triangulate(std::vector<Vec3>(4, Vec3(1e308, -1e308, 1e308))).empty());
}
