// What holds, damps, blows at and sews cloth, and creases that stay.

#include <catch2/catch.hpp>

#include "base/portable_math.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "sim/simulation.h"
#include "sim/stepping/total_energy.h"
#include "support/assignment_settings.h"
#include "support/free_sheet.h"

using namespace cloth;
using testing::free_sheet;
using testing::largest_distance;

namespace {

/// A strip of a named fabric, hanging from its upper edge; it does not feel itself.
Scene hanging_strip(const char* fabric, int columns = 4, int rows = 13) {
    Scene scene{.simulation = testing::assignment_settings()};
    ClothDesc cloth;
    cloth.grid = {.size = {0.1, 0.4}, .resolution = {columns, rows}};
    cloth.fabric = find_fabric(fabric)->fabric;
    scene.cloths.push_back(cloth);
    PinDesc pin;
    pin.edge = "top";
    scene.pins.push_back(pin);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    return scene;
}

}  // namespace

TEST_CASE("pins follow their keys: shifted, turned about a centre, and let go", "[pins]") {
    for (IntegratorKind kind : {IntegratorKind::linearly_implicit_euler, IntegratorKind::implicit_euler,
                                IntegratorKind::tr_bdf2, IntegratorKind::implicit_midpoint}) {
        Scene scene = hanging_strip("cotton");
        scene.simulation.integrator = kind;
        scene.cloths[0].fabric.strain_limit.reset();
        PinDesc& pin = scene.pins[0];
        pin.path = {{.time = 0.1}, {.time = 0.3, .translate = {0.2, 0.0, 0.0}, .rotate = {0.0, 90.0, 0.0}}};
        pin.until = 0.4;
        Simulation simulation(scene);
        const VecX start = simulation.state().positions;
        const Vec3 center(0.0, 0.2, 0.0);  // the mean of the upper edge
        for (int frame = 1; frame <= 24; ++frame) {
            REQUIRE(simulation.advance_frame().converged);
            const double share = std::clamp((frame / 60.0 - 0.1) / 0.2, 0.0, 1.0);
            const Mat3 R = rotation_matrix(Vec3(0.0, 90.0 * share, 0.0));
            for (int v : simulation.model().pinned) {
                const Vec3 expected =
                    center + R * (Vec3(start.segment<3>(3 * v)) - center) + Vec3(0.2 * share, 0.0, 0.0);
                CHECK((Vec3(simulation.state().positions.segment<3>(3 * v)) - expected).norm() < 1e-12);
            }
        }
        const double before = simulation.state().positions(3 * simulation.model().pinned[0] + 1);
        for (int frame = 0; frame < 12; ++frame) REQUIRE(simulation.advance_frame().converged);
        CHECK(simulation.state().positions(3 * simulation.model().pinned[0] + 1) < before - 0.1);  // it falls
    }
}

TEST_CASE("a strain limit holds under a load that would pull far beyond it", "[fabrics]") {
    Scene scene = hanging_strip("cotton");
    scene.simulation.gravity = Vec3(0.0, -3000.0, 0.0);  // 180 N/m at the upper edge
    double stretch[2];
    for (bool limited : {false, true}) {
        if (!limited) scene.cloths[0].fabric.strain_limit.reset();
        if (limited) scene.cloths[0].fabric.strain_limit = 1.05;
        Simulation simulation(scene);
        stretch[limited] = 0.0;
        for (int frame = 0; frame < 40; ++frame) {
            const FrameReport report = simulation.advance_frame();
            REQUIRE(report.converged);
            stretch[limited] = std::max(stretch[limited], report.largest_stretch);
        }
    }
    CHECK(stretch[0] > 1.07);
    CHECK(stretch[1] < 1.05);
    CHECK(stretch[1] > 1.03);

    // Pulled by its pins, too, it never gives: the run stops and says where.
    Scene torn = hanging_strip("cotton");
    PinDesc lower;
    lower.edge = "bottom";
    lower.path = {{.time = 0.0}, {.time = 1.0, .translate = {0.0, -0.1, 0.0}}};
    torn.pins.push_back(lower);
    torn.simulation.retries = 2;
    Simulation simulation(torn);
    FrameReport report;
    for (int frame = 0; frame < 60 && report.converged; ++frame) report = simulation.advance_frame();
    CHECK_FALSE(report.converged);
    CHECK(report.largest_stretch < 1.05);
}

