// Steps that cannot get to their end say what stands in the way, and do not try shorter ones for nothing.

#include <catch2/catch.hpp>

#include "sim/simulation.h"

using namespace cloth;
using Catch::Matchers::Contains;

namespace {

/// A level sheet of cotton, 0.1 m square, that its weight does not move.
Scene sheet() {
    Scene scene;
    scene.simulation.gravity.setZero();
    ClothDesc cloth;
    cloth.name = "towel";
    cloth.grid = {.size = {0.1, 0.1}, .resolution = {5, 5}};
    cloth.transform.rotate = {-90.0, 0.0, 0.0};
    scene.cloths.push_back(cloth);
    return scene;
}

ColliderDesc plane(const char* name, double height, double up) {
    ColliderDesc plane;
    plane.name = name;
    plane.shape = Shape::plane;
    plane.center = {0.0, height, 0.0};
    plane.normal = {0.0, up, 0.0};
    return plane;
}

/// The report of the frame that stops a run, and what it tells.
struct Stop {
    FrameReport report;
    std::string text;
};
Stop stop(const Scene& scene, int frames = 60) {
    Simulation simulation(scene);
    for (int frame = 0; frame < frames; ++frame) {
        const FrameReport report = simulation.advance_frame();
        if (report.converged) continue;
        REQUIRE_FALSE(report.placed);
        REQUIRE(report.obstacle);
        return {report, words(simulation.model(), *report.obstacle)};
    }
    FAIL("it went on");
    return {};
}

}  // namespace

TEST_CASE("two colliders that leave cloth no room are named, with what it needs, and no step is halved",
          "[obstacle]") {
    Scene scene = sheet();
    scene.colliders = {plane("below", -0.005, 1.0), plane("above", 0.005, -1.0)};
    scene.colliders[1].path = {{.time = 0.0}, {.time = 0.2, .translate = {0.0, -0.02, 0.0}}};
    SECTION("planes") {}
    SECTION("boxes, whose corners lie far away") {
        for (ColliderDesc& collider : scene.colliders) {
            collider.shape = Shape::box;
            collider.size = {1.0, 0.1, 1.0};
            collider.center.y() += collider.name == "below" ? -0.05 : 0.05;
            collider.normal = {0.0, 1.0, 0.0};
        }
    }
    const Stop stopped = stop(scene);
    CHECK(stopped.report.obstacle->certain);
    CHECK(stopped.report.retries == 0);
    CHECK_THAT(stopped.text, Contains("collider above") && Contains("collider below") &&
                                 Contains(" close on vertex ") && Contains(" of cloth towel at (") &&
                                 Contains(" mm between them would be left there") &&
                                 Contains("the cloth needs 1 mm"));
}

TEST_CASE("a pin that a collider runs into is named with it", "[obstacle]") {
    Scene scene = sheet();
    scene.pins.emplace_back();
    scene.pins[0].edge = "left";
    ColliderDesc ball;
    ball.name = "ball";
    ball.radius = 0.05;
    ball.center = {-0.05, -0.1, 0.0};
    ball.path = {{.time = 0.0}, {.time = 0.5, .translate = {0.0, 0.2, 0.0}}};
    scene.colliders = {ball};
    const Stop stopped = stop(scene);
    CHECK(stopped.report.retries == 0);
    CHECK_THAT(stopped.text, Contains("pin[0] and collider ball meet at vertex ") &&
                                 Contains(" of cloth towel at (-0.05, 0, ") &&
                                 Contains(" mm nearer than contact lets them"));
}

TEST_CASE("ends turned against each other until the strain limit name triangle, stretch and limit",
          "[obstacle]") {
    Scene scene = sheet();
    scene.cloths[0].bump = 1e-3;
    for (const char* edge : {"left", "right"}) {
        scene.pins.emplace_back();
        scene.pins.back().edge = edge;
        const double turn = scene.pins.size() == 1 ? 360.0 : -360.0;
        scene.pins.back().path = {{.time = 0.0}, {.time = 1.0, .rotate = {turn, 0.0, 0.0}}};
    }
    const Stop stopped = stop(scene);
    CHECK(stopped.report.obstacle->kind == Obstacle::Kind::strain_limit);
    CHECK(stopped.report.retries < scene.simulation.retries);
    CHECK_THAT(stopped.text, Contains("triangle ") && Contains(" of cloth towel at (") &&
                                 Contains(" stretched to ") && Contains(", strain limit 1.05"));
}

TEST_CASE("an obstacle is the same where kind, bodies and place are", "[obstacle]") {
    const Model model = build_model(sheet());
    Obstacle a{.colliders = {1, 0}};
    Obstacle b = a;
    CHECK(same_obstacle(model, a, b));
    b.place.x() = 0.1;
    CHECK_FALSE(same_obstacle(model, a, b));
    b = a;
    b.colliders = {1};
    CHECK_FALSE(same_obstacle(model, a, b));
    b = a;
    b.kind = Obstacle::Kind::strain_limit;
    CHECK_FALSE(same_obstacle(model, a, b));
}
