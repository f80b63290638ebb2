#include "render/overlay/overlay.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "render/overlay/font.h"

#define STBTT_STATIC
#define STB_TRUETYPE_IMPLEMENTATION
#if defined(__GNUC__)
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#endif
#include <stb_truetype.h>
#if defined(__GNUC__)
#pragma GCC diagnostic pop
#endif

namespace cloth::render {
namespace {

const stbtt_fontinfo& font() {
    static const stbtt_fontinfo info = [] {
        stbtt_fontinfo made;
        if (!stbtt_InitFont(&made, font_bytes().data(), 0))
            throw std::runtime_error("the font that the program was built with cannot be read");
        return made;
    }();
    return info;
}

/// The first code point of `text`, which loses it. What is no UTF-8 counts as the replacement character.
int next_code_point(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    const std::size_t length = first < 0x80 ? 1 : first >> 5 == 6 ? 2 : first >> 4 == 14 ? 3 : 4;
    int code = length == 1 ? first : first & (0x7f >> length);
    std::size_t taken = 1;
    while (taken < length && taken < text.size() && byte(taken) >> 6 == 2)
        code = code << 6 | (byte(taken++) & 0x3f);
    const bool whole = taken == length && first >> 6 != 2 && first < 0xf8;
    text.remove_prefix(taken);
    return whole ? code : 0xfffd;
}

/// Calls place(glyph, x) for each glyph of a line that begins at x = 0, and returns the line's width.
template <class Place>
float set_line(std::string_view text, float size, const Place& place) {
    const float scale = stbtt_ScaleForMappingEmToPixels(&font(), size);
    float x = 0;
    int before = -1;
    while (!text.empty()) {
        const int glyph = stbtt_FindGlyphIndex(&font(), next_code_point(text));
        if (before >= 0) x += scale * static_cast<float>(stbtt_GetGlyphKernAdvance(&font(), before, glyph));
        place(glyph, x);
        int advance = 0, bearing = 0;
        stbtt_GetGlyphHMetrics(&font(), glyph, &advance, &bearing);
        x += scale * static_cast<float>(advance);
        before = glyph;
    }
    return x;
}

void mix(Image& image, int x, int y, float share, const Ink& ink) {
    std::uint8_t* p = image.pixel(x, y);
    const float alpha = std::clamp(share * ink.opacity, 0.0f, 1.0f);
    for (int i = 0; i < 3; ++i) {
        const auto old = static_cast<float>(p[i]), wanted = static_cast<float>(ink.rgb[i]);
        p[i] = static_cast<std::uint8_t>(std::lround(old + (wanted - old) * alpha));
    }
}

/// Pixels first … last - 1 that [low, high] touches, within 0 … size.
struct Run {
    int first, last;
};
Run pixels(float low, float high, int size) {
    const auto limit = static_cast<float>(size);
    return {static_cast<int>(std::floor(std::clamp(low, 0.0f, limit))),
            static_cast<int>(std::ceil(std::clamp(high, 0.0f, limit)))};
}

float distance_to_segment(const Float2& p, const Float2& a, const Float2& b) {
    const Float2 ab{b[0] - a[0], b[1] - a[1]}, ap{p[0] - a[0], p[1] - a[1]};
    const float length2 = ab[0] * ab[0] + ab[1] * ab[1];
    const float s = length2 > 0 ? std::clamp((ap[0] * ab[0] + ap[1] * ab[1]) / length2, 0.0f, 1.0f) : 0.0f;
    const float x = ap[0] - s * ab[0], y = ap[1] - s * ab[1];
    return std::sqrt(x * x + y * y);
}

}  // namespace

float text_width(std::string_view text, float size) {
    return set_line(text, size, [](int, float) {});
}

float capital_height(float size) {
    return 0.729f * size;  // of DejaVu Sans
}

void draw_text(Image& image, const Float2& place, std::string_view text, float size, const Ink& ink) {
    const float scale = stbtt_ScaleForMappingEmToPixels(&font(), size);
    std::vector<unsigned char> cover;
    set_line(text, size, [&](int glyph, float offset) {
        const float x = std::floor(place[0] + offset), y = std::floor(place[1]);
        const float shift_x = place[0] + offset - x, shift_y = place[1] - y;
        int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
        stbtt_GetGlyphBitmapBoxSubpixel(&font(), glyph, scale, scale, shift_x, shift_y, &x0, &y0, &x1, &y1);
        const int width = x1 - x0, height = y1 - y0;
        if (width <= 0 || height <= 0) return;
        cover.assign(static_cast<std::size_t>(width) * static_cast<std::size_t>(height), 0);
        stbtt_MakeGlyphBitmapSubpixel(&font(), cover.data(), width, height, width, scale, scale, shift_x,
                                      shift_y, glyph);
        for (int j = 0; j < height; ++j)
            for (int i = 0; i < width; ++i) {
                const int px = static_cast<int>(x) + x0 + i, py = static_cast<int>(y) + y0 + j;
                if (px < 0 || py < 0 || px >= image.width || py >= image.height) continue;
                const unsigned char share = cover[static_cast<std::size_t>(j * width + i)];
                if (share != 0) mix(image, px, py, static_cast<float>(share) / 255.0f, ink);
            }
    });
}

void fill_rectangle(Image& image, const Float2& low, const Float2& high, const Ink& ink) {
    const Run columns = pixels(low[0], high[0], image.width), rows = pixels(low[1], high[1], image.height);
    const auto share = [](float from, float to, int pixel) {
        return std::min(to, static_cast<float>(pixel + 1)) - std::max(from, static_cast<float>(pixel));
    };
    for (int y = rows.first; y < rows.last; ++y)
        for (int x = columns.first; x < columns.last; ++x)
            mix(image, x, y, share(low[0], high[0], x) * share(low[1], high[1], y), ink);
}

void draw_polyline(Image& image, std::span<const Float2> points, float width, const Ink& ink) {
    if (points.empty()) return;
    const float reach = 0.5f * width + 0.5f;
    constexpr float infinity = std::numeric_limits<float>::infinity();
    Float2 low{infinity, infinity}, high{-infinity, -infinity};
    for (const Float2& p : points)
        for (int i = 0; i < 2; ++i) {
            if (!std::isfinite(p[i])) return;
            low[i] = std::min(low[i], p[i] - reach);
            high[i] = std::max(high[i], p[i] + reach);
        }
    const Run columns = pixels(low[0], high[0], image.width), rows = pixels(low[1], high[1], image.height);
    if (columns.first >= columns.last || rows.first >= rows.last) return;
    const int across = columns.last - columns.first;
    std::vector<float> cover(static_cast<std::size_t>(across) *
                             static_cast<std::size_t>(rows.last - rows.first));
    for (std::size_t k = 0; k < std::max<std::size_t>(1, points.size() - 1); ++k) {
        const Float2 &a = points[k], &b = points[std::min(k + 1, points.size() - 1)];
        const Run xs = pixels(std::min(a[0], b[0]) - reach, std::max(a[0], b[0]) + reach, image.width);
        const Run ys = pixels(std::min(a[1], b[1]) - reach, std::max(a[1], b[1]) + reach, image.height);
        for (int y = ys.first; y < ys.last; ++y)
            for (int x = xs.first; x < xs.last; ++x) {
                const Float2 center{static_cast<float>(x) + 0.5f, static_cast<float>(y) + 0.5f};
                float& c = cover[static_cast<std::size_t>((y - rows.first) * across + x - columns.first)];
                c = std::max(c, std::clamp(reach - distance_to_segment(center, a, b), 0.0f, 1.0f));
            }
    }
    const float thin = std::min(width, 1.0f);  // a hair covers a part of each pixel that it crosses
    for (int y = rows.first; y < rows.last; ++y)
        for (int x = columns.first; x < columns.last; ++x) {
            const float c = cover[static_cast<std::size_t>((y - rows.first) * across + x - columns.first)];
            if (c > 0) mix(image, x, y, thin * c, ink);
        }
}

Image plain_image(int width, int height, const Ink& ink) {
    Image image{width, height, {}};
    image.rgba.reserve(std::size_t{4} * static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
    for (int i = 0; i < width * height; ++i)
        image.rgba.insert(image.rgba.end(), {ink.rgb[0], ink.rgb[1], ink.rgb[2], 255});
    return image;
}

void paste(Image& image, const Image& part, int x, int y) {
    const int first = std::max(0, -x), last = std::min(part.width, image.width - x);
    if (first >= last) return;
    for (int row = std::max(0, -y); row < std::min(part.height, image.height - y); ++row)
        std::copy_n(part.pixel(first, row), 4 * static_cast<std::size_t>(last - first),
                    image.pixel(x + first, y + row));
}

Image mean_image(std::span<const Image> images) {
    if (images.empty()) throw std::invalid_argument("mean_image: no images");
    static const std::array<float, 256> linear = [] {
        std::array<float, 256> table{};
        for (int i = 0; i < 256; ++i) {
            const double c = i / 255.0;
            table[static_cast<std::size_t>(i)] =
                static_cast<float>(c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4));
        }
        return table;
    }();
    // Between two neighbouring values lies the border of linear light at which rounding changes.
    static const std::vector<std::uint8_t> encoded = [] {
        std::vector<std::uint8_t> table(1 << 14);
        for (std::size_t i = 0; i < table.size(); ++i) {
            const double c = (static_cast<double>(i) + 0.5) / static_cast<double>(table.size());
            const double s = c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055;
            table[i] = static_cast<std::uint8_t>(std::lround(255 * s));
        }
        return table;
    }();
    Image mean = images.front();
    std::vector<float> sum(mean.rgba.size());
    for (const Image& image : images) {
        if (image.width != mean.width || image.height != mean.height)
            throw std::invalid_argument("mean_image: " + std::to_string(image.width) + " x " +
                                        std::to_string(image.height) + " after " +
                                        std::to_string(mean.width) + " x " + std::to_string(mean.height));
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += linear[image.rgba[i]];
    }
    const float scale = static_cast<float>(encoded.size()) / static_cast<float>(images.size());
    for (std::size_t i = 0; i < sum.size(); ++i) {
        if (i % 4 == 3) continue;
        const auto place = static_cast<std::size_t>(sum[i] * scale);
        mean.rgba[i] = encoded[std::min(place, encoded.size() - 1)];
    }
    return mean;
}

}  // namespace cloth::render
