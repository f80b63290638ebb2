// Pictures known without a renderer. Values are derived from the shading that rasterizer.h documents.

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

#include "render/ambient_occlusion.h"
#include "render/gl_context.h"
#include "render/rasterizer.h"
#include "temporary_folder.h"

extern char** environ;

using namespace cloth::render;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

namespace {

constexpr float pi = std::numbers::pi_v<float>;

/// Linear 0 … 1 → 8-bit sRGB, by the standard's formula.
int srgb(double c) {
    return static_cast<int>(
        std::lround(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055)));
}

struct Mesh {
    std::vector<float> positions, normals;
    std::vector<std::uint32_t> triangles;

    Surface surface(const Material& material = {}, bool two_sided = false) const {
        return {positions, normals, triangles, material, two_sided};
    }
};

/// n x n squares over the parallelogram centre ± u ± v; the normal is u × v.
Mesh sheet(const Float3& center, const Float3& u, const Float3& v, int n = 1) {
    Mesh mesh;
    Float3 normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const float length = std::hypot(normal[0], normal[1], normal[2]);
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                const float s = 2 * static_cast<float>(i) / static_cast<float>(n) - 1;
                const float t = 2 * static_cast<float>(j) / static_cast<float>(n) - 1;
                mesh.positions.push_back(center[axis] + s * u[axis] + t * v[axis]);
                mesh.normals.push_back(normal[axis] / length);
            }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i),
                       b = a + static_cast<std::uint32_t>(n) + 1;
            mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return mesh;
}

Mesh sphere(const Float3& center, float radius, int n = 32) {
    Mesh mesh;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= 2 * n; ++i) {
            const float polar = pi * static_cast<float>(j) / static_cast<float>(n);
            const float azimuth = pi * static_cast<float>(i) / static_cast<float>(n);
            const Float3 normal{std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                std::sin(polar) * std::sin(azimuth)};
            for (int axis = 0; axis < 3; ++axis) {
                mesh.positions.push_back(center[axis] + radius * normal[axis]);
                mesh.normals.push_back(normal[axis]);
            }
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < 2 * n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (2 * n + 1) + i);
            const std::uint32_t b = a + 2 * static_cast<std::uint32_t>(n) + 1;
            mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return mesh;
}

Material matte(const Float3& front, const Float3& back) {
    return {.front = front, .back = back, .roughness = 0.7f, .specular = 0, .sheen = 0};
}
Material matte(const Float3& color) {
    return matte(color, color);
}

/// From (0, 0, 3): at the plane z = 0 the picture is 2 m high, so a pixel of 240 is 1/120 m.
View plain_view(int width = 240, int height = 240) {
    View view;
    view.width = width;
    view.height = height;
    view.field_of_view = 2 * std::atan(1.0f / 3) * 180 / pi;
    view.light = {.direction = {0, 0, 1}, .color = {1, 1, 1}, .intensity = pi, .shadow = false};
    view.sky = view.background = {0, 0, 0};
    view.ambient_occlusion = false;
    return view;
}

/// From (0, 6, 0) straight down, x to the right: at the floor y = 0 the picture is 4 m high.
View view_from_above() {
    View view = plain_view(300, 300);
    view.eye = {0, 6, 0};
    view.up = {0, 0, -1};
    view.light.direction = {1, 1, 0};
    view.light.shadow = true;
    return view;
}
/// The column of the picture from above where x lies on the floor.
int column_at(double x) {
    return static_cast<int>(std::floor(150 + x * 75));
}

Frame frame_of(std::initializer_list<Surface> surfaces, std::optional<Ground> ground = {}) {
    return {std::vector<Surface>(surfaces), ground};
}

Rasterizer& rasterizer() {
    static Rasterizer one(2);
    return one;
}
Image draw(const Frame& frame, const View& view) {
    return rasterizer().draw(frame, view);
}

using Rgb = std::array<int, 3>;
Rgb rgb(const Image& image, int x, int y) {
    const std::uint8_t* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}
Rgb center(const Image& image) {
    return rgb(image, image.width / 2, image.height / 2);
}
/// By at most one step: samples are rounded to 10 bits, pixels to 8.
bool close(const Rgb& a, const Rgb& b) {
    return std::abs(a[0] - b[0]) <= 1 && std::abs(a[1] - b[1]) <= 1 && std::abs(a[2] - b[2]) <= 1;
}
Rgb grey(int value) {
    return {value, value, value};
}

