// What goes wrong on the way: exit codes, messages, and what is kept.

#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("a full disk is told of in one line and leaves no half-written file", "[cli]") {
    const Workplace place;
    // A limit on file size (blocks of 512 bytes) stands in for a full disk.
    SECTION("while states are written") {
        check_refusal(place.run("simulate " + base + "--frames 20", "ulimit -f 9;"), 1,
                      {"cannot write o/states/state_00000", "File too large"});
    }
    SECTION("while the movie is written") {
        const Outcome outcome =
            place.run(base + "--frames 40 --size 256x192 --set output.quality=0", "ulimit -f 60;");
        check_refusal(outcome, 7, {"ffmpeg failed on o/sheet.mp4"});
        CHECK(fs::exists(place / "o/frames/frame_000039.png"));
    }
    SECTION("while meshes are exported") {
        REQUIRE(place.run("simulate " + base + "--frames 2").code == 0);
        check_refusal(place.run("export --out o --frames 0:2 --file m.obj --quiet", "ulimit -f 9;"), 1,
                      {"cannot write m_000000.obj: File too large"});
        CHECK_FALSE(fs::exists(place / "m_000000.obj"));
    }
    for (const std::string& name : place.files()) CHECK_THAT(name, !Catch::EndsWith(".part"));
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
}

TEST_CASE("without ffmpeg nothing is begun, and --no-video does without it", "[cli]") {
    const Workplace place;
    check_refusal(place.run(base + "--frames 3", "PATH=/nonexistent"), 7,
                  {"cannot start ffmpeg", "install the package ffmpeg", "--no-video"});
    CHECK_FALSE(fs::exists(place / "o"));
    CHECK(place.run(base + "--frames 3 --no-video", "PATH=/nonexistent").code == 0);
    CHECK(fs::exists(place / "o/frames/frame_000002.png"));
    CHECK(place.run("simulate " + base + "--frames 3", "PATH=/nonexistent").code == 0);
}

TEST_CASE("an ffmpeg that fails half-way is quoted, and all pictures are kept", "[cli]") {
    const Workplace place;
    fs::create_directory(place / "bin");
    spit(place / "bin/ffmpeg",
         "#!/bin/sh\ncase \"$*\" in *-version*) echo ffmpeg version fake; exit 0;; esac\n"
         "/usr/bin/head -c 20000 >/dev/null\necho 'out of ink' >&2\nexit 3\n");
    chmod((place / "bin/ffmpeg").c_str(), 0755);
    const Outcome outcome = place.run(base + "--frames 8", "PATH=$PWD/bin");
    check_refusal(outcome, 7, {"ffmpeg failed on o/sheet.mp4", "exit status 3", "out of ink"});
    for (int frame = 0; frame < 8; ++frame)
        CHECK(render::read_png(place / ("o/frames/frame_00000" + std::to_string(frame) + ".png")).width ==
              64);
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    CHECK_THAT(report_of(place, "o")["outcome"].get<std::string>(), Contains("out of ink"));
}

TEST_CASE("a diverging simulation names frame, vertex and last good frame, and keeps the good ones",
          "[cli]") {
    const Workplace place;
    const Outcome outcome =
        place.run(base +
                  "--frames 30 --set simulation.gravity=[0,1e4,0] --set simulation.frame_rate=0.01 "
                  "--set simulation.time_step=100 --set simulation.integrator=implicit_euler --set "
                  "simulation.contact=barrier");
    check_refusal(outcome, 4,
                  {"the simulation diverged: in frame ", " vertex ", "is more than 1e+09 m away",
                   "the last good frame is ", "kept in o"});
    const std::string& line = outcome.err;
    const int frame = std::stoi(line.substr(line.find("in frame ") + 9));
    const int good = std::stoi(line.substr(line.find("last good frame is ") + 19));
    CHECK(good == frame - 1);
    // Exactly the good frames have states; pictures of all of them were drawn.
    const auto run = pipeline::RunFolder::open(place / "o");
    CHECK(run.kept_states().size() == static_cast<std::size_t>(frame));
    CHECK(run.kept_images() == run.kept_states());
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    CHECK(report_of(place, "o")["frames"].size() == static_cast<std::size_t>(frame));
}

