// Finished pictures: colours, edges, numbers and motion blur over a scene whose picture is known.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "pipeline/picture/overlap_picture.h"
#include "pipeline/picture/picture.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/image/colormap.h"
#include "render/raster/surface_map.h"
#include "sim/model.h"
#include "sim/simulation.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

/// A square metre that faces the camera: 400 pixels wide in the middle of 640 x 480.
SceneFile facing(const std::string& output, const std::string& more = "") {
    return parse_scene(R"(version = 1
[[cloth]]
resolution = [6, 6]
diagonals = "uniform"
subdivisions = 0
[camera]
position = [0, 0, 3]
field_of_view = 22.6198649
[output]
size = [640, 480]
)" + output + more,
                       "facing.toml", std::filesystem::temp_directory_path());
}

struct Studio {
    explicit Studio(SceneFile f)
        : file(std::move(f)), model(build_model(file.scene)), state(start_state(model)) {}
    render::Image draw(StateReader reader = {}) {
        RunFacts facts = facts_of(file);
        return PictureMaker(file, model, facts, rasterizer, std::move(reader)).draw(state);
    }
    SceneFile file;
    Model model;
    State state;
    render::Rasterizer rasterizer{1};
};

std::array<int, 3> at(const render::Image& image, int x, int y) {
    const auto* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}

}  // namespace

TEST_CASE("a cloth that faces the eye has exactly the colour of its number", "[picture]") {
    Studio studio(facing("shade = \"kinetic\"\nshade_range = [0, 0.6]\n"));
    for (int i = 0; i < studio.model.vertex_count(); ++i)
        studio.state.velocities.segment<3>(3 * i) = Vec3(2, 0, 0);
    // ½ · 0.15 kg/m² · 4 m²/s² = 0.3 J/m²: the middle of the range. The light from the eye falls off by the
    // angle.
    const auto middle = render::viridis(0.5);
    const auto image = studio.draw();
    for (int k = 0; k < 3; ++k) CHECK(at(image, 320, 240)[k] == Approx(middle[k]).margin(1));
    CHECK(at(image, 20, 20) == at(Studio(facing("")).draw(), 20, 20));  // around it all is as without
}

TEST_CASE("colours follow the vertices: a gradient is linear across the cloth", "[picture]") {
    Studio studio(facing(
        "shade = \"gap\"\nshade_range = [0, 1]\n",
        "[[collider]]\nshape = \"plane\"\nnormal = [1, 0, 0]\ncenter = [-0.5, 0, 0]\ndrawn = false\n"));
    const auto image = studio.draw();
    for (const int x : {200, 260, 320, 380, 440}) {
        // Pixel x has its middle (x + ½ - 120)/400 m right of the plane.
        const auto color = render::viridis((x + 0.5 - 120) / 400.0);
        INFO(x);
        for (int k = 0; k < 3; ++k) CHECK(at(image, x, 240)[k] == Approx(color[k]).margin(4));
    }
}

TEST_CASE("edges lie where the simulated triangles' are, however the surface is subdivided", "[picture]") {
    for (const char* subdivisions : {"0", "2"}) {
        SceneFile plain = facing(""), file = facing("wireframe = true\n");
        plain.cloth_looks[0].subdivisions = file.cloth_looks[0].subdivisions = std::stoi(subdivisions);
        const auto with = Studio(file).draw(), without = Studio(plain).draw();
        // Five squares of 80 pixels: upright edges at x = 120, 200, …, 520; the row 250 crosses diagonals
        // elsewhere.
        const auto darker = [&](int x, int y) { return at(without, x, y)[0] - at(with, x, y)[0]; };
        INFO(subdivisions);
        for (const int x : {200, 280, 360, 440}) CHECK(darker(x, 250) + darker(x - 1, 250) > 40);
        for (const int x : {180, 260, 340}) CHECK(darker(x, 212) == 0);
        CHECK(at(with, 60, 240) == at(without, 60, 240));
    }
}

TEST_CASE("what stands before the cloth stays as it is", "[picture]") {
    const std::string ball = "[[collider]]\nradius = 0.2\ncenter = [0, 0, 0.5]\n";
    const auto plain = Studio(facing("", ball)).draw();
    const auto shaded = Studio(facing("shade = \"stretch\"\nshade_range = [0.5, 1]\n", ball)).draw();
    // Its light differs a little, as it sees another cloth; its colour does not turn into the scale's.
    for (int k = 0; k < 3; ++k) CHECK(at(shaded, 320, 240)[k] == Approx(at(plain, 320, 240)[k]).margin(6));
    const auto top = render::viridis(1);
    for (int k = 0; k < 3; ++k) CHECK(at(shaded, 180, 240)[k] == Approx(top[k]).margin(8));
}

