// The movie: checked by reading it back.

#include <stdlib.h>
#include <sys/stat.h>

#include <array>
#include <catch2/catch.hpp>
#include <cstdio>
#include <memory>

#include "pipeline/formats/error.h"
#include "pipeline/formats/video.h"
#include "support/temporary_folder.h"

using namespace cloth::pipeline;
using Catch::Matchers::Contains;
using cloth::render::Image;
namespace fs = std::filesystem;

namespace {

/// Standard output of a shell command.
std::string output_of(const std::string& command) {
    const std::unique_ptr<FILE, int (*)(FILE*)> pipe(popen(command.c_str(), "r"), pclose);
    std::string text;
    char buffer[4096];
    std::size_t got;
    while ((got = fread(buffer, 1, sizeof buffer, pipe.get())) > 0) text.append(buffer, got);
    return text;
}

std::string probe(const fs::path& movie, const std::string& what) {
    return output_of("ffprobe -v error -count_frames -select_streams v:0 -show_entries " + what +
                     " -of default=noprint_wrappers=1 '" + movie.string() + "'");
}

Image plain(int width, int height, std::array<int, 3> color) {
    Image image;
    image.width = width;
    image.height = height;
    for (int i = 0; i < width * height; ++i)
        for (const int channel : {color[0], color[1], color[2], 255})
            image.rgba.push_back(static_cast<std::uint8_t>(channel));
    return image;
}

void write_movie(const fs::path& path, int width, int height, int frames, VideoOptions options = {}) {
    VideoWriter movie(path, width, height, options);
    for (int i = 0; i < frames; ++i) movie.add(plain(width, height, {200, 40 + 10 * i, 60}));
    movie.finish();
}

std::string encoder_message(const std::function<void()>& work) {
    try {
        work();
    } catch (const Error& e) {
        CHECK(e.code == ExitCode::encoder);
        return e.what();
    }
    FAIL("no Error");
    return {};
}

/// PATH leads to `folder` alone, for as long as this lives.
class OnlyPath {
  public:
    explicit OnlyPath(const std::string& path) : before_(getenv("PATH")) { setenv("PATH", path.c_str(), 1); }
    ~OnlyPath() { setenv("PATH", before_.c_str(), 1); }

  private:
    std::string before_;
};

}  // namespace

TEST_CASE("a movie has the size, rate, format, tags and number of frames that it should", "[video]") {
    const TemporaryFolder folder;
    const fs::path movie = folder / "m.mp4";
    write_movie(movie, 64, 48, 10, {.frame_rate = 24.0});
    const std::string facts = probe(movie,
                                    "stream=codec_name,width,height,pix_fmt,color_range,color_space,"
                                    "color_transfer,color_primaries,r_frame_rate,nb_read_frames");
    for (const char* fact : {"codec_name=h264", "width=64", "height=48", "pix_fmt=yuv420p", "color_range=tv",
                             "color_space=bt709", "color_transfer=bt709", "color_primaries=bt709",
                             "r_frame_rate=24/1", "nb_read_frames=10"})
        CHECK_THAT(facts, Contains(fact));
    CHECK(std::distance(fs::directory_iterator(folder.path()), {}) == 1);
}

TEST_CASE("the index stands before the pictures, so that a browser starts at once", "[video]") {
    const TemporaryFolder folder;
    write_movie(folder / "m.mp4", 64, 48, 5);
    const std::string bytes = slurp(folder / "m.mp4");
    REQUIRE(bytes.find("moov") != std::string::npos);
    CHECK(bytes.find("moov") < bytes.find("mdat"));
}

TEST_CASE("odd sizes are padded by the edge's own pixels", "[video]") {
    const TemporaryFolder folder;
    const fs::path movie = folder / "m.mp4";
    write_movie(movie, 65, 47, 3);
    CHECK_THAT(probe(movie, "stream=width,height"), Contains("width=66") && Contains("height=48"));
    // The added corner has the picture's colour.
    const std::string raw =
        output_of("ffmpeg -v error -i '" + movie.string() + "' -frames:v 1 -f rawvideo -pix_fmt rgb24 -");
    REQUIRE(raw.size() == 66 * 48 * 3);
    for (std::size_t c = 0; c < 3; ++c)
        CHECK(std::abs(int(static_cast<unsigned char>(raw[raw.size() - 3 + c])) -
                       int(static_cast<unsigned char>(raw[c]))) <= 2);
}

