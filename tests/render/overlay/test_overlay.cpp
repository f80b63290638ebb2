// Text, lines and areas over pictures: coverages known by hand.

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/image/colormap.h"
#include "render/overlay/overlay.h"

using namespace cloth::render;

namespace {

const Ink white{{255, 255, 255}}, black{{0, 0, 0}};

int grey(const Image& image, int x, int y) {
    return image.pixel(x, y)[0];
}

/// Ink on white, in whole pixels.
double ink_of(const Image& image) {
    double sum = 0;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += (255 - grey(image, x, y)) / 255.0;
    return sum;
}

}  // namespace

TEST_CASE("a rectangle covers pixels by their share of it", "[overlay]") {
    Image image = plain_image(8, 4, white);
    fill_rectangle(image, {1.5f, 1.0f}, {4.0f, 2.25f}, black);
    CHECK(grey(image, 0, 1) == 255);
    CHECK(grey(image, 1, 1) == 128);  // half a pixel wide
    CHECK(grey(image, 2, 1) == 0);
    CHECK(grey(image, 3, 2) == 191);  // a quarter high
    CHECK(grey(image, 4, 1) == 255);
    CHECK(grey(image, 2, 0) == 255);
    CHECK(ink_of(image) == Approx(2.5 * 1.25).margin(0.02));
    fill_rectangle(image, {-50.0f, -50.0f}, {500.0f, 500.0f}, {{255, 0, 0}, 1.0f});  // cut to the picture
    CHECK(int(image.pixel(7, 3)[0]) == 255);
    CHECK(int(image.pixel(7, 3)[1]) == 0);
    Image half = plain_image(2, 1, white);
    fill_rectangle(half, {0.0f, 0.0f}, {1.0f, 1.0f}, {{0, 0, 0}, 0.5f});
    CHECK(grey(half, 0, 0) == 128);
}

TEST_CASE("a line has its width, and a bend in it is not mixed twice", "[overlay]") {
    Image image = plain_image(40, 20, white);
    const std::vector<Float2> level{{5.0f, 10.0f}, {35.0f, 10.0f}};
    draw_polyline(image, level, 2.0f, black);
    CHECK(grey(image, 20, 9) == 0);
    CHECK(grey(image, 20, 10) == 0);
    CHECK(grey(image, 20, 8) == 255);
    CHECK(grey(image, 20, 11) == 255);
    Image twice = plain_image(40, 20, white);
    const std::vector<Float2> there_and_back{{5.0f, 10.0f}, {35.0f, 10.0f}, {5.0f, 10.0f}};
    draw_polyline(twice, there_and_back, 2.0f, {{0, 0, 0}, 0.5f});
    CHECK(grey(twice, 20, 10) == 128);
    Image disc = plain_image(40, 40, white);
    draw_polyline(disc, std::vector<Float2>{{20.0f, 20.0f}}, 20.0f, black);
    CHECK(ink_of(disc) == Approx(314.16).epsilon(0.01));  // π r²
    Image none = plain_image(4, 4, white);
    draw_polyline(none, std::vector<Float2>{{NAN, 1.0f}, {2.0f, 2.0f}}, 1.0f, black);
    draw_polyline(none, {}, 1.0f, black);
    draw_polyline(none, std::vector<Float2>{{100.0f, 100.0f}, {200.0f, 100.0f}}, 1.0f, black);
    CHECK(ink_of(none) == 0);
}

