// Vertices that are held from outside while a simulation runs.

#include <catch2/catch.hpp>
#include <stdexcept>

#include "sim/motion/pins.h"
#include "sim/simulation.h"

using namespace cloth;
using Catch::Contains;

namespace {

Scene sheet() {
    Scene scene;
    scene.simulation.frame_rate = 30.0;
    scene.simulation.substeps = 3;
    scene.cloths.emplace_back();
    scene.cloths[0].grid = {.size = {0.3, 0.3}, .resolution = {6, 6}};
    PinDesc pin;
    pin.vertices = {0};
    scene.pins.push_back(pin);
    return scene;
}

Vec3 place(const Simulation& s, int v) {
    return s.state().positions.segment<3>(3 * v);
}

}  // namespace

TEST_CASE("a held vertex goes straight to its place within a frame, stays, and falls when released",
          "[holds]") {
    Simulation simulation(sheet());
    const Vec3 start = place(simulation, 35), way(0.0, 0.006, -0.003);
    Points to(1, 3);
    to.row(0) = start + way;
    simulation.hold({35}, to);
    for (int step = 1; step <= 3; ++step) {
        REQUIRE(simulation.step().converged);
        CHECK((place(simulation, 35) - (start + step / 3.0 * way)).norm() < 1e-12);
    }
    for (int frame = 0; frame < 3; ++frame) REQUIRE(simulation.advance_frame().converged);
    CHECK(place(simulation, 35) == Vec3(to.row(0)));
    // A scene's pin holds all along, and a hold takes its place.
    CHECK(place(simulation, 0) == Vec3(-0.15, -0.15, 0.0));
    Points away(1, 3);
    away.row(0) << -0.15, -0.145, 0.0;
    simulation.hold({0}, away);
    REQUIRE(simulation.advance_frame().converged);
    CHECK(place(simulation, 0) == Vec3(away.row(0)));
    simulation.release();
    REQUIRE(simulation.advance_frame().converged);
    CHECK(place(simulation, 0) == Vec3(-0.15, -0.15, 0.0));
    for (int frame = 0; frame < 3; ++frame) REQUIRE(simulation.advance_frame().converged);
    CHECK(place(simulation, 35).y() < to(0, 1) - 1e-3);
}

TEST_CASE("without holds nothing changes, and holds of nothing are refused", "[holds]") {
    Simulation a(sheet()), b(sheet());
    b.release();
    a.advance_frame();
    b.advance_frame();
    CHECK(a.state().positions == b.state().positions);
    CHECK_THROWS_WITH(a.hold({36}, Points::Zero(1, 3)), Contains("vertex 36 does not exist; there are 36"));
    CHECK_THROWS_WITH(a.hold({1, 2}, Points::Zero(1, 3)), Contains("2 vertices and 1 places"));
    CHECK_THROWS_WITH(a.hold({1}, Points::Constant(1, 3, std::nan(""))), Contains("not finite"));
}
