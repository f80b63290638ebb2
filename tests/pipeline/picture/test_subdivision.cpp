// Loop subdivision against its known limits, and that it leaves what it must.

#include <catch2/catch.hpp>

#include "base/portable_math.h"
#include "pipeline/picture/subdivision.h"
#include "sim/scene/mesh.h"

using namespace cloth;
using namespace cloth::pipeline;

TEST_CASE("a subdivided flat grid keeps its plane, outline, area and orientation", "[subdivision]") {
    const MeshData grid = make_grid({.size = {2.0, 1.0}, .resolution = {5, 4}});
    for (int steps : {0, 1, 2}) {
        const Subdivision s = subdivide(grid.positions, grid.triangles, steps);
        REQUIRE(s.triangles.rows() == 24 * (1 << 2 * steps));
        const Points fine = s.weights * grid.positions;
        CHECK(fine.col(2).cwiseAbs().maxCoeff() == 0.0);
        CHECK(fine.col(0).maxCoeff() == 1.0);
        CHECK(fine.col(1).minCoeff() == -0.5);
        double area = 0.0;
        for (int t = 0; t < s.triangles.rows(); ++t) {
            const Vec3 a = fine.row(s.triangles(t, 0)), b = fine.row(s.triangles(t, 1)),
                       c = fine.row(s.triangles(t, 2));
            CHECK((b - a).cross(c - a).z() > 0.0);
            area += 0.5 * (b - a).cross(c - a).norm();
        }
        CHECK(area == Approx(2.0).epsilon(1e-12));  // all four corners stay
        // Weights of each vertex add up to 1: moving the sheet moves the picture of it.
        CHECK((s.weights * VecX::Ones(20) - VecX::Ones(fine.rows())).cwiseAbs().maxCoeff() < 1e-15);
        CHECK_NOTHROW(check_cloth_mesh({fine, s.triangles}, "fine"));
    }
}

TEST_CASE("one Loop step by hand: a hat over six triangles", "[subdivision]") {
    // A hexagon with its centre raised by 1. Centre: 1 - 6 · 3/(8·6) = 5/8; the middle of a spoke: 3/8; a rim
    // vertex and a rim edge see the rim alone: 0.
    Triangles triangles(6, 3);
    Points rest = Points::Zero(7, 3);
    for (int i = 0; i < 6; ++i) rest.row(1 + i) << cos_degrees(60.0 * i), sin_degrees(60.0 * i), 0.0;
    VecX height = VecX::Zero(7);
    height(0) = 1.0;
    for (int i = 0; i < 6; ++i) triangles.row(i) << 0, 1 + i, 1 + (i + 1) % 6;
    const Subdivision s = subdivide(rest, triangles, 1);
    const VecX fine = s.weights * height;
    REQUIRE(fine.size() == 7 + 12);
    CHECK(fine(0) == Approx(0.625).epsilon(1e-15));
    for (int i = 1; i < 7; ++i) CHECK(fine(i) == 0.0);
    int spokes = 0;
    for (int i = 7; i < 19; ++i) {
        CHECK((fine(i) == 0.0 || fine(i) == 0.375));
        spokes += fine(i) == 0.375;
    }
    CHECK(spokes == 6);
}