TEST_CASE("text stands on its line, as wide as it says, in digits of one width", "[overlay]") {
    CHECK(text_width("", 20) == 0);
    CHECK(text_width("1111", 20) == Approx(text_width("8408", 20)));
    CHECK(text_width("W", 40) == Approx(2 * text_width("W", 20)));
    Image image = plain_image(200, 60, white);
    draw_text(image, {20.0f, 40.0f}, "H", 30, black);
    int top = 60, bottom = -1, left = 200, right = -1;
    for (int y = 0; y < 60; ++y)
        for (int x = 0; x < 200; ++x)
            if (grey(image, x, y) < 128) {
                top = std::min(top, y), bottom = std::max(bottom, y);
                left = std::min(left, x), right = std::max(right, x);
            }
    CHECK(bottom == 39);
    CHECK(40 - top == Approx(capital_height(30)).margin(1.0));
    CHECK(left >= 20);
    CHECK(static_cast<float>(right) <= 20 + text_width("H", 30));

    // µ, ², θ have glyphs of their own; what the font lacks shows as a box, broken UTF-8 as a question mark.
    const auto drawn = [](const std::string& text) {
        Image page = plain_image(60, 40, white);
        draw_text(page, {5.0f, 30.0f}, text, 24, black);
        return page.rgba;
    };
    const auto missing = drawn("\xf4\x8f\xbf\xbf");
    for (const char* letter : {"µ", "²", "θ", "≤", "·", "…", "ν", "→"}) {
        INFO(letter);
        CHECK(drawn(letter) != missing);
    }
    CHECK(drawn("\xff") == drawn("\xef\xbf\xbd"));
    CHECK(drawn("a\xe2\x82") != drawn("a"));
    CHECK(drawn("same") == drawn("same"));
    // What leaves the picture is cut off.
    Image small = plain_image(16, 16, white);
    draw_text(small, {-8.0f, 12.0f}, "Wide text", 20, black);
    CHECK(ink_of(small) > 0);
}

TEST_CASE("pictures are pasted whole or cut, and averaged in linear light", "[overlay]") {
    Image page = plain_image(6, 6, white);
    const Image part = plain_image(4, 4, black);
    paste(page, part, 4, -2);
    CHECK(grey(page, 4, 0) == 0);
    CHECK(grey(page, 5, 1) == 0);
    CHECK(grey(page, 3, 0) == 255);
    CHECK(grey(page, 4, 2) == 255);
    CHECK(ink_of(page) == 4);
    paste(page, part, 100, 100);
    paste(page, part, -100, 0);
    CHECK(ink_of(page) == 4);

    const std::vector<Image> pair{plain_image(2, 2, white), plain_image(2, 2, black)};
    CHECK(grey(mean_image(pair), 1, 1) == 188);  // half the light, in sRGB
    for (int value = 0; value < 256; ++value) {
        const Image one = plain_image(1, 1, {{static_cast<std::uint8_t>(value), 0, 255}});
        CHECK(mean_image(std::vector<Image>{one, one, one}).rgba == one.rgba);
    }
    CHECK_THROWS_AS(mean_image({}), std::invalid_argument);
    CHECK_THROWS_WITH(mean_image(std::vector<Image>{plain_image(2, 2, white), plain_image(3, 2, white)}),
                      Catch::Contains("3 x 2 after 2 x 2"));
}

TEST_CASE("the colour scale grows lighter all the way", "[overlay]") {
    const auto lightness = [](double share) {
        const auto c = viridis(share);
        double light = 0;
        const double weights[] = {0.2126, 0.7152, 0.0722};
        for (int i = 0; i < 3; ++i) light += weights[i] * std::pow(c[i] / 255.0, 2.2);
        return light;
    };
    for (int i = 0; i < 50; ++i) CHECK(lightness(i / 50.0) < lightness((i + 1) / 50.0));
    CHECK(viridis(0) == std::array<std::uint8_t, 3>{68, 1, 84});
    CHECK(viridis(0.5) == std::array<std::uint8_t, 3>{33, 145, 140});
    CHECK(viridis(1) == std::array<std::uint8_t, 3>{253, 231, 37});
    CHECK(viridis(-3) == viridis(0));
    CHECK(viridis(7) == viridis(1));
    CHECK(viridis(NAN) == std::array<std::uint8_t, 3>{128, 128, 128});
}
