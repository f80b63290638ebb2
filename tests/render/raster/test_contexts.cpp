// The same pixels every time and by every way, and what is refused.

#include <spawn.h>
#include <sys/wait.h>

#include <algorithm>
#include <array>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <numbers>
#include <string>
#include <vector>

#include "render/gl/gl_context.h"
#include "render/raster/ambient_occlusion.h"
#include "render/raster/rasterizer.h"
#include "render/raster/stage.h"
#include "support/temporary_folder.h"

extern char** environ;

using namespace cloth::render;
using namespace cloth::render::testing;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {

/// What the test of this program with `tag` leaves in `picture`.
Image drawn_by_another_process(std::string tag, const std::filesystem::path& picture) {
    setenv("CLOTH_TEST_PICTURE", picture.c_str(), 1);
    std::string program = "/proc/self/exe", quiet = "--out=/dev/null";
    std::array<char*, 4> arguments{program.data(), tag.data(), quiet.data(), nullptr};
    pid_t child = 0;
    REQUIRE(posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ) == 0);
    int status = -1;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(status == 0);
    return read_png(picture);
}

}  // namespace

TEST_CASE("two draws are bit-identical, whatever is drawn between them", "[rasterizer]") {
    const Still still;
    const Image first = draw(still.frame, still.view);
    CHECK(draw(still.frame, still.view).rgba == first.rgba);
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    View other = plain_view(97, 203);
    other.light.shadow = true;
    draw(frame_of({square.surface(), square.surface(), square.surface({}, true)}), other);
    draw({}, plain_view());
    CHECK(draw(still.frame, still.view).rgba == first.rgba);
    Rasterizer fresh;
    CHECK(fresh.draw(still.frame, still.view).rgba == first.rgba);
    CHECK(draw(still.frame, still.view).rgba == first.rgba);  // with another context made since
    Rasterizer moved = std::move(fresh);
    CHECK(moved.draw(still.frame, still.view).rgba == first.rgba);
}

// The driver reads its number of threads once a process, so each is drawn by a process of its own.
TEST_CASE("draws a still for the test of threads", "[.still]") {
    const char* threads = std::getenv("CLOTH_TEST_THREADS");
    const char* picture = std::getenv("CLOTH_TEST_PICTURE");
    REQUIRE(threads != nullptr);
    REQUIRE(picture != nullptr);
    const Still still;
    write_png(Rasterizer(std::atoi(threads)).draw(still.frame, still.view), picture);
}

TEST_CASE("the number of threads changes no pixel", "[rasterizer]") {
    const TemporaryFolder folder;
    const Still still;
    const Image expected = draw(still.frame, still.view);
    for (const char* threads : {"0", "1", "2", "5"}) {
        CAPTURE(threads);
        setenv("CLOTH_TEST_THREADS", threads, 1);
        unsetenv("LP_NUM_THREADS");  // this process's own choice
        CHECK(drawn_by_another_process("[.still]", folder / threads).rgba == expected.rgba);
    }
}

TEST_CASE("EGL without a surface draws the same picture as OSMesa", "[context]") {
    // One process keeps to one library, so EGL draws in another.
    const TemporaryFolder folder;
    const Still still;
    const Image by_egl = drawn_by_another_process("[.egl]", folder / "egl");
    const ImageDifference difference = compare(by_egl, draw(still.frame, still.view));
    CHECK(difference.fraction_over_2 <= 5e-4);
    CHECK(difference.fraction_over_32 <= 1e-4);
    CHECK(difference.psnr >= 57);
}

TEST_CASE("draws a still by EGL", "[.egl]") {
    const char* picture = std::getenv("CLOTH_TEST_PICTURE");
    REQUIRE(picture != nullptr);
    const Still still;
    Rasterizer egl(2, GlLibrary::egl);
    CHECK_THAT(egl.description(), Contains("llvmpipe"));
    write_png(egl.draw(still.frame, still.view), picture);
}

TEST_CASE("views that show nothing are refused with what is wrong", "[rasterizer]") {
    constexpr float nan = std::numeric_limits<float>::quiet_NaN();
    const auto message = [](auto change) {
        View view = plain_view();
        change(view);
        try {
            draw({}, view);
        } catch (const std::invalid_argument& error) {
            return std::string(error.what());
        }
        return std::string("none");
    };
    CHECK_THAT(message([](View& v) { v.width = 15; }),
               Equals("view: a size of 15 x 240 pixels; each side must be 16 to 8192"));
    CHECK_THAT(message([](View& v) { v.height = 8193; }),
               Equals("view: a size of 240 x 8193 pixels; each side must be 16 to 8192"));
    CHECK_THAT(message([](View& v) { v.target = v.eye; }), Contains("eye and target are both at (0.0"));
    CHECK_THAT(message([](View& v) { v.up = {0, 0, 5}; }), Contains("up (0.0") && Contains("is parallel"));
    CHECK_THAT(message([](View& v) { v.up = {0, 0, 0}; }), Contains("up (0.0") && Contains("is parallel"));
    CHECK_THAT(message([](View& v) { v.eye[1] = nan; }), Contains("view: eye") && Contains("is not finite"));
    CHECK_THAT(message([](View& v) { v.target[1] = nan; }),
               Contains("view: target") && Contains("not finite"));
    CHECK_THAT(message([](View& v) { v.up[1] = nan; }), Contains("view: up") && Contains("is not finite"));
    CHECK_THAT(message([](View& v) { v.light.direction[1] = nan; }), Contains("light.direction"));
    CHECK_THAT(message([](View& v) {
                   v.light.direction = {0, 0, 0};
               }),
               Equals("view: the light's direction is zero"));
    CHECK_THAT(message([](View& v) { v.light.softness = -1; }), Contains("softness of -1.0"));
    CHECK_THAT(message([](View& v) { v.light.softness = nan; }), Contains("softness of nan"));
    CHECK_THAT(message([](View& v) { v.light.angle = 46; }),
               Equals("view: a light of 46.000000 degrees; it must be 0 to 45"));
    CHECK_THAT(message([](View& v) { v.exposure = -1; }), Contains("exposure of -1.0"));
    CHECK_THAT(message([](View& v) { v.exposure = std::numeric_limits<float>::infinity(); }),
               Contains("exposure of inf"));
    for (const float angle : {0.5f, 161.0f, nan})
        CHECK_THAT(message([=](View& v) { v.field_of_view = angle; }),
                   Contains("degrees; it must be 1 to 160"));
    CHECK_THAT(message([](View& v) {
                   v.shadow_bounds = {{{0, 0, nan}, {1, 1, 1}}};
               }),
               Contains("shadow bounds") && Contains("are not finite"));
}

