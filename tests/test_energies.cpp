// Every energy through the battery; the membrane's states cover rest, stretch, compression and degeneration.

#include <catch2/catch.hpp>
#include <random>

#include "energy_battery.h"
#include "sim/bending.h"
#include "sim/contact.h"
#include "sim/drag.h"
#include "sim/gravity.h"
#include "sim/membrane.h"
#include "sim/mesh.h"
#include "sim/portable_math.h"

using namespace cloth;
using namespace cloth::testing;

namespace {

Grid patch() {
    return {.size = {0.2, 0.2}, .resolution = {3, 3}, .diagonals = Diagonals::alternating};
}

VecX flatten(const Points& p) {
    VecX x(3 * p.rows());
    for (int i = 0; i < p.rows(); ++i) x.segment<3>(3 * i) = p.row(i).transpose();
    return x;
}

/// Rest, near rest, stretched, compressed, random, and squeezed almost to a line.
std::vector<VecX> sheet_states(const VecX& rest) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    auto shaken = [&](const VecX& x, double size) {
        VecX y = x;
        for (double& v : y) v += size * normal(random);
        return y;
    };
    auto scaled = [&](double sx, double sy) {
        VecX y = rest;
        for (int i = 0; i < y.size(); i += 3) {
            y(i) *= sx;
            y(i + 1) *= sy;
        }
        return y;
    };
    return {shaken(rest, 1e-9),
            shaken(rest, 1e-4),
            shaken(scaled(1.2, 1.1), 1e-3),
            shaken(scaled(0.7, 0.8), 3e-3),
            shaken(rest, 0.02),
            shaken(scaled(1.1, 0.15), 1e-3)};
}

}  // namespace

TEST_CASE("membrane energy passes the battery", "[energy]") {
    const MeshData mesh = make_grid(patch());
    std::vector<std::array<int, 3>> stencils;
    std::vector<TriangleRest> rest;
    for (int t = 0; t < mesh.triangles.rows(); ++t) {
        const auto v = mesh.triangles.row(t);
        stencils.push_back({v(0), v(1), v(2)});
        rest.push_back(make_triangle_rest(mesh.positions.row(v(0)), mesh.positions.row(v(1)),
                                          mesh.positions.row(v(2)), 1e-3, 4e5, 3e5));
    }
    MembraneEnergy energy(stencils, rest);
    const VecX x = flatten(mesh.positions);
    check_energy(energy, 9, sheet_states(x), {.length = 0.02, .force_scale = 40.0, .stiffness_scale = 400.0});

    CHECK(energy.value(x) < 1e-25);
    CHECK(energy.largest_stretch(x) == Approx(1.0).epsilon(1e-14));
    VecX stretched = x;
    for (int i = 0; i < x.size(); i += 3) stretched(i) *= 1.25;
    CHECK(energy.largest_stretch(stretched) == Approx(1.25).epsilon(1e-14));
    CHECK(energy.value(stretched) > 0.0);
}

TEST_CASE("gravity passes the battery", "[energy]") {
    VecX masses(3);
    masses << 0.1, 0.2, 0.3;
    GravityEnergy energy(masses, Vec3(0.5, -9.81, 0.0));
    VecX x(9);
    x << 1, 2, 3, 4, 5, 6, 7, 8, 9;
    check_energy(energy, 3, {x}, {.length = 1.0, .rigid_motion_free = false});
    // V = -Σ m g·x
    CHECK(energy.value(x) == Approx(-(0.1 * (0.5 - 19.62) + 0.2 * (2.0 - 49.05) + 0.3 * (3.5 - 78.48))));
}

TEST_CASE("drag springs pass the battery", "[energy]") {
    DragDesc drag;
    drag.path = {{0.0, {640, 360}}, {1.0, {740, 300}}};
    drag.stiffness = 50.0;
    drag.projection << 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.02, -0.202, 0, 0, -1, 0;  // near 0.1, far 10
    drag.view(2, 3) = -3.0;
    DragState state;
    state.pressed = true;
    state.vertices = {1};
    state.anchors = {Vec3(0.1, 0.2, 0.0)};
    state.grabbed = Vec3(0.1, 0.2, 0.0);
    DragEnergy energy({drag}, {state}, 0.5);
    VecX x(6);
    x << 1, 2, 3, 0.2, 0.1, 0.3;
    check_energy(energy, 2, {x}, {.length = 1.0, .rigid_motion_free = false});
    CHECK(energy.value(x) > 0.0);
}