TEST_CASE("viscosity takes energy out of a strip's waves and leaves its rest alone", "[fabrics]") {
    double left[2];
    VecX rest[2];
    for (bool damped : {false, true}) {
        Scene scene = hanging_strip("cotton");
        scene.cloths[0].fabric.membrane_damping = 0.0;
        scene.cloths[0].fabric.bending_damping = damped ? 0.5 : 0.0;
        scene.simulation.integrator = IntegratorKind::tr_bdf2;
        scene.simulation.gravity.setZero();
        Simulation simulation(scene);
        State state = simulation.state();
        for (int v = 4; v < 48; ++v)
            state.velocities(3 * v + 2) = 0.1 * sin_degrees(1800.0 * state.positions(3 * v + 1));
        simulation.restore(state);
        for (int frame = 0; frame < 40; ++frame) REQUIRE(simulation.advance_frame().converged);
        left[damped] = kinetic_energy(simulation.model(), simulation.state());
        scene.simulation.integrator = IntegratorKind::implicit_euler;
        scene.simulation.frame_rate = 5.0;
        scene.simulation.gravity = Vec3(0.0, -9.81, 0.0);
        Simulation settling(scene);
        for (int frame = 0; frame < 80; ++frame) REQUIRE(settling.advance_frame().converged);
        rest[damped] = settling.state().positions;
    }
    CHECK(left[1] < 0.9 * left[0]);
    CHECK(largest_distance(rest[0], rest[1]) < 1e-5);
}

TEST_CASE("a rigid turn is not damped by viscosity", "[fabrics]") {
    Scene scene = free_sheet();
    scene.simulation.gravity.setZero();
    scene.simulation.integrator = IntegratorKind::implicit_midpoint;
    scene.simulation.frame_rate = 400.0;
    scene.cloths[0].fabric.bending = 1e-3;
    scene.cloths[0].fabric.membrane_damping = 0.05;
    scene.cloths[0].fabric.bending_damping = 0.05;
    Simulation simulation(scene);
    State state = simulation.state();
    for (int v = 0; v < simulation.model().vertex_count(); ++v) {
        state.velocities.segment<3>(3 * v) =
            Vec3(0.0, 0.0, 0.5).cross(Vec3(state.positions.segment<3>(3 * v)));
    }
    simulation.restore(state);
    const double before = kinetic_energy(simulation.model(), simulation.state());
    for (int frame = 0; frame < 200; ++frame) REQUIRE(simulation.advance_frame().converged);
    CHECK(kinetic_energy(simulation.model(), simulation.state()) == Approx(before).epsilon(0.02));
    CHECK(before > 0.0);
}

TEST_CASE("a sheet falls at the speed where drag carries its weight", "[air]") {
    // Level, C_D = 1: ½ ρ v² = ρ_A g.
    Scene scene = free_sheet();
    scene.simulation.gravity = Vec3(0.0, -9.81, 0.0);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.frame_rate = 60.0;
    scene.simulation.air.drag = 1.0;
    scene.cloths[0].transform.rotate = Vec3(-90.0, 0.0, 0.0);
    const double expected =
        std::sqrt(2.0 * scene.cloths[0].fabric.density * 9.81 / scene.simulation.air.density);
    Simulation simulation(scene);
    for (int frame = 0; frame < 240; ++frame) REQUIRE(simulation.advance_frame().converged);
    double speed = 0.0;
    for (int v = 0; v < simulation.model().vertex_count(); ++v)
        speed -= simulation.state().velocities(3 * v + 1);
    CHECK(speed / simulation.model().vertex_count() == Approx(expected).epsilon(0.01));
}

