// Patterns, images and threads on cloth.

#include <catch2/catch.hpp>
#include <cmath>
#include <string>
#include <vector>

#include "render/raster/stage.h"

using namespace cloth::render;
using namespace cloth::render::testing;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;

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
