// Meshes as modellers leave them: what is joined, left out and turned, and what is left alone.

#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include <Eigen/Geometry>

#include "base/portable_math.h"
#include "sim/scene/mesh.h"
#include "sim/scene/mesh_repair.h"
#include "support/refusal.h"

using namespace cloth;
using Catch::Contains;

namespace {

/// A band of n quads around the y axis, given as a sheet whose last column stands where its first does;
/// `twists` half turns make a Möbius band of it.
MeshData band(int n, int twists = 0) {
    MeshData mesh;
    mesh.positions.resize(2 * (n + 1), 3);
    mesh.triangles.resize(2 * n, 3);
    for (int i = 0; i <= n; ++i) {
        const double angle = 360.0 * i / n, tilt = 180.0 * twists * i / n;
        const Vec3 out(cos_degrees(angle), 0.0, sin_degrees(angle));
        for (int side = 0; side < 2; ++side) {
            const double along = side == 0 ? -0.2 : 0.2;
            mesh.positions.row(2 * i + side) =
                out * (1.0 + along * sin_degrees(tilt)) + along * cos_degrees(tilt) * Vec3::UnitY();
        }
        if (i == n) break;
        mesh.triangles.row(2 * i) << 2 * i, 2 * i + 2, 2 * i + 1;
        mesh.triangles.row(2 * i + 1) << 2 * i + 2, 2 * i + 3, 2 * i + 1;
    }
    return mesh;
}

bool same(const MeshData& a, const MeshData& b) {
    return a.positions == b.positions && a.triangles == b.triangles;
}

void turn(MeshData& mesh, int t) {
    std::swap(mesh.triangles(t, 0), mesh.triangles(t, 1));
}

}  // namespace

TEST_CASE("a mesh with nothing to mend comes back to the bit", "[mesh_repair]") {
    const MeshData grid = make_grid({.resolution = {5, 4}});
    const MeshRepair repair = repair_cloth_mesh(grid, nullptr, true);
    CHECK(same(repair.mesh, grid));
    CHECK(repair.joined + repair.doubled + repair.loose + repair.collapsed + repair.repeated +
              repair.turned ==
          0);
    CHECK(repair.given.size() == 20);
    CHECK(repair.vertex_of.back() == 19);
}

TEST_CASE("doubled vertices along a seam are joined, exact or but for rounding", "[mesh_repair]") {
    for (const double off : {0.0, 1e-9, -1e-6}) {
        MeshData tube = band(24);
        tube.positions.bottomRows(2).array() += off;
        const MeshRepair repair = repair_cloth_mesh(tube, nullptr, true);
        CAPTURE(off);
        CHECK(repair.joined == 2);
        CHECK(repair.mesh.positions == tube.positions.topRows(48));
        CHECK(repair.vertex_of[48] == 0);
        CHECK(repair.vertex_of[49] == 1);
        CHECK_NOTHROW(check_cloth_mesh(repair.mesh, "m"));
        // Mended once, there is nothing left to mend.
        CHECK(same(repair_cloth_mesh(repair.mesh, nullptr, true).mesh, repair.mesh));
        const MeshRepair left = repair_cloth_mesh(tube, nullptr, false);
        CHECK(left.doubled == 2);
        CHECK(same(left.mesh, tube));
    }
    MeshData apart = band(24);
    apart.positions.bottomRows(2).array() += 1e-3;
    CHECK(repair_cloth_mesh(apart, nullptr, true).joined == 0);
}

TEST_CASE("what is at one place at rest but not in the pose is not joined", "[mesh_repair]") {
    // Two squares cut from one place of the cloth, one above the other at the start.
    MeshData two = make_grid({.resolution = {2, 2}});
    const Points one = two.positions;
    const Triangles triangles = two.triangles;
    two.positions.resize(8, 3);
    two.positions << one, one;
    two.triangles.resize(4, 3);
    two.triangles << triangles, triangles.array() + 4;
    Points pose = two.positions;
    pose.bottomRows(4).col(2).array() += 0.1;
    CHECK(repair_cloth_mesh(two, &pose, true).joined == 0);
    CHECK(repair_cloth_mesh(two, &pose, false).doubled == 0);
    CHECK(repair_cloth_mesh(two, &two.positions, true).joined == 4);
    CHECK(repair_cloth_mesh(two, nullptr, true).repeated == 2);  // two layers are one
}

