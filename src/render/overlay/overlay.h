#pragma once
// Text, lines and areas drawn on a finished picture, and pictures set beside each other. All on the CPU and
// in float arithmetic alone: the same input gives the same pixels.
//
// Places are in pixels from the picture's top left corner, x to the right, y down; the pixel (i, j) covers
// [i, i + 1) x [j, j + 1). Each pixel is mixed with the ink by the share of it that the shape covers. What
// lies outside the picture is left out.

#include <array>
#include <cstdint>
#include <span>
#include <string_view>

#include "render/image/image.h"

namespace cloth::render {

using Float2 = std::array<float, 2>;

/// sRGB, as in pictures.
struct Ink {
    std::array<std::uint8_t, 3> rgb{0, 0, 0};
    float opacity = 1.0f;  ///< 0 … 1
};

/// UTF-8 in one line of DejaVu Sans, whose digits are of one width; `size` is the height of an em [pixel].
float text_width(std::string_view text, float size);
/// From `place`, left end of the line on which the letters stand.
void draw_text(Image& image, const Float2& place, std::string_view text, float size, const Ink& ink);
/// Height of a capital letter over that line [pixel].
float capital_height(float size);

void fill_rectangle(Image& image, const Float2& low, const Float2& high, const Ink& ink);
/// Lines from point to point with round ends and joints; one point alone is a disc. Overlaps are not mixed
/// twice.
void draw_polyline(Image& image, std::span<const Float2> points, float width, const Ink& ink);

Image plain_image(int width, int height, const Ink& ink);
/// Copies `part` so that its top left pixel comes to (x, y).
void paste(Image& image, const Image& part, int x, int y);
/// The mean in linear light, as of exposures one after another. Throws std::invalid_argument for none, or for
/// unequal sizes.
Image mean_image(std::span<const Image> images);

}  // namespace cloth::render
