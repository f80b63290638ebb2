// Vertices that a collider carries.

#include "sim/motion/carrier.h"

#include <catch2/catch.hpp>
#include <memory>

#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/scene/mesh.h"
#include "sim/simulation.h"
#include "support/refusal.h"

using namespace cloth;
using Catch::Contains;

TEST_CASE("a rigid collider carries points as it turns and moves", "[carrier]") {
    ColliderDesc ball;
    ball.center = {1.0, 2.0, 3.0};
    ball.path = {{0.0, Vec3::Zero(), Vec3::Zero()}, {1.0, {0.5, 0.0, 0.0}, {0.0, 0.0, 90.0}}};
    const Carrier carrier(ball, {Vec3(1.3, 2.0, 3.0), Vec3(1.0, 2.0, 3.4)});
    CHECK((carrier.places(0.0)[0] - Vec3(1.3, 2.0, 3.0)).norm() < 1e-15);
    CHECK((carrier.places(1.0)[0] - Vec3(1.5, 2.3, 3.0)).norm() < 1e-12);
    CHECK((carrier.places(1.0)[1] - Vec3(1.5, 2.0, 3.4)).norm() < 1e-12);
}

TEST_CASE("a mesh that bends carries a point at the same place of its nearest triangle, as far off",
          "[carrier]") {
    // A square in the plane z = 0 that is lifted and turned upright about its lower edge.
    ColliderDesc body;
    body.shape = Shape::mesh;
    body.mesh = make_grid({.size = {1.0, 1.0}, .resolution = {2, 2}});
    MeshCache cache;
    cache.frames.push_back(body.mesh->positions);
    Points upright = body.mesh->positions;
    upright.col(1).setConstant(2.0);
    upright.col(2) = body.mesh->positions.col(1).array() + 0.5;
    cache.frames.push_back(upright);
    cache.times = {0.0, 1.0};
    body.cache = std::make_shared<const MeshCache>(cache);
    const Carrier carrier(body, {Vec3(0.2, -0.3, 0.05)});
    CHECK((carrier.places(0.0)[0] - Vec3(0.2, -0.3, 0.05)).norm() < 1e-14);
    // The normal, +z at the start, is -y then.
    CHECK((carrier.places(1.0)[0] - Vec3(0.2, 1.95, 0.2)).norm() < 1e-12);
}

TEST_CASE("a pin that a collider carries holds its vertices there through a run", "[carrier]") {
    Scene scene;
    scene.simulation.frame_rate = 30.0;
    scene.cloths.emplace_back();
    scene.cloths[0].grid = {.size = {0.2, 0.2}, .resolution = {5, 5}};
    scene.cloths[0].transform.translate = {0.0, 0.0, 0.3};
    ColliderDesc hips;
    hips.radius = 0.1;
    hips.spin = {0.0, 60.0, 0.0};
    scene.colliders.push_back(hips);
    PinDesc pin;
    pin.edge = "top";
    pin.collider = 0;
    scene.pins.push_back(pin);
    Simulation simulation(scene);
    for (int frame = 0; frame < 15; ++frame) simulation.advance_frame();
    // Half a second: 30 degrees about y.
    for (const int v : simulation.model().pinned) {
        const Vec3 start = start_state(simulation.model()).positions.segment<3>(3 * v);
        const Vec3 expected = rotation_matrix({0.0, 30.0, 0.0}) * start;
        CHECK((simulation.state().positions.segment<3>(3 * v) - expected).norm() < 1e-12);
    }
}

TEST_CASE("a pin's collider is refused where it cannot carry", "[carrier]") {
    Scene scene;
    scene.cloths.emplace_back();
    scene.colliders.emplace_back();
    PinDesc pin;
    pin.vertices = {0};
    pin.collider = 1;
    scene.pins.push_back(pin);
    std::string key;
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("there is no such collider"));
    CHECK(key == "pin[0].collider");
    scene.pins[0].collider = 0;
    CHECK(refusal([&] { validate(scene); }) == "accepted");
    scene.pins[0].path = {{0.0, Vec3::Zero(), Vec3::Zero()}};
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("stands beside collider"));
    CHECK(key == "pin[0].path");
    scene.pins[0].path.clear();
    scene.pins[0].center = Vec3::Zero();
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("stands beside collider"));
    CHECK(key == "pin[0].center");
}
