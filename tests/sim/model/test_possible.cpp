// What no step could do, and lengths that follow a cloth's size.

#include <catch2/catch.hpp>

#include "sim/model.h"
#include "sim/model/possible.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "support/refusal.h"

using namespace cloth;
using Catch::Matchers::Contains;

namespace {

/// A towel of cotton, 0.2 m wide and 0.4 m long, held at both ends.
Scene towel() {
    Scene scene;
    ClothDesc cloth;
    cloth.name = "towel";
    cloth.grid = {.size = {0.2, 0.4}, .resolution = {5, 9}};
    scene.cloths.push_back(cloth);
    for (const char* edge : {"bottom", "top"}) {
        scene.pins.emplace_back();
        scene.pins.back().edge = edge;
    }
    return scene;
}

std::string pins_refused(const Scene& scene, double last, std::string* key = nullptr) {
    std::vector<MeshData> rest;
    for (const ClothDesc& cloth : scene.cloths) rest.push_back(rest_shape(cloth));
    return refusal([&] { require_reachable_pins(scene, rest, last); }, key);
}

}  // namespace

TEST_CASE("a cloth that starts beyond its strain limit is refused with the stretch and the limit",
          "[start]") {
    std::string key;
    Scene scene = towel();
    scene.cloths[0].transform.scale = 2.0;
    CHECK_THAT(refusal([&] { build_model(scene); }, &key),
               Contains("cloth towel starts stretched to 2 (triangle ") &&
                   Contains("strain limit 1.05 (cloth[0].fabric.strain_limit)") &&
                   Contains("size = [0.4, 0.8]") && Contains("set the limit to 0"));
    CHECK(key == "cloth[0].scale");

    scene.cloths[0].transform.scale = 1.0;
    scene.cloths[0].bump = 0.05;
    CHECK_THAT(refusal([&] { build_model(scene); }, &key),
               Contains("starts stretched to 1.") && Contains("nearer the rest shape"));
    CHECK(key == "cloth[0].bump");

    scene.cloths[0].bump = 0.0;
    scene.cloths[0].pose = rest_shape(scene.cloths[0]).positions;
    scene.cloths[0].pose->col(1) *= 1.06;
    CHECK_THAT(refusal([&] { build_model(scene); }, &key), Contains("starts stretched to 1.06 "));
    CHECK(key == "cloth[0].pose");

    // Below the limit, and without one
    scene.cloths[0].pose->col(1) /= 1.06 / 1.04;
    CHECK(refusal([&] { build_model(scene); }) == "accepted");
    scene.cloths[0].transform.scale = 2.0;
    scene.cloths[0].fabric.strain_limit.reset();
    CHECK(refusal([&] { build_model(scene); }) == "accepted");
}

TEST_CASE("pins whose ways pull a cloth beyond its strain limit are refused", "[start]") {
    std::string key;
    Scene scene = towel();
    scene.pins[1].path = {{.time = 0.0}, {.time = 1.0, .translate = {0.0, 0.2, 0.0}}};
    // 0.4 m at rest, 0.42 m at the limit: the first frame after 0.1 s
    CHECK_THAT(pins_refused(scene, 1.0, &key),
               Contains("asks for a stretch of 1.05") && Contains("at 0.1 s (frame 6)") &&
                   Contains("of cloth towel, held by pin[0] and pin[1]") &&
                   Contains("where at rest the way is 0.4 m, and asks for 1.5 at 1 s") &&
                   Contains("strain limit 1.05 (cloth[0].fabric.strain_limit)"));
    CHECK(key == "pin[1].path");
    CHECK(pins_refused(scene, 0.09) == "accepted");  // the run ends before
    scene.pins[1].until = 0.05;
    CHECK(pins_refused(scene, 1.0) == "accepted");  // it lets go before
    scene.pins[1].until.reset();
    scene.cloths[0].fabric.strain_limit.reset();
    CHECK(pins_refused(scene, 1.0) == "accepted");

    // A jump at the start, of the first pin
    scene = towel();
    scene.pins[0].path = {{.time = 0.0, .translate = {0.0, 0.0, 0.3}}};
    CHECK_THAT(pins_refused(scene, 1.0, &key), Contains("at 0.0166667 s (frame 1)"));
    CHECK(key == "pin[0].path");

    // Turned over at one end alone: corners cross, none gets farther than it may.
    scene = towel();
    scene.pins[1].path = {{.time = 0.0}, {.time = 1.0, .translate = {0, -0.1, 0}, .rotate = {0, 180.0, 0}}};
    CHECK(pins_refused(scene, 1.0) == "accepted");
}

