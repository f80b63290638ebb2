// Scenes that say next to nothing: what they leave out has to be right.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "pipeline/scene_file/scene_text.h"
#include "support/overlaps.h"

using namespace cloth;
using namespace cloth::pipeline;

TEST_CASE("a cloth and a collider alone run to rest, and nothing overlaps", "[scene_file]") {
    for (const std::string shape : {"sphere", "box", "plane"}) {
        CAPTURE(shape);
        const SceneFile file = parse(sheet(
            "rotate = [-90, 0, 0]\ntranslate = [0, 0.3, 0]\n[[collider]]\nshape = \"" + shape + "\"\n"));
        Simulation simulation(file.scene);
        FrameReport report;
        for (int frame = 0; frame < 300; ++frame) {
            report = simulation.advance_frame();
            REQUIRE(report.converged);
            REQUIRE(report.smallest_gap > 0.0);
            if (frame % 30 == 29) {
                REQUIRE(testing::crossing_triangles(simulation) == 0);
                REQUIRE(testing::points_inside(simulation) == 0);
            }
        }
        const VecX& v = simulation.state().velocities;
        CHECK(v.norm() <
              0.02 * std::sqrt(static_cast<double>(v.size()) / 3.0));  // its last swings, root mean square
        CHECK(report.contacts > 0);
    }
}