TEST_CASE("colours survive the way through the movie", "[video]") {
    const TemporaryFolder folder;
    const fs::path movie = folder / "m.mp4";
    const std::array<std::array<int, 3>, 5> colors = {
        {{255, 255, 255}, {0, 0, 0}, {200, 40, 60}, {30, 160, 60}, {40, 60, 220}}};
    VideoWriter writer(movie, 64, 64, {.quality = 5});
    for (const auto& color : colors) writer.add(plain(64, 64, color));
    writer.finish();
    const std::string raw =
        output_of("ffmpeg -v error -i '" + movie.string() + "' -f rawvideo -pix_fmt rgb24 -");
    REQUIRE(raw.size() == colors.size() * 64 * 64 * 3);
    for (std::size_t i = 0; i < colors.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            INFO("colour " << i << ", channel " << c);
            // A matrix of the wrong standard is off by 10 and more.
            CHECK(std::abs(int(static_cast<unsigned char>(raw[(i * 64 * 64 + 32 * 64 + 32) * 3 + c])) -
                           colors[i][c]) <= 4);
        }
}

TEST_CASE("the same pictures make the same bytes", "[video]") {
    const TemporaryFolder folder;
    write_movie(folder / "a.mp4", 64, 48, 20, {.threads = 1});
    write_movie(folder / "b.mp4", 64, 48, 20, {.threads = 1});
    CHECK(slurp(folder / "a.mp4") == slurp(folder / "b.mp4"));
    write_movie(folder / "c.mp4", 64, 48, 20, {.threads = 2});
    write_movie(folder / "d.mp4", 64, 48, 20, {.threads = 2});
    CHECK(slurp(folder / "c.mp4") == slurp(folder / "d.mp4"));
}

TEST_CASE("a movie that is not finished leaves no file", "[video]") {
    const TemporaryFolder folder;
    {
        VideoWriter movie(folder / "m.mp4", 64, 48, {});
        movie.add(plain(64, 48, {1, 2, 3}));
    }
    CHECK(fs::is_empty(folder.path()));
}

TEST_CASE("a picture of another size is refused", "[video]") {
    const TemporaryFolder folder;
    VideoWriter movie(folder / "m.mp4", 64, 48, {});
    CHECK_THROWS_WITH(movie.add(plain(32, 48, {1, 2, 3})), Contains("32x48 in a movie of 64x48"));
}

TEST_CASE("a missing ffmpeg is told of with the package that brings it", "[video]") {
    const TemporaryFolder folder;
    const OnlyPath path(folder.path().string());
    CHECK_THAT(encoder_message([] { ffmpeg_version(); }), Contains("cannot start ffmpeg") &&
                                                              Contains("install the package ffmpeg") &&
                                                              Contains("--no-video"));
}

TEST_CASE("an ffmpeg that fails is quoted, and leaves no movie", "[video]") {
    const TemporaryFolder folder, tools;
    SECTION("it cannot write its file") {
        CHECK_THAT(encoder_message([&] { write_movie(folder / "none/m.mp4", 64, 48, 3); }),
                   Contains("cannot write") && Contains("none/m.mp4: No such file or directory"));
    }
    SECTION("it gives up half-way, while pictures still come") {
        spit(tools / "ffmpeg",
             "#!/bin/sh\n/usr/bin/head -c 20000 >/dev/null\necho chatter >&2\necho 'out of ink' >&2\nexit "
             "3\n");
        chmod((tools / "ffmpeg").c_str(), 0755);
        const OnlyPath path(tools.path().string());
        CHECK_THAT(encoder_message([&] { write_movie(folder / "m.mp4", 320, 240, 50); }),
                   Contains("exit status 3") && Contains("chatter | out of ink"));
    }
    SECTION("it is killed") {
        spit(tools / "ffmpeg", "#!/bin/sh\nkill -9 $$\n");
        chmod((tools / "ffmpeg").c_str(), 0755);
        const OnlyPath path(tools.path().string());
        CHECK_THAT(encoder_message([&] { write_movie(folder / "m.mp4", 320, 240, 50); }),
                   Contains("exit status 137") && Contains("it said nothing"));
    }
    CHECK(fs::is_empty(folder.path()));
}