TEST_CASE("a pin and a collider that run into each other are refused", "[start]") {
    std::string key;
    Scene scene = towel();
    scene.cloths[0].contact_thickness = 1e-3;
    scene.colliders.emplace_back();
    scene.colliders[0].name = "ball";
    scene.colliders[0].radius = 0.05;
    scene.colliders[0].center = {0.0, 0.2, 0.15};  // a decimetre from the upper edge
    CHECK(pins_refused(scene, 2.0) == "accepted");
    scene.colliders[0].path = {{.time = 0.0}, {.time = 1.0, .translate = {0.0, 0.0, -0.2}}};
    CHECK(pins_refused(scene, 0.45) == "accepted");
    CHECK_THAT(
        pins_refused(scene, 2.0, &key),
        Contains("pin[1] holds vertex 42 of cloth towel at (0, 0.2, 0) at 0.5 s (frame 30), 0.5 mm nearer to "
                 "collider ball than contact lets it be"));
    CHECK(key == "collider[0].path");
    scene.events = {{.time = 0.1, .collider = 0}};
    CHECK(pins_refused(scene, 2.0) == "accepted");
    scene.events.clear();
    scene.simulation.contact = ContactKind::penalty;
    CHECK(pins_refused(scene, 2.0) == "accepted");
    scene.simulation.contact = ContactKind::barrier;
    scene.colliders[0].path.clear();
    scene.pins[1].path = {{.time = 0.0}, {.time = 1.0, .translate = {0.0, -0.05, 0.15}}};
    CHECK_THAT(pins_refused(scene, 2.0, &key), Contains("nearer to collider ball"));
    CHECK(key == "pin[1].path");
}

TEST_CASE("of a curved rest shape the way along it counts, not the straight one", "[start]") {
    Scene scene = towel();
    MeshData arch = rest_shape(scene.cloths[0]);
    for (Eigen::Index v = 0; v < arch.positions.rows(); ++v) {
        const double y = arch.positions(v, 1);
        arch.positions(v, 1) = 0.5 * y;  // as steep as 60 degrees on both sides
        arch.positions(v, 2) = -std::abs(y) * std::sqrt(0.75);
    }
    scene.cloths[0].mesh = arch;
    for (PinDesc& pin : scene.pins) pin.edge.reset();
    scene.pins[0].greatest = "-y";
    scene.pins[1].greatest = "y";
    scene.pins[1].path = {{.time = 0.0}, {.time = 1.0, .translate = {0.0, 0.2, 0.0}}};
    CHECK(pins_refused(scene, 1.0) == "accepted");  // 0.4 m apart, flat
    scene.pins[1].path[1].translate.y() = 0.3;
    CHECK_THAT(pins_refused(scene, 1.0), Contains("where at rest the way is 0.4 m"));
}

TEST_CASE("a strain limit is refused where the velocity filter moves cloth after a step", "[start]") {
    Scene scene = towel();
    scene.simulation.contact = ContactKind::velocity_filter;
    CHECK(refusal([&] { validate(scene); }) == "accepted");
    scene.colliders.emplace_back();
    scene.colliders[0].name = "ball";
    std::string key;
    CHECK_THAT(
        refusal([&] { validate(scene); }, &key),
        Contains("is 1.05 beside simulation.contact = \"velocity_filter\" and collider[0], \"ball\"") &&
            Contains("choose contact = \"barrier\" or \"penalty\", or set the limit to 0"));
    CHECK(key == "cloth[0].fabric.strain_limit");
    scene.colliders[0].enabled = false;
    CHECK(refusal([&] { validate(scene); }) == "accepted");
    scene.events = {{.time = 1.0, .collider = 0}};
    CHECK_THAT(refusal([&] { validate(scene); }), Contains("velocity_filter"));
    scene.colliders[0].touchable = false;
    CHECK(refusal([&] { validate(scene); }) == "accepted");
}

TEST_CASE("contact's lengths follow a cloth's size where nothing is said", "[start]") {
    Scene scene = towel();
    CHECK(*build_model(scene).scene.cloths[0].contact_thickness == 1e-3);
    CHECK(*build_model(scene).scene.simulation.contact_activation == 1e-3);
    scene.cloths.push_back(scene.cloths[0]);
    scene.cloths[1].grid.size = {0.006, 0.008};  // a diagonal of 10 mm
    scene.cloths.push_back(scene.cloths[0]);
    scene.cloths[2].grid.size = {60.0, 80.0};
    const Scene settled = build_model(scene).scene;
    CHECK(*settled.cloths[0].contact_thickness == 1e-3);
    CHECK(*settled.cloths[1].contact_thickness == Approx(1e-4));
    CHECK(*settled.cloths[2].contact_thickness == Approx(1e-2));
    CHECK(*settled.simulation.contact_activation == Approx(1e-4));  // the least of them
    scene.cloths[1].contact_thickness = 3e-4;
    scene.simulation.contact_activation = 2e-4;
    CHECK(*build_model(scene).scene.cloths[1].contact_thickness == 3e-4);
    CHECK(*build_model(scene).scene.simulation.contact_activation == 2e-4);
}
