#include <sys/resource.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth::render;
using Catch::Matchers::Contains;
using Catch::Matchers::Equals;
namespace fs = std::filesystem;

namespace {

std::size_t entries(const TemporaryFolder& folder) {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder.path()), {}));
}

/// Opaque; every channel takes every value where the picture is large enough.
Image pattern(int width, int height) {
    Image image{width, height, {}};
    unsigned seed = 1;
    for (int i = 0; i < width * height; ++i) {
        for (int channel = 0; channel < 3; ++channel) {
            seed = seed * 1664525u + 1013904223u;
            image.rgba.push_back(static_cast<std::uint8_t>(seed >> 24));
        }
        image.rgba.push_back(255);
    }
    return image;
}

Image grey(int width, int height, std::uint8_t value) {
    Image image{width, height, std::vector<std::uint8_t>(std::size_t{4} * width * height, value)};
    for (std::size_t i = 3; i < image.rgba.size(); i += 4) image.rgba[i] = 255;
    return image;
}

}  // namespace

TEST_CASE("a PNG holds exactly the picture written, of any size", "[image]") {
    const TemporaryFolder folder;
    const fs::path path = folder / "picture.png";
    for (const auto& [width, height] :
         {std::pair{1, 1}, {1, 7}, {7, 1}, {3, 5}, {17, 31}, {255, 3}, {640, 360}, {641, 359}}) {
        CAPTURE(width, height);
        const Image image = pattern(width, height);
        write_png(image, path);
        const Image read = read_png(path);
        CHECK(read.width == width);
        CHECK(read.height == height);
        CHECK(read.rgba == image.rgba);
    }
    CHECK(entries(folder) == 1);  // no temporary file stays behind
}

TEST_CASE("the same picture gives the same PNG", "[image]") {
    CHECK(encode_png(pattern(64, 48)) == encode_png(pattern(64, 48)));
}

TEST_CASE("a PNG drops alpha", "[image]") {
    Image image = grey(4, 4, 90);
    image.pixel(2, 2)[3] = 0;
    CHECK(encode_png(image) == encode_png(grey(4, 4, 90)));
}

TEST_CASE("a PNG that cannot be written names its path and the cause", "[image]") {
    const TemporaryFolder folder;
    const fs::path missing = folder / "nowhere" / "a.png";
    CHECK_THROWS_WITH(write_png(grey(4, 4, 0), missing),
                      Equals("cannot write " + missing.string() + ": No such file or directory"));
    const fs::path occupied = folder / "folder.png";
    fs::create_directory(occupied);
    CHECK_THROWS_WITH(write_png(grey(4, 4, 0), occupied),
                      Equals("cannot write " + occupied.string() + ": Is a directory"));
    CHECK(entries(folder) == 1);
}

TEST_CASE("a write cut short keeps the old picture and leaves nothing else", "[image]") {
    const TemporaryFolder folder;
    const fs::path path = folder / "a.png";
    write_png(grey(8, 8, 10), path);
    // A limit on file sizes stands in for a full disk: the write stops midway in the same manner.
    rlimit old{};
    REQUIRE(getrlimit(RLIMIT_FSIZE, &old) == 0);
    const auto old_handler = std::signal(SIGXFSZ, SIG_IGN);
    rlimit small = old;
    small.rlim_cur = 4096;
    REQUIRE(setrlimit(RLIMIT_FSIZE, &small) == 0);
    std::string message;
    try {
        write_png(pattern(200, 200), path);
    } catch (const std::runtime_error& error) {
        message = error.what();
    }
    setrlimit(RLIMIT_FSIZE, &old);
    std::signal(SIGXFSZ, old_handler);
    CHECK(message == "cannot write " + path.string() + ": File too large");
    CHECK(entries(folder) == 1);
    CHECK(read_png(path).rgba == grey(8, 8, 10).rgba);
}

