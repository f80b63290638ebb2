// Where a cache has its vertices at a time.

#include <catch2/catch.hpp>
#include <cmath>
#include <memory>
#include <vector>

#include "sim/motion/mesh_cache.h"
#include "sim/motion/placement.h"
#include "sim/shapes/shapes.h"

using namespace cloth;

namespace {

/// A triangle that rises by what `heights` say, ten frames a second.
ColliderDesc rising(const std::vector<double>& heights) {
    ColliderDesc c;
    c.shape = Shape::mesh;
    c.cache_rate = 10.0;
    MeshData mesh;
    mesh.positions.resize(3, 3);
    mesh.positions << 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 0.0;
    mesh.triangles.resize(1, 3);
    mesh.triangles << 0, 1, 2;
    auto cache = std::make_shared<MeshCache>();
    for (const double height : heights) {
        cache->frames.push_back(mesh.positions);
        cache->frames.back().col(1).setConstant(height);
    }
    c.mesh = mesh;
    c.cache = cache;
    return c;
}

double height(const ColliderDesc& c, double time) {
    return cached_vertices(c, time)(1, 1);
}

/// Of a few roundings near 1.
constexpr double rounding = 1e-14;

}  // namespace

TEST_CASE("a cache goes linearly from frame to frame, and stands before the first and after the last",
          "[motion]") {
    ColliderDesc c = rising({1.0, 2.0, 4.0});
    CHECK(height(c, -1.0) == 1.0);
    CHECK(height(c, 0.0) == 1.0);
    CHECK(height(c, 0.05) == Approx(1.5).margin(rounding));
    CHECK(height(c, 0.1) == Approx(2.0).margin(rounding));
    CHECK(height(c, 0.175) == Approx(3.5).margin(rounding));
    CHECK(height(c, 0.2) == 4.0);
    CHECK(height(c, 7.0) == 4.0);
    CHECK(cache_end(c) == Approx(0.2));
    c.cache_start = 1.0;
    c.cache_speed = 0.5;
    CHECK(height(c, 0.9) == 1.0);
    CHECK(height(c, 1.1) == Approx(1.5).margin(rounding));
    CHECK(cache_end(c) == Approx(1.4));
    CHECK(height(rising({3.0}), 5.0) == 3.0);
}

TEST_CASE("a cache's own times count from its first frame, unless a rate is given", "[motion]") {
    ColliderDesc c = rising({1.0, 2.0, 4.0});
    auto timed = std::make_shared<MeshCache>(*c.cache);
    timed->times = {5.0, 5.5, 7.5};
    c.cache = timed;
    CHECK(height(c, 0.1) == Approx(2.0).margin(rounding));
    c.cache_rate.reset();
    CHECK(height(c, 0.25) == Approx(1.5).margin(rounding));
    CHECK(height(c, 1.5) == Approx(3.0).margin(rounding));
    CHECK(cache_end(c) == 2.5);
}

TEST_CASE("a cache that loops goes from its last frame to its first, or repeats where they are one",
          "[motion]") {
    ColliderDesc open = rising({1.0, 2.0, 4.0}), closed = rising({1.0, 2.0, 1.0});
    open.cache_loop = closed.cache_loop = true;
    CHECK(height(open, 0.2) == Approx(4.0).margin(rounding));
    CHECK(height(open, 0.25) == Approx(2.5).margin(1e-13));  // half-way back
    CHECK(height(open, 0.3 + 0.05) == Approx(1.5).margin(1e-13));
    CHECK(height(closed, 0.2 + 0.05) == Approx(1.5).margin(1e-13));
    CHECK(height(closed, 20.0 + 0.15) == Approx(1.5).margin(1e-12));
    CHECK(std::isinf(cache_end(open)));
}

TEST_CASE("a cache is scaled, turned and moved as its mesh is, and then as its path says", "[motion]") {
    ColliderDesc c = rising({1.0, 2.0});
    c.units = LengthUnit::centimetre;
    c.scale = 2.0;
    c.center = {10.0, 0.0, 0.0};
    c.rotate = {0.0, 0.0, 90.0};  // (x, y) → (-y, x)
    c.path = {{.time = 0.0}, {.time = 0.1, .translate = {0.0, 0.0, 1.0}}};
    const Placement end = placement_at(c, 0.1);
    REQUIRE(end.bent != nullptr);
    const Vec3 there = end(end.bent->row(2));
    CHECK((there - Vec3(10.0 - 0.04, 0.02, 1.0)).norm() < rounding);
    // The shape is that of the placement, without its shift.
    const auto shape = make_shape(c, end);
    CHECK((shape->primitive().points.at(2) - Vec3(10.0 - 0.04, 0.02, 0.0)).norm() < rounding);
    CHECK((make_shape(c)->primitive().points.at(2) - Vec3(10.0 - 0.02, 0.02, 0.0)).norm() < rounding);
}