/// Everything at once: cloth-like sheet over a sphere and a floor, all effects on.
struct Still {
    Mesh ball = sphere({0, 0, 0}, 0.25f), cloth = sheet({0, 0.3f, 0}, {0.5f, 0, 0}, {0, 0, -0.5f}, 40);
    Frame frame;
    View view;
    Still() {
        for (std::size_t i = 1; i < cloth.positions.size(); i += 3)
            cloth.positions[i] -=
                0.6f * std::pow(std::hypot(cloth.positions[i - 1], cloth.positions[i + 1]), 2.0f);
        const Material silk{.front = {0.5f, 0.1f, 0.1f}, .back = {0.2f, 0.2f, 0.5f}, .sheen = 0.5f};
        frame = frame_of({cloth.surface(silk, true), ball.surface()}, Ground{-0.4f, {0.6f, 0.6f, 0.6f}});
        view.width = 320;
        view.height = 180;
        view.eye = {0.9f, 0.6f, 1.6f};
    }
};

}  // namespace

// ---------------------------------------------------------------- background, edges, colours
TEST_CASE("an empty frame is exactly the background", "[rasterizer]") {
    View view = plain_view(33, 17);
    view.background = {0.25f, 0.6f, 0.75f};
    const Image image = draw({}, view);
    REQUIRE(image.width == 33);
    REQUIRE(image.height == 17);
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            REQUIRE(rgb(image, x, y) == Rgb{srgb(0.25), srgb(0.6), srgb(0.75)});
            REQUIRE(image.pixel(x, y)[3] == 255);
        }
}

TEST_CASE("a square covers as many pixels as its size says", "[rasterizer]") {
    // 1 m at 1/120 m a pixel, edges on pixel borders
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Image image = draw(frame_of({square.surface(matte({0.5f, 0.5f, 0.5f}))}), plain_view());
    int covered = 0;
    for (int y = 0; y < 240; ++y)
        for (int x = 0; x < 240; ++x) {
            const Rgb c = rgb(image, x, y);
            REQUIRE((c == grey(0) || c == grey(srgb(0.5))));
            covered += c != grey(0);
        }
    CHECK(covered == 120 * 120);
    CHECK(rgb(image, 60, 60) != grey(0));
    CHECK(rgb(image, 59, 60) == grey(0));
}

TEST_CASE("a pixel half covered has half the light", "[rasterizer]") {
    // Half a pixel wider to each side
    const float half = 0.5f + 0.5f / 120;
    const Mesh square = sheet({0, 0, 0}, {half, 0, 0}, {0, half, 0});
    const Image image = draw(frame_of({square.surface(matte({0.5f, 0.5f, 0.5f}))}), plain_view());
    CHECK(rgb(image, 59, 120) == grey(srgb(0.25)));
    CHECK(rgb(image, 180, 120) == grey(srgb(0.25)));
    CHECK(rgb(image, 120, 59) == grey(srgb(0.25)));
    CHECK(rgb(image, 59, 59) == grey(srgb(0.125)));
}

TEST_CASE("the picture is neither mirrored nor upside down", "[rasterizer]") {
    const Mesh square = sheet({0.5f, 0.5f, 0}, {0.1f, 0, 0}, {0, 0.1f, 0});  // right of and above the middle
    const Image image = draw(frame_of({square.surface()}), plain_view());
    CHECK(rgb(image, 180, 60) != grey(0));
    CHECK(rgb(image, 60, 60) == grey(0));
    CHECK(rgb(image, 180, 180) == grey(0));
}

TEST_CASE("a matte plane facing the light has its reflectance times the light", "[rasterizer]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Frame frame = frame_of({square.surface(matte({0.8f, 0.6f, 0.1f}))});
    View view = plain_view();
    view.light.intensity = 0.5f * pi;  // below the tone curve's knee of 0.6
    CHECK(center(draw(frame, view)) == Rgb{srgb(0.4), srgb(0.3), srgb(0.05)});
    view.light.direction = {0, std::sqrt(3.0f), 1};  // at 60°: half of it, of any length
    CHECK(close(center(draw(frame, view)), {srgb(0.2), srgb(0.15), srgb(0.025)}));
    view.exposure = 2;
    CHECK(close(center(draw(frame, view)), {srgb(0.4), srgb(0.3), srgb(0.05)}));
    view.light.direction = {0, 0, -1};
    CHECK(center(draw(frame, view)) == grey(0));
}