TEST_CASE("motion blur is the mean of pictures on the way from the frame before", "[picture]") {
    Studio studio(facing("motion_blur = 2\nshutter = 1.0\n"));
    State before = studio.state;
    studio.state.frame = 1;
    for (int i = 0; i < studio.model.vertex_count(); ++i) studio.state.positions(3 * i) += 0.4;
    const auto blurred = studio.draw([&](std::int64_t frame) {
        CHECK(frame == 0);
        return before;
    });
    // Exposed at a quarter and three quarters of the way: left edges at 120 + 40 and 120 + 120 pixels.
    const auto sharp = Studio(facing("")).draw();
    const auto ground = at(sharp, 20, 240), cloth = at(sharp, 320, 240);
    CHECK(at(blurred, 150, 240) == ground);
    const auto mixed = at(blurred, 200, 240);
    for (int k = 0; k < 3; ++k) {
        CHECK(mixed[k] > std::min(ground[k], cloth[k]));
        CHECK(mixed[k] < std::max(ground[k], cloth[k]));
    }
    // Without the frame before, and at the start, there is nothing to blur.
    CHECK(at(studio.draw([](std::int64_t) { return std::nullopt; }), 290, 240) ==
          at(studio.draw(), 290, 240));
}

TEST_CASE("numbers are shown in a lens beside their place", "[picture]") {
    const SceneFile plain = facing(""), file = facing("ids = [240, 160, 40]\n");
    const auto with = Studio(file).draw(), without = Studio(plain).draw();
    // The place is at the top left, so the lens is at the bottom right and the rest is untouched.
    CHECK(at(with, 100, 400) == at(without, 100, 400));
    int changed = 0;
    for (int y = 250; y < 470; ++y)
        for (int x = 410; x < 630; ++x) changed += at(with, x, y) != at(without, x, y);
    CHECK(changed > 20000);
    CHECK(at(with, 280, 160) != at(without, 280, 160));  // the ring
}

TEST_CASE("parts of a subdivided triangle tile it", "[picture]") {
    for (int steps = 0; steps < 4; ++steps) {
        const auto parts = subdivision_parts(steps);
        CHECK(parts.size() == static_cast<std::size_t>(1) << (2 * steps));
        double area = 0;
        for (const auto& p : parts)
            area += (p[1][1] - p[0][1]) * (p[2][2] - p[0][2]) - (p[1][2] - p[0][2]) * (p[2][1] - p[0][1]);
        CHECK(area == Approx(1));
    }
}

TEST_CASE("what overlaps at the start is red where it stands, also behind other cloth", "[picture]") {
    const SceneFile file = parse_scene(R"(version = 1
[[cloth]]
name = "level"
resolution = [12, 12]
size = [0.5, 0.5]
rotate = [-90, 0, 0]
[[cloth]]
name = "upright"
resolution = [6, 6]
size = [0.2, 0.2]
translate = [0.013, 0.01, 0.007]
[camera]
position = [0.4, 1.0, 1.6]
[output]
size = [320, 240]
)",
                                       "cross.toml", std::filesystem::temp_directory_path());
    Simulation simulation(file.scene);
    render::Rasterizer rasterizer{1};
    try {
        simulation.step();
        FAIL("not refused");
    } catch (const OverlapError& overlap) {
        REQUIRE_FALSE(overlap.triangles.empty());
        const render::Image image =
            draw_overlap(file, simulation.model(), simulation.state(), overlap, rasterizer);
        render::View view = file.view;
        aim(view, overlap_camera(file, overlap), 0.0);
        const render::Pinhole camera(view);
        for (const auto& [a, b, c] : overlap.triangles) {
            const Vec3 middle = (a + b + c) / 3.0;
            const auto place = camera.project({static_cast<float>(middle.x()), static_cast<float>(middle.y()),
                                               static_cast<float>(middle.z())});
            const auto [red, green, blue] = at(image, static_cast<int>(place[0]), static_cast<int>(place[1]));
            CHECK(red > 100);
            CHECK(green < 0.5 * red);
            CHECK(blue < 0.5 * red);
        }
        const auto [red, green, blue] = at(image, 5, 5);
        CHECK(std::abs(red - green) < 30);
        CHECK(std::abs(red - blue) < 30);
    }
}