TEST_CASE("what belongs to no sheet is left out", "[mesh_repair]") {
    MeshData mesh = make_grid({.resolution = {2, 2}});
    mesh.positions.conservativeResize(6, 3);
    mesh.positions.row(4) << 9, 9, 9;
    mesh.positions.row(5) = mesh.positions.row(3);
    mesh.triangles.conservativeResize(5, 3);
    mesh.triangles.row(2) << 0, 3, 5;  // collapses when 5 joins 3
    mesh.triangles.row(3) << 1, 1, 2;
    mesh.triangles.row(4) = mesh.triangles.row(0);
    const MeshRepair repair = repair_cloth_mesh(mesh, nullptr, true);
    CHECK(repair.joined == 1);
    CHECK(repair.collapsed == 2);
    CHECK(repair.repeated == 1);
    CHECK(repair.loose == 1);
    CHECK(repair.vertex_of == std::vector<int>{0, 1, 2, 3, -1, 3});
    CHECK(repair.given == std::vector<int>{0, 1, 2, 3});
    CHECK(same(repair.mesh, make_grid({.resolution = {2, 2}})));
}

TEST_CASE("each piece faces the way that most of its area does", "[mesh_repair]") {
    MeshData mesh = make_grid({.resolution = {6, 6}});
    const MeshData whole = mesh;
    for (int t = 0; t < 50; t += 7) turn(mesh, t);
    MeshRepair repair = repair_cloth_mesh(mesh, nullptr, true);
    CHECK(repair.turned == 8);
    CHECK_NOTHROW(check_cloth_mesh(repair.mesh, "m"));
    for (int t = 0; t < 50; ++t) {
        const Vec3 a = repair.mesh.positions.row(repair.mesh.triangles(t, 0)),
                   b = repair.mesh.positions.row(repair.mesh.triangles(t, 1)),
                   c = repair.mesh.positions.row(repair.mesh.triangles(t, 2));
        CHECK((b - a).cross(c - a).z() > 0.0);
    }
    // Most by area, not by number; of two halves the first's way.
    MeshData three;
    three.positions.resize(5, 3);
    three.positions << 0, 0, 0, 9, 0, 0, 0, 9, 0, 9, 1, 0, 1, 9, 0;
    three.triangles.resize(3, 3);
    three.triangles << 0, 1, 2, 1, 2, 3, 2, 3, 4;
    repair = repair_cloth_mesh(three, nullptr, true);
    CHECK(repair.turned == 1);
    CHECK(repair.mesh.triangles.row(0) == three.triangles.row(0));
    // A piece of its own keeps its own way.
    MeshData apart = whole;
    apart.positions.conservativeResize(39, 3);
    apart.positions.bottomRows(3) << 5, 0, 0, 5, 1, 0, 6, 0, 0;
    apart.triangles.conservativeResize(51, 3);
    apart.triangles.row(50) << 36, 37, 38;
    CHECK(repair_cloth_mesh(apart, nullptr, true).turned == 0);
}

TEST_CASE("a one-sided sheet is refused, a band with two half turns is not", "[mesh_repair]") {
    const auto told = [](const MeshData& mesh) {
        return refusal([&] { check_cloth_mesh(repair_cloth_mesh(mesh, nullptr, true).mesh, "m"); });
    };
    CHECK_THAT(told(band(40, 1)), Contains("face opposite ways") && Contains("Möbius"));
    CHECK(told(band(40, 2)) == "accepted");
}

TEST_CASE("three sheets at one edge are refused, with a way to mend them", "[mesh_repair]") {
    MeshData mesh;
    mesh.positions.resize(9, 3);
    mesh.positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1;
    mesh.triangles.resize(3, 3);
    mesh.triangles << 0, 1, 2, 3, 4, 5, 6, 7, 8;
    CHECK_THAT(refusal([&] { check_cloth_mesh(repair_cloth_mesh(mesh, nullptr, true).mesh, "m"); }),
               Contains("more than two triangles") && Contains("non-manifold"));
}

TEST_CASE("vertices too far apart to be measured are not joined", "[mesh_repair]") {
    MeshData mesh = make_grid({.resolution = {2, 2}});
    mesh.positions *= 1e200;
    CHECK(repair_cloth_mesh(mesh, nullptr, true).joined == 0);
}

TEST_CASE("units are those of mesh and pose", "[mesh_repair]") {
    ClothDesc cloth;
    cloth.mesh = make_grid({.size = {100.0, 100.0}, .resolution = {3, 3}});
    cloth.units = LengthUnit::centimetre;
    CHECK(rest_shape(cloth).positions.isApprox(make_grid({.resolution = {3, 3}}).positions, 1e-15));
    cloth.pose = cloth.mesh->positions;
    CHECK(start_positions(cloth, rest_shape(cloth)) == rest_shape(cloth).positions);
    CHECK(length_of(LengthUnit::foot) == Approx(12 * length_of(LengthUnit::inch)).epsilon(1e-15));
    CHECK(length_of(LengthUnit::metre) == 1000 * length_of(LengthUnit::millimetre));
}
