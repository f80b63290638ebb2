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

#include "render/gl/gl_context.h"
#include "render/raster/ambient_occlusion.h"
#include "render/raster/rasterizer.h"
#include "support/temporary_folder.h"

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
    std::vector<float> positions, normals, coordinates;
    std::vector<std::uint32_t> triangles;

    Surface surface(const Material& material = {}, bool two_sided = false) const {
        Surface result{positions, normals, triangles, material, two_sided};
        result.coordinates = coordinates;
        return result;
    }
};

/// n x n squares over the parallelogram centre ± u ± v; the normal is u × v. Rest coordinates run from 0
/// along u and v [m].
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
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            mesh.coordinates.push_back(2 * static_cast<float>(i) / static_cast<float>(n) *
                                       std::hypot(u[0], u[1], u[2]));
            mesh.coordinates.push_back(2 * static_cast<float>(j) / static_cast<float>(n) *
                                       std::hypot(v[0], v[1], v[2]));
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
    view.light = {.direction = {0, 0, 1}, .color = {1, 1, 1}, .intensity = pi, .shadow = false, .angle = 0};
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
/// By at most one step: where a surface ends inside a pixel, its colour and the mix are both rounded.
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
    CHECK(close(rgb(image, 59, 120), grey(srgb(0.25))));
    CHECK(close(rgb(image, 180, 120), grey(srgb(0.25))));
    CHECK(close(rgb(image, 120, 59), grey(srgb(0.25))));
    CHECK(close(rgb(image, 59, 59), grey(srgb(0.125))));
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
    CHECK(std::abs(edge - column_at(-1.5)) <= 2);  // light on the floor is kept for 2x2 pixels
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

TEST_CASE("a shadow's edge widens with the way from what casts it", "[rasterizer]") {
    // At 45°, light of 8° across: over a way d its edge on the floor is 2 d tan 4° √2 wide.
    View view = view_from_above();
    view.light.angle = 8;
    const auto edge_width = [&](float height) {  // from a tenth to nine tenths of the light [pixel]
        const Mesh square = sheet({0, height, 0}, {0.4f, 0, 0}, {0, 0, -0.4f});
        const Image image = draw(frame_of({square.surface()}, Ground{0, {0.4f, 0.4f, 0.4f}}), view);
        int width = 0;
        const int lit = srgb(0.4 / std::sqrt(2.0) * 0.9), dark = srgb(0.4 / std::sqrt(2.0) * 0.1);
        for (int x = column_at(-height - 0.7); x < column_at(-height - 0.1); ++x) {
            const int value = rgb(image, x, 150)[0];
            width += value > dark && value < lit;
        }
        return width;
    };
    const double way = std::sqrt(2.0), full = 75 * 2 * std::tan(4 * pi / 180) * std::sqrt(2.0);
    // The disc's integral leaves out about a third of it at the two ends.
    CHECK(edge_width(0.05f) <= 3);
    CHECK(edge_width(0.25f) == Approx(0.65 * full * 0.25 * way).margin(2));
    CHECK(edge_width(0.5f) == Approx(0.65 * full * 0.5 * way).margin(3));
}

// ---------------------------------------------------------------- patterns
namespace {

Material patterned(Pattern pattern, float scale) {
    Material m = matte({0.1f, 0.1f, 0.1f}, {0.3f, 0, 0});
    m.pattern = pattern;
    m.pattern_scale = scale;
    m.pattern_colors = {{{0.5f, 0.5f, 0.5f}, {0.5f, 0, 0}, {0, 0.5f, 0}}};
    return m;
}

/// Mean of the linear red over a square of pixels.
double mean_red(const Image& image, int x0, int y0, int side) {
    double sum = 0;
    for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x) {
            const double c = rgb(image, x, y)[0] / 255.0;
            sum += c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
        }
    return sum / (side * side);
}

}  // namespace

TEST_CASE("a checker's square is as many pixels as its size says", "[pattern]") {
    // Repeat 0.25 m: squares of 0.125 m are 15 pixels. At the lower left corner is the first pattern colour.
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0}, 3);
    const Image image =
        draw(frame_of({square.surface(patterned(Pattern::checks, 0.25f), true)}), plain_view());
    for (int y = 0; y < 120; ++y)
        for (int x = 0; x < 120; ++x) {
            CAPTURE(x, y);
            const bool other = (x / 15 + y / 15) % 2 == 0;  // x from the left, y from below
            REQUIRE(close(rgb(image, 60 + x, 179 - y), grey(srgb(other ? 0.1 : 0.5))));
        }
}