TEST_CASE("Ctrl-C keeps every finished frame whole", "[cli]") {
    const Workplace place;
    const int stop = GENERATE(SIGINT, SIGTERM);
    const pid_t child = fork();
    if (child == 0) {
        if (chdir(place.path().c_str()) != 0 || freopen("err.txt", "w", stderr) == nullptr) _exit(99);
        execl(RENDER_CLOTH_BINARY, "render_cloth", "--scene", "sheet.toml", "--out", "o", "--frames", "5000",
              "--quiet", nullptr);
        _exit(99);
    }
    for (int i = 0; i < 3000 && !fs::exists(place / "o/frames/frame_000004.png"); ++i)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    kill(child, stop);
    int status = 0;
    waitpid(child, &status, 0);
    REQUIRE(WIFEXITED(status));
    CHECK(WEXITSTATUS(status) == 130);
    const auto run = pipeline::RunFolder::open(place / "o");
    const auto states = run.kept_states(), images = run.kept_images();
    CHECK(images.size() >= 5);
    CHECK(states.size() >= images.size());
    CHECK(states.size() < 5000);
    CHECK_THAT(slurp(place / "err.txt"),
               Contains("render_cloth: interrupted: " + std::to_string(states.size()) + " states and " +
                        std::to_string(images.size()) + " pictures of 5000 are kept in o"));
    for (const auto frame : states) CHECK_NOTHROW(pipeline::read_state(run.state(frame)));
    for (const auto frame : images) CHECK_NOTHROW(render::read_png(run.image(frame)));
    for (const std::string& name : place.files()) CHECK_THAT(name, !Catch::EndsWith(".part"));
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    CHECK(report_of(place, "o")["outcome"] == "interrupted");
    // What was kept can be drawn on.
    CHECK(place.run("render --out o --quiet --frames 0:2").code == 0);
}

TEST_CASE("a start with overlaps is refused by exit code 5, and the pairs are named", "[cli]") {
    const Workplace place;
    const std::string barrier =
        "simulate --scene sheet.toml --out o --quiet --frames 4 --set simulation.contact=barrier --set "
        "simulation.integrator=implicit_euler --set collider.name=ball ";
    check_refusal(
        place.run(barrier + "--set cloth.translate=[0.01,0.2,0.02]"), 5,
        {"things overlap: cloth cloth and collider ball are ",
         " mm nearer than their contact thickness at vertices ", " of cloth cloth; lift cloth cloth by "});
    check_refusal(place.run(barrier + "--set collider.shape=box --set collider.contact_offset=0 --set "
                                      "cloth.translate=[0.01,0.2,0.02]"),
                  5,
                  {"things overlap: cloth cloth triangle ", " crosses collider ball triangle ",
                   "; in red in o/overlap.png"});
    const render::Image image = render::read_png(place / "o/overlap.png");
    int red = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4)
        red += image.rgba[i] > 90 && 2 * std::max(image.rgba[i + 1], image.rgba[i + 2]) < image.rgba[i];
    CHECK(red > image.width * image.height / 200);

    // The same a little higher is good, and its report has the gaps.
    REQUIRE(place.run(barrier + "--set cloth.translate=[0.01,0.263,0.02]").code == 0);
    CHECK_FALSE(fs::exists(place / "o/overlap.png"));
    const auto report = report_of(place, "o");
    CHECK(report["frames"][0]["smallest_gap_m"].is_null());
    for (int frame = 1; frame < 4; ++frame) {
        CHECK(report["frames"][frame]["smallest_gap_m"] > 0.0);
        CHECK(report["frames"][frame]["smallest_gap_m"] <= 1e-3);  // contact_activation, where none is near
        CHECK(report["frames"][frame]["largest_penetration_m"] == 0.0);
    }
    CHECK(report["frames"][3]["contacts"] > 0);
}

namespace {

/// What a run of 30 frames says that stops on its way with exit code 4 and keeps what it has finished.
std::string message_of_stop(const Workplace& place, const std::string& scene) {
    const Outcome stopped = place.run("simulate --scene " + scene + " --out o --quiet --frames 30");
    CHECK(stopped.code == 4);
    const auto kept = place.files("o/states");
    CHECK(std::count(kept.begin(), kept.end(), "state_000001.bin") == 1);
    CHECK(std::count(kept.begin(), kept.end(), "state_000029.bin") == 0);
    return stopped.err;
}

}  // namespace

TEST_CASE("pins whose ways tear the cloth are refused before anything is written", "[cli]") {
    const Workplace place;
    spit(place / "torn.toml", R"(
version = 1
[[cloth]]
size = [0.1, 0.2]
resolution = [3, 5]
[[pin]]
edge = "top"
[[pin]]
edge = "bottom"
path = [{ time = 0.0 }, { time = 0.5, translate = [0.0, -0.1, 0.0] }]
)");
    check_refusal(place.run("simulate --scene torn.toml --out o --quiet --frames 30"), 3,
                  {"torn.toml:10:8: pin[1].path: asks for a stretch of 1.05 at 0.05 s (frame 3)",
                   "strain limit 1.05 (cloth[0].fabric.strain_limit)"});
    CHECK_FALSE(fs::exists(place / "o"));
    // What a run does not get to does not matter.
    CHECK(place.run("simulate --scene torn.toml --out o --quiet --frames 3").code == 0);
}

