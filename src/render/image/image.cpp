#include "render/image/image.h"

#include <fcntl.h>
#include <libdeflate.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <system_error>

#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_NO_STDIO
#include <stb_image.h>

namespace cloth::render {
namespace {

void append_big_endian(std::vector<std::uint8_t>& bytes, std::uint32_t value) {
    for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(value >> shift));
}

/// Fills in length and checksum of the chunk that ends here and whose length field is at `start`.
void finish_chunk(std::vector<std::uint8_t>& png, std::size_t start) {
    const auto length = static_cast<std::uint32_t>(png.size() - start - 8);
    for (int i = 0; i < 4; ++i) png[start + i] = static_cast<std::uint8_t>(length >> (24 - 8 * i));
    append_big_endian(png, libdeflate_crc32(0, png.data() + start + 4, png.size() - start - 4));
}

std::size_t start_chunk(std::vector<std::uint8_t>& png, const char* kind) {
    const std::size_t start = png.size();
    append_big_endian(png, 0);
    png.insert(png.end(), kind, kind + 4);
    return start;
}

void require_pixels(const Image& image, const char* what) {
    if (image.width <= 0 || image.height <= 0 ||
        image.rgba.size() != std::size_t{4} * image.width * image.height)
        throw std::invalid_argument(std::string(what) + ": an image of " + std::to_string(image.width) +
                                    " x " + std::to_string(image.height) + " with " +
                                    std::to_string(image.rgba.size()) +
                                    " bytes; 4 bytes per pixel and at least one pixel are needed");
}

/// A file under a temporary name; removed unless renamed.
class TemporaryFile {
  public:
    explicit TemporaryFile(const std::filesystem::path& path) : path_(path) {
        static std::atomic<unsigned> counter = 0;
        temporary_ = path;
        temporary_ += '.';
        temporary_ += std::to_string(getpid());
        temporary_ += '.';
        temporary_ += std::to_string(counter++);
        temporary_ += ".tmp";
        descriptor_ = open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
        if (descriptor_ < 0) fail();
    }
    ~TemporaryFile() {
        if (descriptor_ >= 0) close(descriptor_);
        if (!renamed_) unlink(temporary_.c_str());
    }
    TemporaryFile(const TemporaryFile&) = delete;
    TemporaryFile& operator=(const TemporaryFile&) = delete;

    void write_all(const std::vector<std::uint8_t>& bytes) {
        for (std::size_t done = 0; done < bytes.size();) {
            const ssize_t written = ::write(descriptor_, bytes.data() + done, bytes.size() - done);
            if (written < 0 && errno == EINTR) continue;
            if (written <= 0) fail();
            done += static_cast<std::size_t>(written);
        }
    }
    void rename() {
        // Some file systems report a full disk or quota only here.
        const int closed = close(descriptor_);
        descriptor_ = -1;
        if (closed != 0 || ::rename(temporary_.c_str(), path_.c_str()) != 0) fail();
        renamed_ = true;
    }

  private:
    [[noreturn]] void fail() const {
        throw std::runtime_error("cannot write " + path_.string() + ": " +
                                 std::generic_category().message(errno));
    }

    std::filesystem::path path_, temporary_;
    int descriptor_ = -1;
    bool renamed_ = false;
};

}  // namespace

std::vector<std::uint8_t> encode_png(const Image& image) {
    require_pixels(image, "encode_png");
    // Each row behind its filter's number: none. Trying all five filters costs far more than it saves on
    // smooth pictures.
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    std::vector<std::uint8_t> rows((1 + 3 * width) * height);
    const std::uint8_t* from = image.rgba.data();
    std::uint8_t* to = rows.data();
    for (std::size_t y = 0; y < height; ++y) {
        *to++ = 0;
        for (std::size_t x = 0; x < width; ++x, from += 4, to += 3) {
            to[0] = from[0];
            to[1] = from[1];
            to[2] = from[2];
        }
    }
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(1), &libdeflate_free_compressor);
    if (!compressor) throw std::bad_alloc();
    std::vector<std::uint8_t> png{0x89, 'P', 'N', 'G', '\r', '\n', 0x1a, '\n'};
    std::size_t chunk = start_chunk(png, "IHDR");
    append_big_endian(png, static_cast<std::uint32_t>(width));
    append_big_endian(png, static_cast<std::uint32_t>(height));
    png.insert(png.end(), {8, 2, 0, 0, 0});  // bits a channel, RGB, and the only methods there are
    finish_chunk(png, chunk);
    chunk = start_chunk(png, "IDAT");
    const std::size_t start = png.size();
    png.resize(start + libdeflate_zlib_compress_bound(compressor.get(), rows.size()));
    png.resize(start + libdeflate_zlib_compress(compressor.get(), rows.data(), rows.size(),
                                                png.data() + start, png.size() - start));
    finish_chunk(png, chunk);
    finish_chunk(png, start_chunk(png, "IEND"));
    return png;
}

void write_png(const Image& image, const std::filesystem::path& path) {
    const std::vector<std::uint8_t> png = encode_png(image);
    TemporaryFile file(path);
    file.write_all(png);
    file.rename();
}

Image read_png(const std::filesystem::path& path) {
    const auto fail = [&path](const std::string& cause) {
        throw std::runtime_error("cannot read " + path.string() + ": " + cause);
    };
    std::error_code error;
    if (std::filesystem::is_directory(path, error)) fail("Is a directory");
    std::ifstream stream(path, std::ios::binary);
    if (!stream) fail(std::generic_category().message(errno));
    const std::vector<char> bytes{std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
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
