// What is drawn passes through nothing that the simulated cloth does not.

#include <catch2/catch.hpp>
#include <string>

#include "pipeline/picture/clearance.h"
#include "pipeline/picture/frame_builder.h"
#include "pipeline/picture/picture.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/simulation.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

/// Seen straight from above; what is to stay hidden is green.
SceneFile from_above(const std::string& things) {
    return parse_scene("version = 1\n" + things + R"(
[camera]
position = [0, 2, 0]
target = [0, 0, 0]
up = [0, 0, -1]
field_of_view = 30
[output]
size = [480, 480]
)",
                       "covered.toml", ".");
}

std::string red_sheet(double size, const std::string& resolution, double height,
                      const std::string& more = "") {
    return "[[cloth]]\nsize = [" + std::to_string(size) + ", " + std::to_string(size) +
           "]\nresolution = " + resolution + "\nrotate = [-90, 0, 0]\ntranslate = [0, " +
           std::to_string(height) + ", 0]\nfabric = \"silk\"\ncolor = [1, 0, 0]\n" + more;
}

/// Pixels of anything green after so many frames.
int green_pixels(const SceneFile& file, int frames) {
    Simulation simulation(file.scene);
    for (int i = 0; i < frames; ++i) REQUIRE(simulation.advance_frame().converged);
    static render::Rasterizer rasterizer(1);
    const render::Image image =
        PictureMaker(file, simulation.model(), facts_of(file), rasterizer).draw(simulation.state());
    int red = 0, green = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            const auto* p = image.pixel(x, y);
            red += p[0] > p[1] + 40;
            green += p[1] > p[0] + 10;
        }
    REQUIRE(red > 30000);
    return green;
}

Model model_of(const std::string& text) {
    return build_model(parse_scene(text, "m.toml", ".").scene);
}

}  // namespace

TEST_CASE("a covered sphere does not show through, however coarse the cloth", "[clearance]") {
    for (const std::string resolution : {"8", "12", "[11, 17]", "24", "40"}) {
        CAPTURE(resolution);
        const int frames = resolution == "40" ? 12 : 20;
        CHECK(green_pixels(from_above(red_sheet(0.8, resolution, 0.26) +
                                      "[[collider]]\nradius = 0.25\ncolor = [0, 1, 0]\n"),
                           frames) == 0);
    }
}

TEST_CASE("a covered box does not show through, its edges neither", "[clearance]") {
    for (const std::string resolution : {"8", "12", "[13, 20]", "20", "40"}) {
        CAPTURE(resolution);
        const int frames = resolution == "40" ? 12 : 20;
        CHECK(green_pixels(from_above(red_sheet(0.8, resolution, 0.16) +
                                      "[[collider]]\nshape = \"box\"\nsize = [0.4, 0.3, 0.4]\n"
                                      "rotate = [0, 20, 0]\ncolor = [0, 1, 0]\n"),
                           frames) == 0);
    }
}

TEST_CASE("a covered layer of cloth does not show through the one above, its rim neither", "[clearance]") {
    for (const std::string resolution : {"8", "14", "24"}) {
        CAPTURE(resolution);
        std::string lower = red_sheet(0.5, resolution, 0.26);
        lower.replace(lower.find("[1, 0, 0]"), 9, "[0, 1, 0]");
        CHECK(green_pixels(from_above(lower + red_sheet(0.8, resolution, 0.263) +
                                      "[[collider]]\nradius = 0.25\ncolor = [0, 1, 0]\n"),
                           18) == 0);
    }
}

TEST_CASE("room is the distance to what is near: known by hand", "[clearance]") {
    // Two sheets in parallel planes 4 mm apart, one of them over a plane 2 mm below and under a box 10 mm
    // above
    const Model model = model_of(R"(version = 1
[[cloth]]
resolution = 3
rotate = [-90, 0, 0]
[[cloth]]
resolution = 3
rotate = [-90, 0, 0]
translate = [0, 0.004, 0]
[[collider]]
shape = "plane"
center = [0, -0.002, 0]
[[collider]]
shape = "box"
size = [4, 1, 4]
center = [0, 0.514, 0]
)");
    const State state = start_state(model);
    std::vector<double> reach(16, 0.003);
    for (int t = 8; t < 16; ++t) reach[t] = 0.009;
    const Clearance clearance(model, std::nullopt);
    Clearance::Room room = clearance.find(state, reach);
    for (int t = 0; t < 16; ++t) {
        CAPTURE(t);
        CHECK(room.layers[t] == Approx(t < 8 ? 0.001 : 0.003));  // of 4 mm, as one to three
        CHECK(room.all[t] == Approx(t < 8 ? 0.001 : 0.003));     // the plane is farther
    }
    reach.assign(16, 0.0021);
    room = clearance.find(state, reach);
    for (int t = 0; t < 16; ++t) CHECK(room.all[t] == Approx(0.002));
    reach.assign(16, 0.0019);  // 3.8 mm of 4 mm between the sheets, 1.9 of 2 mm above the plane
    room = clearance.find(state, reach);
    for (int t = 0; t < 16; ++t) CHECK(room.all[t] > 0.0019);
    reach.assign(16, 0.0);
    for (int t = 8; t < 16; ++t) reach[t] = 0.02;
    room = clearance.find(state, reach);
    CHECK(room.layers[12] == Approx(0.004));  // the other asks for nothing
    const Clearance floored(model, -0.001);
    reach.assign(16, 0.0015);
    room = floored.find(state, reach);
    CHECK(room.all[0] == Approx(0.001));
    CHECK(room.layers[0] > 1.0);
}

TEST_CASE("the smooth surface is drawn where there is room, and the simulated one where there is none",
          "[clearance]") {
    const auto heights = [](double center) {
        const SceneFile file = parse_scene(
            "version = 1\n[[cloth]]\nresolution = 5\nrotate = [-90, 0, 0]\nhem = 0.0\n"
            "[[collider]]\nshape = \"box\"\nsize = [4, 1, 4]\ncenter = [0, " +
                std::to_string(center) + ", 0]\n",
            "f.toml", ".");
        const Model model = build_model(file.scene);
        State state = start_state(model);
        state.positions(3 * 12 + 1) = 0.02;  // the middle vertex
        FrameBuilder builder(file, model);
        const render::Frame frame = builder.build(state);
        REQUIRE(frame.surfaces.size() == 2);
        std::vector<float> ys;
        for (std::size_t i = 1; i < frame.surfaces[0].positions.size(); i += 3)
            ys.push_back(frame.surfaces[0].positions[i]);
        return ys;
    };
    const auto highest = [](const std::vector<float>& ys) { return *std::max_element(ys.begin(), ys.end()); };
    const auto far = heights(-5.0), touching = heights(-0.5 - 1e-9);
    CHECK(highest(far) < 0.015f);  // Loop's surface stays below its vertices
    CHECK(highest(touching) == Approx(0.02).margin(1e-6));
    CHECK(*std::min_element(touching.begin(), touching.end()) > -1e-6f);
}
