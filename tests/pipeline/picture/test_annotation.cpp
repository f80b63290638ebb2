// Captions, legends, curves and contact sheets: where they stand and what they say.

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include "pipeline/picture/annotation.h"
#include "pipeline/picture/survey.h"
#include "pipeline/run/sheet.h"
#include "render/image/colormap.h"
#include "render/overlay/overlay.h"

using namespace cloth;
using namespace cloth::pipeline;
using render::Image;

namespace {

Image blue(int width, int height) {
    return render::plain_image(width, height, {{40, 60, 200}});
}

struct Region {
    int x0, y0, x1, y1;
    bool empty() const { return x1 < x0; }
};

/// The smallest rectangle that holds all pixels that are not blue(), within columns a … b - 1.
Region changed(const Image& image, int a, int b) {
    Region r{image.width, image.height, -1, -1};
    for (int y = 0; y < image.height; ++y)
        for (int x = a; x < b; ++x) {
            const auto* p = image.pixel(x, y);
            if (p[0] == 40 && p[1] == 60 && p[2] == 200) continue;
            r = {std::min(r.x0, x), std::min(r.y0, y), std::max(r.x1, x), std::max(r.y1, y)};
        }
    return r;
}
Region changed(const Image& image) {
    return changed(image, 0, image.width);
}

bool holds(const Image& image, const std::array<std::uint8_t, 3>& color) {
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        if (image.rgba[i] == color[0] && image.rgba[i + 1] == color[1] && image.rgba[i + 2] == color[2])
            return true;
    return false;
}

}  // namespace

TEST_CASE("a caption's places are filled in", "[annotation]") {
    CHECK(fill_caption("{scene}: {time} s, {frame}; {description}", "twist", "A {frame}", 1.25, 75) ==
          "twist: 1.250 s, 75; A {frame}");
    CHECK(fill_caption("{other} {", "s", "d", 0, 0) == "{other} {");
}

TEST_CASE("ticks stand at round numbers inside the range", "[annotation]") {
    CHECK(ticks(0, 1, 6) == std::vector<double>{0, 0.2, 0.4, 0.6000000000000001, 0.8, 1});
    CHECK(tick_labels(ticks(0, 1, 6)) == std::vector<std::string>{"0.0", "0.2", "0.4", "0.6", "0.8", "1.0"});
    CHECK(tick_labels(ticks(0.983, 1.042, 4)) == std::vector<std::string>{"1.00", "1.02", "1.04"});
    CHECK(tick_labels(ticks(-120, 480, 4)) == std::vector<std::string>{"0", "200", "400"});
    CHECK(tick_labels(ticks(0, 2.5e-6, 3)) == std::vector<std::string>{"0", "1e-06", "2e-06"});
    CHECK(tick_labels({0.0, 0.5, 1.25}) == std::vector<std::string>{"0.00", "0.50", "1.25"});
    CHECK(tick_labels({0.0, 2e5, 2.5e5}) == std::vector<std::string>{"0", "2.0e+05", "2.5e+05"});
    CHECK(tick_labels({1.0}) == std::vector<std::string>{"1"});
    CHECK(ticks(1, 1, 5).empty());
    CHECK(ticks(0, INFINITY, 5).empty());
    for (const double high : {0.3, 1.0, 7.7, 1234.0, 2e-5})
        for (const int most : {1, 2, 3, 5, 8}) {
            const auto places = ticks(0.1 * high, high, most);
            INFO(high << " " << most);
            CHECK(static_cast<int>(places.size()) <= most);
            for (const double p : places) {
                CHECK(p >= 0.1 * high * (1 - 1e-6));
                CHECK(p <= high * (1 + 1e-6));
            }
        }
}

TEST_CASE("caption, legend, curves and label do not overlap, at every size", "[annotation]") {
    const std::vector<double> times{0, 0.5, 1, 1.5};
    const std::vector<CurveLine> lines{{"energy [J]", {1, 2, 3, 2}},
                                       {"greatest stretch", {NAN, 1.01, 1.02, 1.01}},
                                       {"smallest gap [mm]", {4, 4, 4, 4}}};
    for (const auto& [width, height] : {std::pair{1280, 720},
                                        {1920, 1080},
                                        {640, 360},
                                        {480, 270},
                                        {320, 180},
                                        {64, 48},
                                        {16, 16},
                                        {17, 400}}) {
        INFO(width << " x " << height);
        Image caption = blue(width, height), legend = caption, curves = caption, label = caption;
        draw_caption(caption, "drape_sphere   t = 1.500 s   frame 90");
        draw_legend(legend, {"kinetic energy [J/m²]", 0, 1.2, false, true});
        draw_curves(curves, times, lines, 1.0);
        draw_label(label, "before");
        const Region a = changed(caption), b = changed(legend), c = changed(curves);
        const auto apart = [](const Region& p, const Region& q) {
            return p.empty() || q.empty() || p.x1 < q.x0 || q.x1 < p.x0 || p.y1 < q.y0 || q.y1 < p.y0;
        };
        CHECK(apart(a, b));
        CHECK(apart(a, c));
        CHECK(apart(b, c));
        if (width >= 320) {
            CHECK_FALSE(a.empty());
            CHECK_FALSE(b.empty());
            CHECK_FALSE(c.empty());
            CHECK_FALSE(changed(label).empty());
            CHECK(a.x0 > 0);
            CHECK(a.y1 < height - 1);
            CHECK(b.x1 < width - 1);
        }
    }
}

