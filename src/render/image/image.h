#pragma once
// 8-bit sRGB pictures: PNG in and out, and a comparison.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace cloth::render {

/// Rows from the top, four bytes (red, green, blue, alpha) a pixel, sRGB-encoded, opaque.
struct Image {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgba;

    std::uint8_t* pixel(int x, int y) { return rgba.data() + 4 * (static_cast<std::size_t>(y) * width + x); }
    const std::uint8_t* pixel(int x, int y) const {
        return rgba.data() + 4 * (static_cast<std::size_t>(y) * width + x);
    }
};

/// An RGB PNG in memory, by stb_image_write. Throws std::invalid_argument for no pixels, or more than 1 GiB
/// of them.
std::vector<std::uint8_t> encode_png(const Image& image);
/// Writes to a temporary name beside `path`, then renames; throws std::runtime_error naming path and cause.
void write_png(const Image& image, const std::filesystem::path& path);
/// Throws std::runtime_error naming path and cause.
Image read_png(const std::filesystem::path& path);

/// How far two pictures of the same size are apart, over red, green and blue.
struct ImageDifference {
    bool same_size = true;
    int largest = 0;               ///< greatest difference of any channel, 0 … 255
    double fraction_over_2 = 0;    ///< pixels with a channel off by more than 2
    double fraction_over_32 = 0;   ///< pixels with a channel off by more than 32
    double psnr = 0;               ///< [dB]; infinite where equal
    int worst_x = 0, worst_y = 0;  ///< place of `largest`
};
ImageDifference compare(const Image& a, const Image& b);

/// |a - b| times `gain`, clamped. Requires equal sizes.
Image magnified_difference(const Image& a, const Image& b, int gain);

}  // namespace cloth::render