TEST_CASE("a picture that cannot be read names its path and the cause", "[image]") {
    const TemporaryFolder folder;
    const fs::path path = folder / "a.png";
    CHECK_THROWS_WITH(read_png(path), Equals("cannot read " + path.string() + ": No such file or directory"));
    CHECK_THROWS_WITH(read_png(folder.path()),
                      Equals("cannot read " + folder.path().string() + ": Is a directory"));
    std::ofstream(path) << "not a picture";
    CHECK_THROWS_WITH(read_png(path), Contains("cannot read " + path.string() + ": not a whole PNG"));
    const std::vector<std::uint8_t> whole = encode_png(pattern(40, 40));
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(whole.data()), static_cast<std::streamsize>(whole.size() / 2));
    CHECK_THROWS_WITH(read_png(path), Contains("not a whole PNG"));
    std::ofstream(path, std::ios::trunc).close();
    CHECK_THROWS_WITH(read_png(path), Contains("not a whole PNG"));
}

TEST_CASE("a picture without the bytes of its size is refused", "[image]") {
    const std::string cause = "4 bytes per pixel and at least one pixel are needed";
    CHECK_THROWS_WITH(encode_png({3, 2, std::vector<std::uint8_t>(23)}),
                      Contains("encode_png: an image of 3 x 2 with 23 bytes") && Contains(cause));
    CHECK_THROWS_WITH(encode_png({}), Contains("0 x 0") && Contains(cause));
    CHECK_THROWS_WITH(compare(grey(2, 2, 0), {}), Contains("compare:") && Contains(cause));
    CHECK_THROWS_WITH(magnified_difference({}, grey(2, 2, 0), 2),
                      Contains("magnified_difference:") && Contains(cause));
}

TEST_CASE("equal pictures differ by nothing", "[image]") {
    const ImageDifference d = compare(pattern(9, 5), pattern(9, 5));
    CHECK(d.same_size);
    CHECK(d.largest == 0);
    CHECK(d.fraction_over_2 == 0);
    CHECK(d.fraction_over_32 == 0);
    CHECK(std::isinf(d.psnr));
}

TEST_CASE("differences are counted per pixel and their worst place is named", "[image]") {
    const Image a = grey(10, 10, 100);
    Image b = a;
    b.pixel(1, 0)[0] = 102;                     // by 2: not over 2
    b.pixel(2, 0)[1] = 97;                      // by 3
    b.pixel(3, 4)[0] = b.pixel(3, 4)[2] = 132;  // by 32 twice: one pixel, not over 32
    b.pixel(7, 8)[2] = 60;                      // by 40
    b.pixel(9, 9)[3] = 0;                       // alpha counts for nothing
    const ImageDifference d = compare(a, b);
    CHECK(d.largest == 40);
    CHECK(d.worst_x == 7);
    CHECK(d.worst_y == 8);
    CHECK(d.fraction_over_2 == Approx(0.03));
    CHECK(d.fraction_over_32 == Approx(0.01));
    // Mean square over 300 channels: (4 + 9 + 2·1024 + 1600) / 300 = 12.2033…
    CHECK(d.psnr == Approx(10 * std::log10(255 * 255 / (3661.0 / 300))));
    CHECK(compare(b, a).largest == 40);
}

TEST_CASE("pictures of different sizes are told so", "[image]") {
    CHECK_FALSE(compare(grey(4, 6, 0), grey(6, 4, 0)).same_size);
    CHECK_THROWS_WITH(magnified_difference(grey(4, 6, 0), grey(6, 4, 0), 8),
                      Equals("magnified_difference: 4 x 6 against 6 x 4; equal sizes are needed"));
}

TEST_CASE("a magnified difference is clamped and opaque", "[image]") {
    const Image a = grey(3, 1, 100);
    Image b = a;
    b.pixel(1, 0)[1] = 90;
    b.pixel(2, 0)[2] = 200;
    const Image d = magnified_difference(a, b, 16);
    CHECK(d.rgba == std::vector<std::uint8_t>{0, 0, 0, 255, 0, 160, 0, 255, 0, 0, 255, 255});
}