TEST_CASE("stripes run along v and share each repeat by halves", "[pattern]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    const Image image =
        draw(frame_of({square.surface(patterned(Pattern::stripes, 0.1f), true)}), plain_view());
    for (const int y : {61, 120, 178})
        for (int x = 0; x < 120; ++x) {
            CAPTURE(x, y);
            REQUIRE(close(rgb(image, 60 + x, y), grey(srgb(x / 6 % 2 == 0 ? 0.5 : 0.1))));
        }
}

TEST_CASE("patterns settle to their mean colour in the distance, without moiré", "[pattern]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    // Repeats of a seventh of a pixel. Tartan: by its bands' widths; dots: 2 π / 16 of the area
    for (const auto& [pattern, red] : {std::pair{Pattern::stripes, 0.3},
                                       {Pattern::checks, 0.3},
                                       {Pattern::tartan, 0.5 * 0.37 + 0.1 * (1 - 0.37 - 0.06)},
                                       {Pattern::dots, 0.1 + 0.4 * pi / 8}}) {
        CAPTURE(static_cast<int>(pattern));
        const Image image =
            draw(frame_of({square.surface(patterned(pattern, 1.0f / 840), true)}), plain_view());
        for (int y = 62; y < 178; ++y)
            for (int x = 62; x < 178; ++x)
                REQUIRE(std::abs(rgb(image, x, y)[0] - srgb(red)) <=
                        (pattern == Pattern::stripes || pattern == Pattern::checks ? 16 : 6));
    }
    // At any distance the mean is kept: nothing is lost between far and near.
    for (const float scale : {0.2f, 0.05f, 0.02f, 0.01f}) {
        CAPTURE(scale);
        for (const Pattern pattern : {Pattern::stripes, Pattern::checks}) {
            const Image image =
                draw(frame_of({square.surface(patterned(pattern, scale), true)}), plain_view());
            CHECK(mean_red(image, 60, 60, 120) == Approx(0.3).margin(0.006));
        }
        const Image dots =
            draw(frame_of({square.surface(patterned(Pattern::dots, scale), true)}), plain_view());
        CHECK(mean_red(dots, 60, 60, 120) ==
              Approx(0.1 + 0.4 * pi / 8).margin(0.02));  // their mean is approximate
    }
}

TEST_CASE("a printed pattern is on the front, a woven one on both sides", "[pattern]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    Material m = patterned(Pattern::stripes, 1.0f);  // the left half
    View view = plain_view();
    view.eye = {0, 0, -3};
    view.light.direction = {0, 0, -1};
    const auto left_half = [&] { return rgb(draw(frame_of({square.surface(m, true)}), view), 150, 120); };
    CHECK(left_half() == Rgb{srgb(0.3), 0, 0});
    m.pattern_on_back = true;
    CHECK(left_half() == grey(srgb(0.5)));
}

TEST_CASE("an image lies upright on the rest coordinates, and as its mean in the distance", "[pattern]") {
    auto picture = std::make_shared<Image>();
    picture->width = picture->height = 2;
    const std::uint8_t a = 200, b = 100;
    picture->rgba = {a, 0, 0, 255, b, 0, 0, 255, 0, a, 0, 255, 0, b, 0, 255};  // upper row, lower row
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    Material m = matte({0, 0, 0});
    m.pattern = Pattern::image;
    m.image = picture;
    m.pattern_scale = 1;
    View view = plain_view();
    view.light.intensity = 0.9f * pi;
    Image image = draw(frame_of({square.surface(m, true)}), view);
    const auto linear = [](int c) { return std::pow((c / 255.0 + 0.055) / 1.055, 2.4); };
    // Half a pixel beside the texels' middles: a hundredth of the next one is mixed in.
    for (const auto& [x, y, channel, value] :
         {std::array{90, 90, 0, a + 0}, {150, 90, 0, b + 0}, {90, 150, 1, a + 0}, {150, 150, 1, b + 0}}) {
        CAPTURE(x, y);
        CHECK(std::abs(rgb(image, x, y)[channel] - srgb(0.9 * linear(value))) <= 2);
        CHECK(rgb(image, x, y)[1 - channel] < 20);
    }
    m.pattern_scale = 0.002f;
    image = draw(frame_of({square.surface(m, true)}), view);
    const int mean = srgb(0.9 * (linear(a) + linear(b)) / 4);
    CHECK(std::abs(rgb(image, 90, 90)[0] - mean) <= 2);
    CHECK(std::abs(rgb(image, 91, 150)[1] - mean) <= 2);
}

