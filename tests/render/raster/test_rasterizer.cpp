// Pictures known without a renderer. Values are derived from the shading that rasterizer.h documents.

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
