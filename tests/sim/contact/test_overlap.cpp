// Starts that overlap: what is told, and that what is advised works.

#include <catch2/catch.hpp>

#include "sim/contact/overlap.h"
#include "sim/simulation.h"
#include "support/barrier_scene.h"
#include "support/overlaps.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;

namespace {

Scene level_sheet(double height) {
    Scene scene = barrier_scene(5);
    scene.cloths[0].name = "towel";
    scene.cloths[0].transform.rotate = {-90.0, 0.0, 0.0};
    scene.cloths[0].transform.translate = {0.0, height, 0.0};
    return scene;
}

ColliderDesc collider(const char* name, Shape shape) {
    ColliderDesc c;
    c.name = name;
    c.shape = shape;
    return c;
}

/// What the first step is refused with, and how many triangles of cloth it marks.
std::string overlap_of(const Scene& scene, std::size_t* marked = nullptr) {
    Simulation simulation(scene);
    try {
        simulation.step();
    } catch (const OverlapError& e) {
        if (marked) *marked = e.cloth_triangles.size();
        return e.what();
    }
    return "";
}

/// The scene with every advice followed.
Scene advised(Scene scene, const std::string& text) {
    for (ClothDesc& cloth : scene.cloths) {
        const auto at = text.find("cloth " + cloth.name + " by ");
        if (at == text.npos) continue;
        Vec3& t = cloth.transform.translate;
        REQUIRE(std::sscanf(text.c_str() + text.find('[', at), "[%lf, %lf, %lf]", &t.x(), &t.y(), &t.z()) ==
                3);
    }
    return scene;
}

}  // namespace

TEST_CASE("cloth on the floor is told by how much to lift it, and all of it is marked", "[overlap]") {
    Scene scene = level_sheet(0.0);
    scene.colliders = {collider("floor", Shape::plane)};
    std::size_t marked = 0;
    const std::string text = overlap_of(scene, &marked);
    CHECK_THAT(text,
               Contains("things overlap: cloth towel and collider floor are 0.5 mm nearer than their "
                        "contact thickness at vertices 0, 1, 2, 3, 4, 5, 6, 7 and 17 more of cloth towel"));
    CHECK_THAT(text, Contains("; lift cloth towel by 0.51 mm, to translate = [0, 0.00051, 0]"));
    CHECK(marked == 32);
    const Scene lifted = advised(scene, text);
    Simulation simulation(lifted);
    for (int frame = 0; frame < 10; ++frame) REQUIRE(simulation.advance_frame().converged);
    // It is no spring: what the barrier pushes out at the start is little.
    CHECK(simulation.state().positions.reshaped(3, 25).row(1).maxCoeff() < 0.003);
}

TEST_CASE("a lift frees cloth of a box that it crosses, of a ball, and of another cloth", "[overlap]") {
    Scene scene = level_sheet(0.08);
    SECTION("box") {
        scene.colliders = {collider("block", Shape::box)};
        scene.colliders[0].size = {0.1, 0.2, 0.15};
        CHECK_THAT(overlap_of(scene), Contains("cloth towel triangle ") &&
                                          Contains(" crosses collider block triangle ") &&
                                          Contains(" more places"));
    }
    SECTION("ball") {
        scene.colliders = {collider("ball", Shape::sphere)};
        scene.colliders[0].radius = 0.1;
        const std::string text = overlap_of(scene);
        CHECK_THAT(text, Contains("cloth towel and collider ball are 20.5 mm nearer"));
        CHECK_THAT(text, Contains("lift cloth towel by 20.6 mm") || Contains("lift cloth towel by 20.5 mm"));
        CHECK_THAT(text, !Contains("of collider ball"));  // a point has no number
    }
    SECTION("cloth") {
        scene.cloths.push_back(scene.cloths[0]);
        scene.cloths[1].name = "sheet";
        scene.cloths[1].transform.translate.y() = 0.0802;
        CHECK_THAT(overlap_of(scene), Contains(" of cloth towel and ") &&
                                          Contains(" of cloth sheet; lift cloth sheet by 0.81 mm"));
    }
    const std::string text = overlap_of(scene);
    CHECK_THAT(text, Contains("lift cloth "));
    Simulation simulation(advised(scene, text));
    REQUIRE(simulation.step().converged);
    CHECK(crossing_triangles(simulation) == 0);
}

TEST_CASE("no lift is advised where it would not help", "[overlap]") {
    Scene scene = level_sheet(0.0);
    scene.colliders = {collider("floor", Shape::plane), collider("ceiling", Shape::plane)};
    scene.colliders[1].center.y() = 0.0004;
    scene.colliders[1].normal = {0.0, -1.0, 0.0};
    CHECK_THAT(overlap_of(scene),
               Contains("collider floor") && Contains("collider ceiling") && !Contains("lift"));
    // A ceiling alone: down.
    scene.colliders.erase(scene.colliders.begin());
    CHECK_THAT(overlap_of(scene), Contains("move cloth towel by ") && Contains("to translate = [0, -0."));
}

TEST_CASE("a collider switched on over cloth names the event, and has numbers of its own", "[overlap]") {
    Scene scene = level_sheet(0.0);
    scene.simulation.gravity.setZero();
    scene.colliders = {collider("block", Shape::box), collider("other", Shape::sphere)};
    scene.colliders[1].center.x() = 9.0;
    scene.colliders[0].enabled = scene.colliders[1].enabled = false;
    scene.colliders[0].size = {0.1, 0.1, 0.1};
    scene.colliders[0].center = {0.013, 0.021, 0.01};
    scene.events = {{.time = 0.02, .collider = 1}, {.time = 0.1, .collider = 0, .action = Switch::on}};
    Simulation simulation(scene);
    std::string text;
    int frame = 0;
    try {
        for (; frame < 20; ++frame) simulation.advance_frame();
    } catch (const OverlapError& e) {
        text = e.what();
    }
    CHECK(frame == 6);
    CHECK_THAT(
        text,
        Contains(
            "things overlap at 0.1 s, where an event switches collider block on: cloth towel triangle ") &&
            Contains(" crosses collider block triangle ") && !Contains("lift"));
}
