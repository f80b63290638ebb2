// The surfaces that the frame builder makes of cloths and colliders.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <string>

#include "pipeline/picture/frame_builder.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

SceneFile parse(const std::string& more) {
    return parse_scene("version = 1\n[[cloth]]\n" + more, "s.toml", ".");
}

}  // namespace

TEST_CASE("a cloth hangs with a rolled rim that keeps to its outline", "[frame_builder]") {
    const SceneFile f = parse("resolution = 5\nhem = 0.01\nsubdivisions = 0\n");
    const Model model = build_model(f.scene);
    FrameBuilder builder(f, model);
    const render::Frame frame = builder.build(start_state(model));
    REQUIRE(frame.surfaces.size() == 3);  // the sheet, and its rim's two halves
    for (const std::size_t half : {1u, 2u}) {
        const render::Surface& rim = frame.surfaces[half];
        CHECK_FALSE(rim.casts_shadow);
        CHECK(rim.positions.size() == 3 * 5 * 16);  // 16 rim vertices, 5 points across
        float low = 0, high = 0, outermost = 0;
        for (std::size_t i = 0; i < rim.positions.size(); i += 3) {
            low = std::min(low, rim.positions[i + 2]);
            high = std::max(high, rim.positions[i + 2]);
            outermost = std::max(outermost, std::abs(rim.positions[i]));
            const float length = std::hypot(rim.normals[i], rim.normals[i + 1], rim.normals[i + 2]);
            CHECK(length == Approx(1).margin(1e-5));
        }
        CHECK(high == Approx(half == 1 ? 0.005 : 0).margin(1e-6));  // half the thickness to each side
        CHECK(low == Approx(half == 1 ? 0 : -0.005).margin(1e-6));
        CHECK(outermost == Approx(0.505).margin(1e-6));
    }
    // Rest coordinates go on over the rim: there they are the positions too.
    for (const render::Surface& s : frame.surfaces)
        for (std::size_t v = 0; 2 * v < s.coordinates.size(); ++v)
            for (std::size_t k = 0; k < 2; ++k)
                CHECK(s.coordinates[2 * v + k] == Approx(s.positions[3 * v + k]).margin(1e-6));
    const SceneFile plain = parse("hem = 0.0\n");
    const Model plain_model = build_model(plain.scene);
    CHECK(FrameBuilder(plain, plain_model).build(start_state(plain_model)).surfaces.size() == 1);
}

TEST_CASE("a level plane is drawn as the ground, another one as a surface", "[frame_builder]") {
    const auto frame_of = [](const std::string& plane, const std::string& rest = "") {
        const SceneFile f =
            parse(std::string("hem = 0.0\n[[collider]]\nshape = \"plane\"\ncolor = [1, 0, 0]\n") +
                  "center = [0, -0.75, 0]\n" + plane + rest);
        const Model model = build_model(f.scene);
        return FrameBuilder(f, model).build(start_state(model));
    };
    for (const std::string level : {"", "spin = [0, 90, 0]\n", "normal = [0, 3, 0]\n"}) {
        CAPTURE(level);
        const render::Frame frame = frame_of(level);
        CHECK(frame.surfaces.size() == 1);
        CHECK(frame.ground == render::Ground{-0.75f, {1, 0, 0}});
    }
    for (const std::string other : {"normal = [0.1, 1, 0]\n", "spin = [90, 0, 0]\n", "normal = [0, -1, 0]\n",
                                    "path = [{ time = 0 }, { time = 1, translate = [0, 1, 0] }]\n"}) {
        CAPTURE(other);
        const render::Frame frame = frame_of(other);
        CHECK(frame.surfaces.size() == 2);
        CHECK_FALSE(frame.ground.has_value());
    }
    CHECK(frame_of("", "[ground]\nheight = -2.0\n").surfaces.size() ==
          2);  // it has the ground that it asks for
    CHECK_FALSE(frame_of("enabled = false\n").ground.has_value());
}