TEST_CASE("wind blows a hanging strip to its lee, the same gusts each run", "[air]") {
    Scene scene = hanging_strip("silk");
    scene.simulation.air = {
        .drag = 1.2, .lift = 0.8, .wind = {0.0, 0.0, 6.0}, .gusts = 1.5, .gust_length = 0.5};
    std::vector<VecX> ends;
    for (int repeat : {0, 1}) {
        Simulation simulation(scene, 1 + repeat);
        for (int frame = 0; frame < 60; ++frame) REQUIRE(simulation.advance_frame().converged);
        ends.push_back(simulation.state().positions);
        CHECK(simulation.state().positions(2) > 0.1);
    }
    CHECK(ends[0] == ends[1]);
}

TEST_CASE("a seam closes in its time and holds", "[seams]") {
    Scene scene = hanging_strip("cotton");
    Scene other = hanging_strip("cotton");
    other.cloths[0].transform.translate = Vec3(0.15, 0.0, 0.0);
    scene.cloths.push_back(other.cloths[0]);
    scene.pins[0].path = {};
    PinDesc pin = scene.pins[0];
    pin.cloth = 1;
    scene.pins.push_back(pin);
    SeamDesc seam;
    seam.sides[0].edge = "right";
    seam.sides[1].edge = "left";
    seam.sides[1].cloth = 1;
    seam.close_time = 0.5;
    scene.seams.push_back(seam);
    scene.cloths[0].fabric.strain_limit.reset();
    scene.cloths[1].fabric.strain_limit.reset();
    Simulation simulation(scene);
    auto gap = [&] {
        const int a = 3, b = simulation.model().cloths[1].first_vertex;  // lower right; lower left
        return (Vec3(simulation.state().positions.segment<3>(3 * a)) -
                Vec3(simulation.state().positions.segment<3>(3 * b)))
            .norm();
    };
    CHECK(gap() == Approx(0.05));
    for (int frame = 0; frame < 120; ++frame) REQUIRE(simulation.advance_frame().converged);
    CHECK(gap() < 1e-3);
    seam.sides[1].edge = "top";
    scene.seams[0] = seam;
    CHECK_THROWS_WITH(Simulation(scene), Catch::Contains("sews 13 vertices to 4"));
}

TEST_CASE("folded paper keeps its crease when let go, folded cloth does not", "[fabrics]") {
    double opening[2];
    for (bool paper : {false, true}) {
        Scene scene{.simulation = testing::assignment_settings()};
        ClothDesc cloth;
        cloth.grid = {.size = {0.2, 0.05}, .resolution = {21, 6}};
        cloth.fabric = find_fabric("paper")->fabric;
        cloth.fabric.strain_limit.reset();
        if (!paper) cloth.fabric.yield_curvature.reset();
        scene.cloths.push_back(cloth);
        // The middle stays; the ends are turned up to 80 degrees, held, and let go.
        PinDesc middle;
        middle.box = {Vec3(-0.001, -1, -1), Vec3(0.001, 1, 1)};
        scene.pins.push_back(middle);
        for (double side : {-1.0, 1.0}) {
            PinDesc end;
            end.box = {Vec3(side > 0 ? 0.095 : -1, -1, -1), Vec3(side > 0 ? 1 : -0.095, 1, 1)};
            end.center = Vec3::Zero();
            end.path = {{.time = 0.0}, {.time = 0.5, .rotate = {0.0, -80.0 * side, 0.0}}};
            end.until = 0.6;
            scene.pins.push_back(end);
        }
        scene.simulation.gravity.setZero();
        scene.simulation.integrator = IntegratorKind::implicit_euler;
        Simulation simulation(scene);
        for (int frame = 0; frame < 120; ++frame) REQUIRE(simulation.advance_frame().converged);
        const Vec3 tip = simulation.state().positions.segment<3>(3 * 20);
        opening[paper] = std::atan2(tip.z(), tip.x());
    }
    CHECK(std::abs(opening[0]) < 0.2);
    CHECK(opening[1] > 0.5);
}
