#include "render/image/image.h"

#include <libdeflate.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>

#include "base/whole_file.h"

namespace {

/// What stb_image_write compresses with: its own needs ten times as long. Gives memory of malloc().
unsigned char* compressed(unsigned char* data, int size, int* compressed_size, int) {
    constexpr int level = 1;
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(level), &libdeflate_free_compressor);
    if (!compressor) return nullptr;
    const auto from = static_cast<std::size_t>(size);
    const std::size_t bound = libdeflate_zlib_compress_bound(compressor.get(), from);
    auto* bytes = static_cast<unsigned char*>(std::malloc(bound));
    if (bytes != nullptr)
        *compressed_size =
            static_cast<int>(libdeflate_zlib_compress(compressor.get(), data, from, bytes, bound));
    return bytes;
}

}  // namespace

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb_image.h>

#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#define STBI_WRITE_NO_STDIO
#define STBIW_ZLIB_COMPRESS compressed
#define STBIW_CRC32(data, size) libdeflate_crc32(0, data, static_cast<std::size_t>(size))
#include <stb_image_write.h>

namespace cloth::render {
namespace {

/// Rows as they are. Trying all of PNG's filters costs far more than it saves on smooth pictures.
[[maybe_unused]] const int no_filter = stbi_write_force_png_filter = 0;

void require_pixels(const Image& image, const char* what) {
    if (image.width <= 0 || image.height <= 0 ||
        image.rgba.size() != std::size_t{4} * image.width * image.height)
        throw std::invalid_argument(std::string(what) + ": an image of " + std::to_string(image.width) +
                                    " x " + std::to_string(image.height) + " with " +
                                    std::to_string(image.rgba.size()) +
                                    " bytes; 4 bytes per pixel and at least one pixel are needed");
}

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
    const std::size_t row = std::size_t{3} * std::max(image.width, 0);
    if ((row + 1) * std::max(image.height, 0) > std::size_t{1} << 30)
        throw std::invalid_argument("encode_png: an image of " + std::to_string(image.width) + " x " +
                                    std::to_string(image.height) + "; at most 1 GiB can be written");
    require_pixels(image, "encode_png");
    std::vector<std::uint8_t> rgb(row * image.height);
    for (std::size_t from = 0, to = 0; to < rgb.size(); from += 4, to += 3)
        std::copy_n(image.rgba.begin() + static_cast<std::ptrdiff_t>(from), 3,
                    rgb.begin() + static_cast<std::ptrdiff_t>(to));
    int size = 0;
    const std::unique_ptr<unsigned char, decltype(&std::free)> png(
        stbi_write_png_to_mem(rgb.data(), static_cast<int>(row), image.width, image.height, 3, &size),
        &std::free);
    if (!png) throw std::bad_alloc();
    return {png.get(), png.get() + size};
}

void write_png(const Image& image, const std::filesystem::path& path) {
    const std::vector<std::uint8_t> png = encode_png(image);
    write_whole_file(path, {reinterpret_cast<const char*>(png.data()), png.size()});
}

Image read_png(const std::filesystem::path& path) {
    const std::string bytes = read_whole_file(path);
    const auto fail = [&path](const std::string& cause) {
        throw std::runtime_error("cannot read " + path.string() + ": " + cause);
    };
    if (bytes.size() > static_cast<std::size_t>(std::numeric_limits<int>::max())) fail("larger than 2 GiB");
    Image image;
    int channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&std::free)> rgb(
        stbi_load_from_memory(reinterpret_cast<const stbi_uc*>(bytes.data()), static_cast<int>(bytes.size()),
                              &image.width, &image.height, &channels, 3),
        &std::free);
    if (!rgb) fail(std::string("not a whole PNG (") + stbi_failure_reason() + ")");
    const std::size_t pixels = static_cast<std::size_t>(image.width) * image.height;
    image.rgba.resize(4 * pixels);
    for (std::size_t i = 0; i < pixels; ++i) {
        for (std::size_t channel = 0; channel < 3; ++channel)
            image.rgba[4 * i + channel] = rgb.get()[3 * i + channel];
        image.rgba[4 * i + 3] = 255;
    }
    return image;
}

ImageDifference compare(const Image& a, const Image& b) {
    require_pixels(a, "compare");
    require_pixels(b, "compare");
    ImageDifference difference;
    difference.same_size = a.width == b.width && a.height == b.height;
    if (!difference.same_size) return difference;
    std::uint64_t over_2 = 0, over_32 = 0, squares = 0;
    for (int y = 0; y < a.height; ++y) {
        for (int x = 0; x < a.width; ++x) {
            const std::uint8_t* p = a.pixel(x, y);
            const std::uint8_t* q = b.pixel(x, y);
            int largest = 0;
            for (int channel = 0; channel < 3; ++channel) {
                const int distance = std::abs(p[channel] - q[channel]);
                largest = std::max(largest, distance);
                squares += static_cast<std::uint64_t>(distance * distance);
            }
            over_2 += largest > 2;
            over_32 += largest > 32;
            if (largest > difference.largest) {
                difference.largest = largest;
                difference.worst_x = x;
                difference.worst_y = y;
            }
        }
    }
    const double pixels = static_cast<double>(a.width) * a.height;
    difference.fraction_over_2 = static_cast<double>(over_2) / pixels;
    difference.fraction_over_32 = static_cast<double>(over_32) / pixels;
    const double mean_square = static_cast<double>(squares) / (3 * pixels);
    difference.psnr =
        squares == 0 ? std::numeric_limits<double>::infinity() : 10 * std::log10(255.0 * 255.0 / mean_square);
    return difference;
}

Image magnified_difference(const Image& a, const Image& b, int gain) {
    require_pixels(a, "magnified_difference");
    require_pixels(b, "magnified_difference");
    if (a.width != b.width || a.height != b.height)
        throw std::invalid_argument("magnified_difference: " + std::to_string(a.width) + " x " +
                                    std::to_string(a.height) + " against " + std::to_string(b.width) + " x " +
                                    std::to_string(b.height) + "; equal sizes are needed");
    Image difference{a.width, a.height, std::vector<std::uint8_t>(a.rgba.size(), 255)};
    for (std::size_t i = 0; i < a.rgba.size(); ++i)
        if (i % 4 != 3)
            difference.rgba[i] =
                static_cast<std::uint8_t>(std::clamp(std::abs(a.rgba[i] - b.rgba[i]) * gain, 0, 255));
    return difference;
}

}  // namespace cloth::render