TEST_CASE("the legend's bar has the colours from its top to its bottom", "[annotation]") {
    Image image = blue(640, 360);
    draw_legend(image, {"stretch", 0.95, 1.05, true, false});
    for (const double share : {0.05, 0.5, 0.95}) {
        // The nearest row's share differs by at most one row of the bar.
        bool found = false;
        for (double s = share - 0.01; s <= share + 0.01; s += 0.0005)
            found = found || holds(image, render::viridis(s));
        CHECK(found);
    }
}

TEST_CASE("a long caption is cut to the picture", "[annotation]") {
    Image image = blue(200, 100);
    draw_caption(image, "a very long caption that has no room in a picture of this size, é ² µ");
    const Region r = changed(image);
    CHECK(r.x0 > 0);
    CHECK(r.x1 < 199);
}

TEST_CASE("curves go as far as now", "[annotation]") {
    const std::vector<double> times{0, 1, 2, 3};
    const std::vector<CurveLine> line{{"x", {0, 1, 0, 1}}};
    const auto accent_right_of = [&](double now) {
        Image image = blue(640, 360);
        draw_curves(image, times, line, now);
        // The dot is the only accent below the numbers.
        int right = -1;
        for (int y = 24; y < 200; ++y)
            for (int x = 0; x < 640; ++x)
                if (const auto* p = image.pixel(x, y); p[0] == 196 && p[1] == 50 && p[2] == 30)
                    right = std::max(right, x);
        return right;
    };
    const int a = accent_right_of(1), b = accent_right_of(2), c = accent_right_of(3);
    CHECK(a > 0);
    CHECK(b - a == Approx(c - b).margin(1));
}

TEST_CASE("a range of colours leaves out half a percent at each end and is rounded outwards",
          "[annotation]") {
    std::vector<double> values;
    for (int i = 0; i <= 10000; ++i) values.push_back(0.97 + 0.08 * i / 10000.0);
    values.push_back(7.0);
    values.push_back(NAN);
    const ShadeRange stretch = shade_range(VertexField::stretch, values, 1);
    CHECK(stretch.low == Approx(0.96));
    CHECK(stretch.high == Approx(1.06));
    CHECK_FALSE(stretch.below);
    CHECK(stretch.above);
    const ShadeRange energy = shade_range(VertexField::kinetic, values, 1);
    CHECK(energy.low == 0);
    CHECK(energy.high == Approx(1.2));
    std::vector<double> gaps;
    for (int i = 0; i <= 1000; ++i) gaps.push_back(i / 1000.0);
    CHECK(shade_range(VertexField::gap, gaps, 2).high <= 0.13);
    CHECK(shade_range(VertexField::gap, gaps, 2).above);
    CHECK(shade_range(VertexField::gap, {NAN, NAN}, 1).high == 1);
    const ShadeRange constant = shade_range(VertexField::stretch, std::vector<double>(100, 1.0), 1);
    CHECK(constant.high > constant.low);
}

TEST_CASE("frames of a sheet are spread evenly from the first to the last", "[sheet]") {
    std::vector<std::int64_t> frames;
    for (int i = 10; i < 111; ++i) frames.push_back(i);
    CHECK(spread(frames, 5) == std::vector<std::int64_t>{10, 35, 60, 85, 110});
    CHECK(spread(frames, 2) == std::vector<std::int64_t>{10, 110});
    CHECK(spread(frames, 1) == std::vector<std::int64_t>{110});
    CHECK(spread(frames, 500) == frames);
    CHECK(spread({7}, 12) == std::vector<std::int64_t>{7});
}

TEST_CASE("a contact sheet places pictures row by row with their texts between", "[sheet]") {
    std::vector<Image> pictures;
    std::vector<std::string> texts;
    for (int i = 0; i < 5; ++i) {
        pictures.push_back(render::plain_image(100, 60, {{static_cast<std::uint8_t>(40 * i), 10, 20}}));
        texts.push_back("frame " + std::to_string(i));
    }
    const Image sheet = contact_sheet(pictures, texts, 3);
    const int gap = (sheet.width - 300) / 4, strip = (sheet.height - gap - 120) / 2;
    CHECK(sheet.width == 300 + 4 * gap);
    CHECK(strip > 0);
    for (int i = 0; i < 5; ++i) {
        const int x = gap + i % 3 * (100 + gap), y = gap + i / 3 * (60 + strip - 0);
        CHECK(sheet.pixel(x, y)[0] == 40 * i);
        CHECK(sheet.pixel(x + 99, y + 59)[0] == 40 * i);
        int dark = 0;
        for (int row = y + 60; row < std::min(y + 60 + strip, sheet.height); ++row)
            for (int column = x; column < x + 100; ++column) dark += sheet.pixel(column, row)[0] < 128;
        CHECK(dark > 20);
    }
    CHECK(contact_sheet({pictures[0]}, {"a"}, 7).width < 130);
    CHECK_THROWS_WITH(contact_sheet(pictures, {"one"}, 3), Catch::Contains("1 texts for 5 pictures"));
    pictures[2] = blue(10, 10);
    CHECK_THROWS_WITH(contact_sheet(pictures, texts, 3), Catch::Contains("a picture of 10x10"));
    CHECK_THROWS_AS(contact_sheet({}, {}, 3), std::invalid_argument);
}