TEST_CASE("bending energy passes the battery", "[energy]") {
    const MeshData mesh = make_grid(patch());
    const auto patches = make_bending_patches(mesh.positions, mesh.triangles);
    BendingEnergy energy(patches, std::vector<double>(patches.size(), 2e-5));
    const VecX x = flatten(mesh.positions);
    check_energy(energy, 9, sheet_states(x), {.length = 0.02, .force_scale = 1e-4, .stiffness_scale = 1e-2});
    CHECK(energy.value(x) < 1e-30);  // flat at rest, whatever the in-plane stretch
    const VecX stretched = 1.3 * x;
    CHECK(energy.value(stretched) < 1e-30);
}

TEST_CASE("a sheet rolled in any direction has the energy of a plate, ½ D κ² per area", "[energy]") {
    // Patches at the rim lack neighbours, so the inner part of a fine sheet is measured: error O(h²).
    const double radius = 0.5, D = 3e-5;
    for (Diagonals diagonals : {Diagonals::uniform, Diagonals::alternating}) {
        for (double degrees : {0.0, 30.0, 45.0, 90.0, 135.0}) {
            CAPTURE(degrees, diagonals == Diagonals::uniform);
            const MeshData mesh =
                make_grid({.size = {0.4, 0.4}, .resolution = {41, 41}, .diagonals = diagonals});
            std::vector<BendingPatch> inner;
            double area = 0.0;
            for (const BendingPatch& p : make_bending_patches(mesh.positions, mesh.triangles)) {
                if (mesh.positions.row(p.vertices[0]).cwiseAbs().maxCoeff() > 0.15) continue;
                inner.push_back(p);
                area += p.area;
            }
            VecX x = flatten(mesh.positions);
            const double c = cos_degrees(degrees), s = sin_degrees(degrees);
            for (int i = 0; i < x.size(); i += 3) {
                const double u = c * x(i) + s * x(i + 1), v = -s * x(i) + c * x(i + 1);
                const double rolled = radius * std::sin(u / radius);
                x(i) = c * rolled - s * v;
                x(i + 1) = s * rolled + c * v;
                x(i + 2) = radius * (1.0 - std::cos(u / radius));
            }
            BendingEnergy energy(inner, std::vector<double>(inner.size(), D));
            CHECK(energy.value(x) == Approx(0.5 * D / (radius * radius) * area).epsilon(1e-3));
        }
    }
}

TEST_CASE("contact with shapes passes the battery", "[energy]") {
    ColliderDesc sphere, plane;
    sphere.center = Vec3(0.1, 0.0, 0.0);
    sphere.radius = 0.3;
    sphere.contact_offset = 0.05;
    sphere.friction = 0.4;
    plane.shape = Shape::plane;
    plane.center = Vec3(0.0, -0.2, 0.0);
    plane.normal = Vec3(0.1, 2.0, 0.0);
    plane.contact_offset = 0.03;
    plane.friction = 0.7;
    VecX start(12), x(12);
    start << 0.1, 0.31, 0.02, 0.42, 0.01, 0.03, -0.5, -0.18, 0.2, 3, 3, 3;
    const double dt = 0.01, speed = 0.2;
    // Sliding, sticking, sliding on the plane, free.
    x = start;
    x.head<12>() +=
        (VecX(12) << 0.01, -0.005, 0.0, 0.0, 0.001, 0.0005, 0.02, 0.003, 0.004, 0.1, 0.1, 0.1).finished();
    ColliderContactEnergy energy({sphere, plane}, {1, 1}, start, 50.0, dt, speed);
    CHECK(energy.contact_count() == 3);
    check_energy(energy, 4, {x},
                 {.length = 1e-3, .force_scale = 1.0, .stiffness_scale = 50.0, .rigid_motion_free = false});
    CHECK(energy.value(x) > 0.0);
    ColliderContactEnergy off({sphere, plane}, {0, 0}, start, 50.0, dt, speed);
    CHECK(off.value(x) == 0.0);
}