TEST_CASE("a start beyond the strain limit is refused with line, stretch and limit", "[cli]") {
    const Workplace place;
    spit(place / "scale.toml", "version = 1\n[[cloth]]\nscale = 2.0\n[[collider]]\nradius = 0.3\n");
    check_refusal(
        place.run("simulate --scene scale.toml --out o --quiet --frames 3"), 3,
        {"scale.toml:3:9: cloth[0].scale: cloth cloth starts stretched to 2 ", "strain limit 1.05"});
    CHECK_FALSE(fs::exists(place / "o"));
}

TEST_CASE("cloth wound up as tight as it gets stops with exit code 4 and says what it met and where",
          "[cli]") {
    const Workplace place;
    spit(place / "wound.toml", R"(
version = 1
[simulation]
gravity = [0.0, 0.0, 0.0]
[[cloth]]
name = "towel"
size = [0.2, 0.06]
resolution = [13, 5]
bump = 0.001
[[pin]]
edge = "left"
path = [{ time = 0.0 }, { time = 0.5, rotate = [360.0, 0.0, 0.0] }]
[[pin]]
edge = "right"
path = [{ time = 0.0 }, { time = 0.5, rotate = [-360.0, 0.0, 0.0] }]
[output]
size = [64, 48]
)");
    CHECK_THAT(message_of_stop(place, "wound.toml"),
               Contains("wound: frame ") &&
                   Contains(" s on pins and colliders cannot get to where they are to be at ") &&
                   Contains(" of cloth towel at (") && Contains("; frames up to ") && !Contains("residual"));
}

TEST_CASE("a step that would take more iterations than it may stops the run with exit code 4", "[cli]") {
    const Workplace place;
    spit(place / "hasty.toml", R"(
version = 1
[simulation]
integrator = "implicit_euler"
newton_iterations = 1
newton_tolerance = 1e-13
retries = 1
[[cloth]]
size = [0.2, 0.2]
resolution = 5
fabric = "cotton"
[[pin]]
edge = "left"
[output]
size = [64, 48]
)");
    const Outcome stopped = place.run("simulate --scene hasty.toml --out o --quiet --frames 3");
    CHECK(stopped.code == 4);
    CHECK_THAT(stopped.err, Contains("did not converge, not even cut into 2 parts") &&
                                Contains(": residual ") && Contains("farthest from balance is vertex ") &&
                                Contains(" of cloth cloth at ("));
}

TEST_CASE("cloth pressed where there is no room for it stops with exit code 4 and says so", "[cli]") {
    const Workplace place;
    spit(place / "press.toml", R"(
version = 1
[simulation]
retries = 1
[[cloth]]
size = [0.1, 0.1]
resolution = [4, 4]
rotate = [-90.0, 0.0, 0.0]
fabric = "cotton"
[[collider]]
name = "below"
shape = "plane"
center = [0.0, -0.005, 0.0]
[[collider]]
name = "above"
shape = "plane"
center = [0.0, 0.005, 0.0]
normal = [0.0, -1.0, 0.0]
path = [{ time = 0.0 }, { time = 0.2, translate = [0.0, -0.02, 0.0] }]
[output]
size = [64, 48]
)");
    CHECK_THAT(
        message_of_stop(place, "press.toml"),
        Contains("press: frame ") && Contains("pins and colliders cannot get to where they are to be at ") &&
            Contains("collider above") && Contains("collider below") && Contains(" close on vertex ") &&
            Contains("the cloth needs 1 mm") && !Contains("residual"));
}

TEST_CASE("a collider switched on over cloth names frame, time and event, and keeps the frames before",
          "[cli]") {
    const Workplace place;
    spit(place / "block.toml", R"(
version = 1
[[cloth]]
resolution = 8
rotate = [-90.0, 0.0, 0.0]
[[pin]]
edge = "left"
[[collider]]
name = "block"
shape = "box"
enabled = false
[[event]]
time = 0.1
collider = "block"
[output]
size = [64, 48]
)");
    check_refusal(
        place.run("simulate --scene block.toml --out o --quiet --frames 30"), 5,
        {"block: frame 7: things overlap at 0.1 s, where an event switches collider block on: cloth cloth "
         "triangle ",
         " crosses collider block triangle ", "; frames up to 6 are kept in o", "; in red in o/overlap.png"});
    CHECK(fs::exists(place / "o/states/state_000006.bin"));
    CHECK_FALSE(fs::exists(place / "o/states/state_000007.bin"));
}