TEST_CASE("bright light rolls off towards white", "[rasterizer]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Frame frame = frame_of({square.surface(matte({1, 1, 1}))});
    View view = plain_view();
    int last = 0;
    for (const double radiance : {0.3, 0.6, 0.7, 1.0, 2.0, 6.0}) {
        CAPTURE(radiance);
        view.light.intensity = static_cast<float>(radiance) * pi;
        const double shown = radiance < 0.6 ? radiance : 0.6 + 0.4 * (1 - std::exp(-(radiance - 0.6) / 0.4));
        const int value = center(draw(frame, view))[0];
        CHECK(std::abs(value - srgb(shown)) <= 1);  // rounded twice
        CHECK(value > last);
        last = value;
    }
    CHECK(last == 255);
}

TEST_CASE("the sky lights what faces up, half of what faces sideways", "[rasterizer]") {
    View view = plain_view();
    view.light.intensity = 0;
    view.sky = {0.5f, 0.5f, 0.5f};
    const Material white = matte({1, 1, 1});
    const Mesh upright = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    CHECK(center(draw(frame_of({upright.surface(white)}), view)) == grey(srgb(0.25)));
    const Mesh level = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0, -0.5f});
    view.eye = {0, 3, 0.5f};
    CHECK(center(draw(frame_of({level.surface(white)}), view)) == grey(srgb(0.5)));
    view.eye = {0, -3, 0.5f};  // its lower side: neither sky nor, without a floor, anything else but black
    CHECK(center(draw(frame_of({level.surface(white, true)}), view)) == grey(0));
}

TEST_CASE("a highlight adds light where the view mirrors the light", "[rasterizer]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    Material glossy = matte({0, 0, 0});
    glossy.specular = 0.04f;
    glossy.roughness = 0.5f;
    View view = plain_view();
    view.light.intensity = 0.5f * pi;
    // Seen and lit along the normal: F D G / 4 · π · E/π with D = 1 / (π r⁴), G = 1
    const double expected = 0.5 * 0.04 / (4 * std::pow(0.5, 4));
    CHECK(std::abs(center(draw(frame_of({square.surface(glossy)}), view))[0] - srgb(expected)) <= 1);
}

// ---------------------------------------------------------------- two sides
TEST_CASE("cloth shows its other colour from behind, lit from behind", "[rasterizer]") {
    const Mesh cloth = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Frame frame = frame_of({cloth.surface(matte({0.5f, 0, 0}, {0, 0, 0.3f}), true)});
    View view = plain_view();
    CHECK(center(draw(frame, view)) == Rgb{srgb(0.5), 0, 0});
    view.eye[2] = -3;
    CHECK(center(draw(frame, view)) == grey(0));  // the light is on the far side
    view.light.direction[2] = -1;
    CHECK(center(draw(frame, view)) == Rgb{0, 0, srgb(0.3)});
}

TEST_CASE("the front is where the normals point, whichever way triangles turn", "[rasterizer]") {
    Mesh cloth = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Material material = matte({0.5f, 0, 0}, {0, 0, 0.3f});
    const Image expected = draw(frame_of({cloth.surface(material, true)}), plain_view());
    for (std::size_t i = 0; i < cloth.triangles.size(); i += 3)
        std::swap(cloth.triangles[i], cloth.triangles[i + 1]);
    CHECK(draw(frame_of({cloth.surface(material, true)}), plain_view()).rgba == expected.rgba);
}

