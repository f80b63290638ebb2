// How much of the sky and of the floor arrives at a point.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "render/raster/ambient_occlusion.h"
#include "render/raster/stage.h"

using namespace cloth::render;
using namespace cloth::render::testing;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

TEST_CASE("in the open all of the sky and of the floor arrives", "[occlusion]") {
    AmbientOcclusion occlusion;
    occlusion.build({}, {{-1, -1, -1}, {1, 1, 1}});
    for (const Float3& n : {Float3{0, 1, 0}, Float3{0, -1, 0}, Float3{1, 0, 0}, Float3{0, 0.6f, 0.8f}}) {
        const AmbientLight light = occlusion.at({0.1f, 0.2f, 0.3f}, n);
        CHECK(light.from_above == Approx((1 + n[1]) / 2).margin(1e-5));
        CHECK(light.from_below == Approx((1 - n[1]) / 2).margin(1e-5));
    }
}

TEST_CASE("a plane hides little of its own sky, a ceiling nearly all", "[occlusion]") {
    const Mesh floor = sheet({0, 0, 0}, {1, 0, 0}, {0, 0, -1}, 40);
    AmbientOcclusion occlusion;
    const Bounds bounds{{-1, 0, -1}, {1, 0.5f, 1}};
    std::vector<Surface> surfaces{floor.surface()};
    occlusion.build(surfaces, bounds);
    for (const float x : {-0.9f, -0.31f, 0.0f, 0.017f, 0.6f})
        CHECK(occlusion.at({x, 0, 0.5f * x}, {0, 1, 0}).from_above > 0.95f);
    for (const int squares : {1, 3, 40}) {  // large triangles hide as much as small ones
        const Mesh ceiling = sheet({0, 0.25f, 0}, {1, 0, 0}, {0, 0, -1}, squares);
        surfaces = {floor.surface(), ceiling.surface()};
        occlusion.build(surfaces, bounds);
        CHECK(occlusion.at({0, 0, 0}, {0, 1, 0}).from_above < 0.15f);
        CHECK(occlusion.at({0, 0.05f, 0}, {0, 1, 0}, false).from_above < 0.25f);
        CHECK(occlusion.at({0.95f, 0, 0}, {0, 1, 0}).from_above > 0.3f);
    }
}

TEST_CASE("occlusion changes smoothly as a surface moves", "[occlusion]") {
    AmbientOcclusion occlusion;
    const Bounds bounds{{-1, -0.5f, -1}, {1, 0.5f, 1}};
    float last = 0;
    for (int i = 0; i < 50; ++i) {  // a millimetre a step, across a grid cell of 33
        const Mesh ceiling =
            sheet({0, 0.2f + 0.001f * static_cast<float>(i), 0}, {0.3f, 0, 0}, {0, 0, -0.3f}, 20);
        const std::vector<Surface> surfaces{ceiling.surface()};
        occlusion.build(surfaces, bounds);
        const float now = occlusion.at({0, 0, 0}, {0, 1, 0}).from_above;
        if (i > 0) CHECK(std::abs(now - last) < 0.01f);
        last = now;
    }
}