TEST_CASE("surfaces that do not fit together are refused with what is wrong", "[rasterizer]") {
    const auto message = [](auto change) {
        Mesh mesh = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
        change(mesh);
        const Mesh good = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
        try {
            draw(frame_of({good.surface(), mesh.surface()}), plain_view());
        } catch (const std::invalid_argument& error) {
            return std::string(error.what());
        }
        return std::string("none");
    };
    CHECK_THAT(message([](Mesh& m) { m.triangles[4] = 4; }),
               Equals("surface 1: triangle 1 names vertex 4 of 4"));
    CHECK_THAT(message([](Mesh& m) { m.triangles.pop_back(); }),
               Equals("surface 1: 5 triangle indices; there must be 3 per triangle"));
    CHECK_THAT(message([](Mesh& m) { m.normals.pop_back(); }),
               Equals("surface 1: 12 position and 11 normal components; both must be 3 per vertex"));
    CHECK_THAT(message([](Mesh& m) {
                   m.normals.pop_back();
                   m.positions.pop_back();
               }),
               Contains("surface 1: 11 position and 11 normal components"));
    CHECK_THAT(message([](Mesh& m) { m.positions[7] = std::numeric_limits<float>::infinity(); }),
               Equals("surface 1: the position of vertex 2 is not finite"));
    CHECK_THAT(message([](Mesh& m) { m.coordinates.pop_back(); }),
               Equals("surface 1: 7 rest coordinates; there must be none or 2 per vertex"));
    const Mesh good = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const std::vector<float> one_color(3, 0.5f);
    Surface colored = good.surface();
    colored.colors = one_color;
    CHECK_THROWS_WITH(draw(frame_of({colored}), plain_view()),
                      Equals("surface 0: 3 colour components; there must be none or 3 per vertex"));
    CHECK_THROWS_WITH(draw(frame_of({good.surface(patterned(Pattern::dots, 0))}), plain_view()),
                      Equals("surface 0: a pattern scale of 0.000000 m; it must be above 0"));
    CHECK_THROWS_WITH(draw(frame_of({good.surface(patterned(Pattern::image, 1))}), plain_view()),
                      Equals("surface 0: an image pattern without an image"));
    Material coarse;
    coarse.weave = -1;
    CHECK_THROWS_WITH(draw(frame_of({good.surface(coarse)}), plain_view()),
                      Equals("surface 0: a weave of -1.000000 m; it must be 0 or more"));
    CHECK_THROWS_WITH(draw(frame_of({}, Ground{std::numeric_limits<float>::quiet_NaN(), {}}), plain_view()),
                      Equals("the ground's height is not finite"));
}

TEST_CASE("a surface of nothing is drawn as nothing", "[rasterizer]") {
    const Mesh empty;
    View view;
    view.width = view.height = 16;
    CHECK(draw(frame_of({empty.surface({}, true)}, Ground{-1, {}}), view).rgba ==
          draw(frame_of({}, Ground{-1, {}}), view).rgba);
}

TEST_CASE("the driver is named", "[context]") {
    CHECK_THAT(rasterizer().description(), Contains("llvmpipe") && Contains("OpenGL 4"));
}

TEST_CASE("drivers that draw otherwise are refused by name", "[context]") {
    CHECK_NOTHROW(require_suitable_driver("llvmpipe (LLVM 15.0.6, 256 bits)", "4.5", 4, 5));
    CHECK_NOTHROW(require_suitable_driver("llvmpipe", "4.0", 4, 0));
    CHECK_THROWS_WITH(require_suitable_driver("softpipe", "4.5 Mesa 22", 4, 5),
                      Contains("unsuitable: softpipe, OpenGL 4.5 Mesa 22") && Contains("GALLIUM_DRIVER"));
    CHECK_THROWS_WITH(
        require_suitable_driver("swrast", "3.3 Mesa 9", 3, 3),
        Equals("the OpenGL driver is too old: swrast, OpenGL 3.3 Mesa 9; OpenGL 4.0 core is needed"));
}

TEST_CASE("a vector width at which the driver crashes is refused", "[context]") {
    setenv("LP_NATIVE_VECTOR_WIDTH", "512", 1);
    CHECK_THROWS_WITH(Rasterizer(), Contains("LP_NATIVE_VECTOR_WIDTH is 512, at which llvmpipe crashes"));
    unsetenv("LP_NATIVE_VECTOR_WIDTH");
}