// ---------------------------------------------------------------- shadow
TEST_CASE("a shadow's edge falls where the light's direction puts it", "[rasterizer]") {
    // At 45°, a square at height 1 with x in -0.5 … 0.5 darkens the floor's x in -1.5 … -0.5.
    const Mesh square = sheet({0, 1, 0}, {0.5f, 0, 0}, {0, 0, -0.5f});
    View view = view_from_above();
    view.light.intensity = pi;
    const Image image = draw(frame_of({square.surface()}, Ground{0, {0.5f, 0.5f, 0.5f}}), view);
    const int lit = rgb(image, column_at(-1.6), 150)[0], dark = rgb(image, column_at(-1.2), 150)[0];
    CHECK(lit > 100);
    CHECK(dark == 0);  // black sky
    int edge = column_at(-1.6);
    while (rgb(image, edge, 150)[0] > lit / 2) ++edge;
    CHECK(std::abs(edge - column_at(-1.5)) <= 1);
    // Across it: z in -0.5 … 0.5
    CHECK(rgb(image, column_at(-1.2), 150 + 35)[0] == 0);
    CHECK(rgb(image, column_at(-1.2), 150 + 40)[0] > 100);
}

TEST_CASE("a shadow is as soft as asked for", "[rasterizer]") {
    const Mesh square = sheet({0, 1, 0}, {0.5f, 0, 0}, {0, 0, -0.5f});
    View view = view_from_above();
    view.light.softness = 0.04f;  // across the light; 0.04 √2 m on the floor to each side, 8.5 pixels in all
    const Image image = draw(frame_of({square.surface()}, Ground{0, {0.5f, 0.5f, 0.5f}}), view);
    int soft = 0;
    for (int x = column_at(-1.6); x < column_at(-1.4); ++x) {
        const int value = rgb(image, x, 150)[0];
        CHECK(value + 1 >= rgb(image, x + 1, 150)[0]);
        soft += value > 12 && value < rgb(image, column_at(-1.6), 150)[0] - 12;
    }
    CHECK(soft >= 5);
    CHECK(soft <= 9);
}

TEST_CASE("a shadow can be left out", "[rasterizer]") {
    const Mesh square = sheet({0, 1, 0}, {0.5f, 0, 0}, {0, 0, -0.5f});
    const Frame frame = frame_of({square.surface()}, Ground{0, {0.5f, 0.5f, 0.5f}});
    View view = view_from_above();
    view.light.shadow = false;
    const Image image = draw(frame, view);
    CHECK(std::abs(rgb(image, column_at(-1.2), 150)[0] - rgb(image, column_at(1.2), 150)[0]) <= 1);
    view.light.shadow = true;
    Frame unshaded = frame;
    unshaded.surfaces[0].casts_shadow = false;
    CHECK(draw(unshaded, view).rgba == image.rgba);
}

TEST_CASE("a shadow starts at the foot of what casts it", "[rasterizer]") {
    const Mesh wall = sheet({0, 0.5f, 0}, {0, 0.5f, 0}, {0, 0, 0.5f});
    const Image image =
        draw(frame_of({wall.surface({}, true)}, Ground{0, {0.5f, 0.5f, 0.5f}}), view_from_above());
    CHECK(rgb(image, column_at(-0.04), 150)[0] == 0);
    CHECK(rgb(image, column_at(-0.9), 150)[0] == 0);
    CHECK(rgb(image, column_at(0.3), 150)[0] > 100);
}

TEST_CASE("surfaces shade each other", "[rasterizer]") {
    const Mesh upper = sheet({0, 1, 0}, {0.3f, 0, 0}, {0, 0, -0.3f}),
               lower = sheet({0, 0, 0}, {2, 0, 0}, {0, 0, -2});
    const Image image =
        draw(frame_of({upper.surface(), lower.surface(matte({0.5f, 0.5f, 0.5f}))}), view_from_above());
    CHECK(rgb(image, column_at(-1), 150)[0] == 0);
    CHECK(rgb(image, column_at(1), 150)[0] > 100);
}

TEST_CASE("a plane never shades itself", "[rasterizer]") {
    for (const float tilt : {0.0f, 40.0f, 70.0f, 85.0f}) {  // between its normal and the light [degree]
        CAPTURE(tilt);
        for (const int squares : {1, 50}) {
            const Mesh plane = sheet({0, 0, 0}, {0.8f, 0, 0}, {0, 0.8f, 0}, squares);
            const Frame frame = frame_of({plane.surface({}, true)});
            View view = plain_view();
            view.light.direction = {std::sin(tilt * pi / 180), 0.1f, std::cos(tilt * pi / 180)};
            view.light.shadow = true;
            const Image shaded = draw(frame, view);
            view.light.shadow = false;
            CHECK(compare(shaded, draw(frame, view)).largest == 0);
        }
    }
}