TEST_CASE("threads show near, and fade to a smooth sheet in the distance", "[pattern]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    Material m = matte({0.4f, 0.4f, 0.4f});
    View view = plain_view();
    view.light.direction = {0.8f, 0, 0.6f};
    const int smooth = center(draw(frame_of({square.surface(m, true)}), view))[0];
    const auto spread = [&](float spacing) {
        m.weave = spacing;
        const Image image = draw(frame_of({square.surface(m, true)}), view);
        int low = 255, high = 0;
        for (int y = 70; y < 170; ++y)
            for (int x = 70; x < 170; ++x) {
                low = std::min(low, rgb(image, x, y)[0]);
                high = std::max(high, rgb(image, x, y)[0]);
            }
        CHECK(low - 1 <= smooth);
        CHECK(high + 1 >= smooth);
        return high - low;
    };
    CHECK(spread(0.1f) > 40);         // 12 pixels a thread
    CHECK(spread(1.0f / 120) <= 14);  // one
    CHECK(spread(1.0f / 600) <= 1);
}

TEST_CASE("colours of vertices take the material's place", "[rasterizer]") {
    const Mesh square = sheet({0, 0, 0}, {0.5f, 0, 0}, {0, 0.5f, 0});
    Surface surface = square.surface(matte({0.1f, 0.1f, 0.1f}), true);
    const std::vector<float> colors{0.5f, 0, 0, 0, 0.5f, 0,
                                    0.5f, 0, 0, 0, 0.5f, 0};  // red on the left, green
    surface.colors = colors;
    const Image image = draw(frame_of({surface}), plain_view());
    CHECK(std::abs(rgb(image, 90, 120)[0] - srgb(0.75 * 0.5)) <= 2);
    CHECK(std::abs(rgb(image, 90, 120)[1] - srgb(0.25 * 0.5)) <= 2);
    CHECK(std::abs(rgb(image, 150, 120)[0] - srgb(0.25 * 0.5)) <= 2);
}

TEST_CASE("white cloth stays white and dark cloth readable in the default light", "[rasterizer]") {
    const Mesh ball = sphere({0, 0, 0}, 0.6f, 64);
    View view;
    view.width = view.height = 240;
    view.field_of_view = plain_view().field_of_view;
    const auto range = [&](float albedo) {  // least and greatest grey on the ball's lit half
        const Image image = draw(frame_of({ball.surface(matte({albedo, albedo, albedo}), true)}), view);
        int low = 255, high = 0;
        for (int y = 70; y < 110; ++y)
            for (int x = 70; x < 110; ++x) {
                low = std::min(low, rgb(image, x, y)[1]);
                high = std::max(high, rgb(image, x, y)[1]);
            }
        return std::pair{low, high};
    };
    CHECK(range(0.85f).second >= 225);
    CHECK(range(0.85f).second < 255);  // and not burnt out
    CHECK(range(0.02f).second - range(0.02f).first >= 8);
    CHECK(range(0.02f).first >= 20);
}

TEST_CASE("an edge between two surfaces is as clean as one against the background", "[rasterizer]") {
    // A slanted edge: along it every column crosses from one colour to the other by values in order.
    const Mesh near = sheet({-0.5f, 0.05f, 0.1f}, {0.5f, 0.1f, 0}, {0, 0.5f, 0}),
               far = sheet({0, 0, 0}, {0.9f, 0, 0}, {0, 0.9f, 0});
    const Image image =
        draw(frame_of({near.surface(matte({0.5f, 0.5f, 0.5f})), far.surface(matte({0.05f, 0.05f, 0.05f}))}),
             plain_view());
    int between = 0;
    for (int x = 20; x < 110; ++x)
        for (int y = 150; y < 200; ++y) {
            const int value = rgb(image, x, y)[0];
            CHECK(rgb(image, x, y + 1)[0] <= value);
            between += value > srgb(0.06) && value < srgb(0.49);
        }
    CHECK(between >=
          45);  // of 90 columns: with 2x2 samples every second one has a pixel that is partly covered
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

TEST_CASE("EGL without a surface draws the same picture as OSMesa", "[context]") {
    // One process keeps to one library, so EGL draws in another.
    const TemporaryFolder folder;
    const Still still;
    const auto picture = folder / "egl";
    setenv("CLOTH_TEST_PICTURE", picture.c_str(), 1);
    std::string program = "/proc/self/exe", tag = "[.egl]", quiet = "--out=/dev/null";
    std::array<char*, 4> arguments{program.data(), tag.data(), quiet.data(), nullptr};
    pid_t child = 0;
    REQUIRE(posix_spawn(&child, program.c_str(), nullptr, nullptr, arguments.data(), environ) == 0);
    int status = -1;
    REQUIRE(waitpid(child, &status, 0) == child);
    REQUIRE(status == 0);
    const ImageDifference difference = compare(read_png(picture), draw(still.frame, still.view));
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