TEST_CASE("a sphere shades itself only where it turns away from the light", "[rasterizer]") {
    const Mesh ball = sphere({0, 0, 0}, 0.6f, 64);
    const Frame frame = frame_of({ball.surface(matte({0.6f, 0.6f, 0.6f}))});
    View view = plain_view();
    view.light.direction = {1, 0.5f, 0.3f};
    view.light.shadow = true;
    const Image shaded = draw(frame, view);
    view.light.shadow = false;
    const ImageDifference difference = compare(shaded, draw(frame, view));
    CAPTURE(difference.largest, difference.worst_x, difference.worst_y);
    CHECK(difference.fraction_over_2 < 1e-3);
}

// ---------------------------------------------------------------- floor
TEST_CASE("the floor fades into the background without a horizon", "[rasterizer]") {
    View view = plain_view(200, 200);
    view.eye = {0, 0.6f, 3};
    view.field_of_view = 60;
    view.light.direction = {0, 1, 0};
    view.background = {0.7f, 0.72f, 0.75f};
    const Image image = draw(frame_of({}, Ground{-0.2f, {0.2f, 0.2f, 0.2f}}), view);
    CHECK(rgb(image, 100, 0) == Rgb{srgb(0.7), srgb(0.72), srgb(0.75)});
    CHECK(rgb(image, 100, 199)[0] < 170);
    for (int y = 0; y + 1 < 200; ++y) {
        CAPTURE(y);
        CHECK(std::abs(rgb(image, 100, y)[0] - rgb(image, 100, y + 1)[0]) <= 8);  // of a range of 100
    }
}

TEST_CASE("the floor hides what lies below it, and is not seen from below", "[rasterizer]") {
    const Mesh low = sheet({0, -0.5f, 0}, {0.3f, 0, 0}, {0, 0, -0.3f});
    const Ground ground{0, {0.5f, 0.5f, 0.5f}};
    View view = view_from_above();
    view.light.shadow = false;
    const Image floor = draw(frame_of({}, ground), view);
    CHECK(draw(frame_of({low.surface(matte({0.5f, 0, 0}))}, ground), view).rgba == floor.rgba);
    view.eye = {0, -6, 0};
    view.background = {0.25f, 0.25f, 0.25f};
    const Image below = draw(frame_of({low.surface(matte({0.5f, 0, 0}), true)}, ground), view);
    CHECK(rgb(below, 10, 10) == grey(srgb(0.25)));
    CHECK(center(below) != grey(srgb(0.25)));
}

// ---------------------------------------------------------------- ambient occlusion
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

TEST_CASE("the floor is darker below an object", "[rasterizer]") {
    const Mesh square = sheet({0, 0.3f, 0}, {0.5f, 0, 0}, {0, 0, -0.5f}, 10);
    const Frame frame = frame_of({square.surface({}, true)}, Ground{0, {0.5f, 0.5f, 0.5f}});
    View view = plain_view();
    view.eye = {0, 0.5f, 3};
    view.light.intensity = 0;
    view.sky = {1, 1, 1};
    const Image open = draw(frame, view);
    view.ambient_occlusion = true;
    const Image occluded = draw(frame, view);
    CHECK(center(occluded)[0] < center(open)[0] - 30);
    CHECK(std::abs(rgb(occluded, 5, 235)[0] - rgb(open, 5, 235)[0]) <= 3);
}

// ---------------------------------------------------------------- the same again
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
        const auto picture = folder / threads;
        setenv("CLOTH_TEST_THREADS", threads, 1);
        setenv("CLOTH_TEST_PICTURE", picture.c_str(), 1);
        unsetenv("LP_NUM_THREADS");  // this process's own choice
        std::string program = "/proc/self/exe", tag = "[.still]", quiet = "--out=/dev/null";
        std::array<char*, 4> arguments{program.data(), tag.data(), quiet.data(), nullptr};
        pid_t child = 0;
        REQUIRE(posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ) == 0);
        int status = -1;
        REQUIRE(waitpid(child, &status, 0) == child);
        REQUIRE(status == 0);
        CHECK(read_png(picture).rgba == expected.rgba);
    }
}

// ---------------------------------------------------------------- refusals
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

// ---------------------------------------------------------------- driver
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
