// The program as a user meets it: exit codes, messages, and what it leaves on disk.

#include <signal.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

struct Outcome {
    int code = -1;
    std::string out, err;
};

/// A working folder with a scene, and the program run in it.
class Workplace {
  public:
    Workplace() {
        spit(folder_ / "sheet.toml", R"(version = 1
description = "A small sheet that falls on a sphere."

[simulation]
frame_rate = 60
time_step = 0.005

[[cloth]]
resolution = [12, 12]
rotate = [-90, 0, 0]
translate = [0, 0.27, 0]

[[collider]]
shape = "sphere"
radius = 0.25
contact_offset = 0.01

[camera]
position = [0.4, 1.0, 2.6]
target = [0, 0, 0]

[output]
size = [64, 48]

[expect]
frames = [0, 3]
)");
    }

    /// `setting` comes before the program on the shell's line: environment, limits.
    Outcome run(const std::string& arguments, const std::string& setting = "") const {
        const fs::path out = logs_ / "out", err = logs_ / "err";
        const std::string command = "cd '" + folder_.path().string() + "' && " + setting + " '" +
                                    RENDER_CLOTH_BINARY + "' " + arguments + " >'" + out.string() + "' 2>'" +
                                    err.string() + "' </dev/null";
        const int status = std::system(command.c_str());
        return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status), slurp(out), slurp(err)};
    }
    fs::path operator/(const std::string& name) const { return folder_ / name; }
    const fs::path& path() const { return folder_.path(); }

    std::vector<std::string> files(const std::string& below = "") const {
        std::vector<std::string> names;
        if (fs::exists(folder_ / below))
            for (const auto& entry : fs::recursive_directory_iterator(folder_ / below))
                if (entry.is_regular_file())
                    names.push_back(fs::relative(entry.path(), folder_ / below).string());
        std::sort(names.begin(), names.end());
        return names;
    }

  private:
    TemporaryFolder folder_, logs_;
};

/// One line, on standard error, that begins with the program's name.
void check_refusal(const Outcome& outcome, int code, const std::vector<std::string>& parts) {
    CHECK(outcome.code == code);
    CHECK(outcome.out.empty());
    CHECK_THAT(outcome.err, Catch::StartsWith("render_cloth: "));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    for (const std::string& part : parts) CHECK_THAT(outcome.err, Contains(part));
}

nlohmann::json report_of(const Workplace& place, const std::string& out) {
    return nlohmann::json::parse(slurp(place / (out + "/report.json")));
}

std::vector<std::string> hashes(const nlohmann::json& report) {
    std::vector<std::string> list;
    for (const auto& frame : report["frames"]) list.push_back(frame["state_hash"]);
    return list;
}

const std::string base = "--scene sheet.toml --out o --quiet ";

}  // namespace

// ---------------------------------------------------------------- what is refused

TEST_CASE("bad arguments are refused with what would be right, and leave nothing behind", "[cli]") {
    const Workplace place;
    spit(place / "file", "x");
    const auto before = place.files();
    struct Case {
        const char* arguments;
        std::vector<std::string> parts;
    };
    const std::vector<Case> cases = {
        {"", {"--scene is missing", "render_cloth list"}},
        {"--frames 3", {"--scene is missing"}},
        {"simulate", {"--scene is missing"}},
        {"frobnicate", {"unknown verb \"frobnicate\"", "simulate", "compare"}},
        {"simulate sheet.toml", {"unexpected argument \"sheet.toml\""}},
        {"list clothes", {"list clothes: give scenes, fabrics or keys"}},
        {"list fabrics coton", {"no fabric \"coton\"; did you mean \"cotton\"?", "known: cotton, denim"}},
        {"list scenes drape_sphere", {"list scenes takes no name"}},
        {"list --sources", {"no --sources"}},
        {"list fabrics cotton silk", {"unexpected argument \"silk\""}},
        {"--scene sheet.toml --frobnicate", {"unknown option --frobnicate", "--help"}},
        {"simulate --scene sheet.toml --frobnicate 3", {"unknown option --frobnicate"}},
        {"--scene sheet.toml --frames", {"--frames", "--help"}},
        {"--scene sheet.toml --frames 0", {"--frames 0", "1 … 999999"}},
        {"--scene sheet.toml --frames -3", {"--frames -3", "1 … 999999"}},
        {"--scene sheet.toml --frames many", {"--frames many", "whole number"}},
        {"--scene sheet.toml --frames 1.5", {"--frames 1.5", "whole number"}},
        {"--scene sheet.toml --frames 99999999999999", {"--frames 99999999999999", "1 … 999999"}},
        {"--scene sheet.toml --size 0x0", {"--size 0x0", "WIDTHxHEIGHT", "16 … 8192"}},
        {"--scene sheet.toml --size 8193x720", {"--size 8193x720", "16 … 8192"}},
        {"--scene sheet.toml --size -64x48", {"--size -64x48", "16 … 8192"}},
        {"--scene sheet.toml --size 640", {"--size 640", "WIDTHxHEIGHT"}},
        {"--scene sheet.toml --size 640x", {"--size 640x", "WIDTHxHEIGHT"}},
        {"--scene sheet.toml --size 640x480x3", {"--size 640x480x3", "WIDTHxHEIGHT"}},
        {"--scene sheet.toml --fps nan", {"--fps nan", "0.1 … 1000"}},
        {"--scene sheet.toml --fps inf", {"--fps inf", "0.1 … 1000"}},
        {"--scene sheet.toml --fps 0", {"--fps 0", "0.1 … 1000"}},
        {"--scene sheet.toml --fps -24", {"--fps -24", "0.1 … 1000"}},
        {"--scene sheet.toml --fps fast", {"--fps fast", "0.1 … 1000"}},
        {"--scene sheet.toml --threads 0", {"--threads 0", "1 … 1024"}},
        {"--scene sheet.toml --gl vulkan", {"--gl vulkan", "egl, osmesa or auto"}},
        {"--scene sheet.toml --threads two", {"--threads two", "1 … 1024"}},
        {"--scene sheet.toml --frames 2 --out file", {"--out file", "is a file; give a folder"}},
        {"--scene sheet.toml --set nonsense", {"--set nonsense", "KEY=VALUE"}},
        {"--scene sheet.toml --set =3", {"--set =3", "KEY=VALUE"}},
        {"compare sheet.toml --set nonsense", {"--set nonsense", "KEY=VALUE"}},
        {"render", {"--out is missing"}},
        {"render --out o --frames 3", {"--frames 3", "A:B"}},
        {"render --out o --frames 3:3", {"--frames 3:3", "A < B"}},
        {"render --out o --frames -1:3", {"--frames -1:3", "0 <= A"}},
        {"encode", {"--out is missing"}},
        {"export", {"--out is missing"}},
        {"export --out o --format obj --file f", {"--frame is missing"}},
        {"export --out o --frame x --format obj --file f", {"--frame x", "whole number"}},
        {"export --out o --frame 1 --format stl --file f", {"--format stl", "obj or ply"}},
        {"export --out o --frame 1 --format obj", {"--file is missing"}},
        {"--scene sheet.toml --shade strech",
         {"--shade strech", "stretch, bending, kinetic, gap, strain_rate"}},
        {"--scene sheet.toml --shade gap --shade-range 1", {"--shade-range 1", "LOW:HIGH"}},
        {"--scene sheet.toml --shade gap --shade-range 2:1", {"--shade-range 2:1", "LOW:HIGH"}},
        {"--scene sheet.toml --ids 3", {"--ids 3", "X,Y or X,Y,RADIUS"}},
        {"--scene sheet.toml --ids 3,4,0", {"--ids 3,4,0", "X,Y,RADIUS"}},
        {"--scene sheet.toml --curves energy,heat", {"\"heat\" is none of energy, kinetic, stretch, gap"}},
        {"--scene sheet.toml --motion-blur 0", {"--motion-blur 0", "1 … 64"}},
        {"render --out o --shade blue", {"--shade blue", "give one of"}},
        {"sheet", {"--out is missing", "--scene"}},
        {"sheet --out o --count 0", {"--count 0", "1 … 1000"}},
        {"sheet --out o --columns x", {"--columns x", "1 … 1000"}},
        {"sheet --out o --frames 4", {"--frames 4", "A:B"}},
        {"compare-video", {"give the folders of two runs", "--file"}},
        {"compare-video a b c --file f.mp4", {"give the folders of two runs"}},
        {"compare-video a b", {"--file is missing"}},
        {"compare-video a b --file f.png", {"--file f.png", "name.mp4"}},
        {"compare-video a b --file f.mp4 --labels one", {"--labels one", "two texts"}},
        {"list nothing", {"list nothing", "keys"}},
        {"compare", {"compare: the scene is missing", "render_cloth compare"}},
        {"bless", {"bless: the scene is missing"}},
    };
    for (const Case& c : cases) {
        INFO("render_cloth " << c.arguments);
        check_refusal(place.run(c.arguments), 2, c.parts);
        CHECK(place.files() == before);
    }
}

TEST_CASE("bad scenes and meshes are refused before anything is written", "[cli]") {
    const Workplace place;
    spit(place / "empty.obj", "");
    spit(place / "garbage.obj", "this is no mesh\n\x01\x02\x03");
    spit(place / "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    spit(place / "quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    spit(place / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    spit(place / "twice.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3 1\n");
    spit(place / "range.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 7\n");
    spit(place / "nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    spit(place / "pinned.toml", slurp(place / "sheet.toml") + "\n[[pin]]\nbox = [[5, 5, 5], [6, 6, 6]]\n");
    spit(place / "broken.toml", "version = 1\n[simulation\n");
    const auto before = place.files();
    struct Case {
        std::string arguments;
        std::vector<std::string> parts;
    };
    const std::vector<Case> cases = {
        {"--scene drape_spere", {"drape_spere", "drape_sphere"}},
        {"--scene none.toml", {"none.toml"}},
        {"--scene broken.toml", {"broken.toml", "2"}},
        {"--scene pinned.toml", {"pin[0]"}},
        {"--scene sheet.toml --set cloth.densty=1", {"densty"}},
        {"--scene sheet.toml --set simulation.time_step=fast", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=0", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=-0.01", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=nan", {"time_step"}},
        {"--scene sheet.toml --set simulation.time_step=inf", {"time_step"}},
        {"--scene sheet.toml --set simulation.frame_rate=0", {"frame_rate"}},
        {"--scene sheet.toml --set 'cloth.resolution=[1, 12]'", {"resolution"}},
        {"--scene sheet.toml --set 'cloth.resolution=[-4, 12]'", {"resolution"}},
        {"--scene sheet.toml --set 'cloth.size=[0, 1]'", {"size"}},
        {"--scene sheet.toml --set 'cloth.translate=[0, nan, 0]'", {"translate"}},
        {"--scene sheet.toml --set collider.radius=-1", {"radius"}},
        {"--scene sheet.toml --set output.frames=0", {"frames"}},
        {"--scene sheet.toml --set cloth.mesh=none.obj", {"none.obj"}},
        {"--scene sheet.toml --set cloth.mesh=empty.obj", {"empty.obj"}},
        {"--scene sheet.toml --set cloth.mesh=garbage.obj", {"garbage.obj"}},
        {"--scene sheet.toml --set cloth.mesh=points.obj", {}},
        {"--scene sheet.toml --set cloth.mesh=quad.obj", {"quad.obj", "triangle"}},
        {"--scene sheet.toml --set cloth.mesh=flat.obj", {"triangle 0", "degenerate"}},
        {"--scene sheet.toml --set cloth.mesh=twice.obj", {"triangle 1", "repeats triangle 0"}},
        {"--scene sheet.toml --set cloth.mesh=range.obj", {}},
        {"--scene sheet.toml --set cloth.mesh=nan.obj", {}},
    };
    for (const Case& c : cases) {
        INFO("render_cloth " << c.arguments);
        check_refusal(place.run(c.arguments + " --out o"), 3, c.parts);
        CHECK(place.files() == before);
    }
}

TEST_CASE("folders that cannot be used are named with the reason", "[cli]") {
    const Workplace place;
    spit(place / "file", "x");
    check_refusal(place.run("--scene sheet.toml --frames 2 --out file/below"), 1,
                  {"cannot write to the folder file/below", "Not a directory"});
    check_refusal(place.run("render --out nowhere"), 1, {"nowhere: holds no run", "render_cloth simulate"});
    check_refusal(place.run("export --out nowhere --frame 0 --format obj --file f.obj"), 1, {"holds no run"});
    CHECK_FALSE(fs::exists(place / "nowhere"));
}

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
    const Outcome outcome = place.run(base + "--frames 30 --set simulation.gravity=[0,-1e307,0]");
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
    check_refusal(place.run(barrier + "--set cloth.translate=[0.01,0.2,0.02]"), 5,
                  {"things overlap: collider ball and cloth cloth are ",
                   " mm nearer than their contact thickness at vertices "});
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

// ---------------------------------------------------------------- what is made

TEST_CASE("a run leaves states, pictures, a movie and a report, and says so in its last line", "[cli]") {
    const Workplace place;
    const Outcome outcome = place.run("--scene sheet.toml --frames 5");
    CHECK(outcome.code == 0);
    for (const char* part : {"sheet: 5 frames, 5 pictures of 64x48, a movie at 60 frames/s", "simulate ",
                             "wall ", ": out/sheet/sheet.mp4\n"})
        CHECK_THAT(outcome.out, Contains(part));
    CHECK(std::count(outcome.out.begin(), outcome.out.end(), '\n') == 1);
    std::vector<std::string> expected = {"report.json", "scene.toml", "sheet.mp4", "states/manifest.json",
                                         "states/topology.bin"};
    for (int frame = 0; frame < 5; ++frame) {
        expected.push_back("frames/frame_00000" + std::to_string(frame) + ".png");
        expected.push_back("states/state_00000" + std::to_string(frame) + ".bin");
    }
    std::sort(expected.begin(), expected.end());
    CHECK(place.files("out/sheet") == expected);

    const auto report = report_of(place, "out/sheet");
    CHECK(report["outcome"] == "complete");
    CHECK(report["simulation"]["vertices"] == 144);
    CHECK(report["simulation"]["triangles"] == 242);
    REQUIRE(report["frames"].size() == 5);
    CHECK(report["frames"][4]["frame"] == 4);
    CHECK(report["frames"][4]["largest_stretch"] > 0.5);
    for (const char* key : {"energy_before_J", "energy_after_J", "residual", "iterations", "contacts"})
        CHECK(report["frames"][4][key].is_number());
    // Only barriers know them.
    for (const char* key : {"smallest_gap_m", "largest_penetration_m"})
        CHECK(report["frames"][4][key].is_null());
    const State start = pipeline::read_state(place / "out/sheet/states/state_000000.bin");
    CHECK(start.time == 0);
    CHECK(start.velocities.isZero(0));
    const State last = pipeline::read_state(place / "out/sheet/states/state_000004.bin");
    CHECK(last.frame == 4);
    CHECK(last.time == Approx(4.0 / 60.0).epsilon(1e-12));
    CHECK(report["frames"][4]["state_hash"] == pipeline::state_hash(last));
}

TEST_CASE("states and pictures are the same for any number of threads and run after run", "[cli]") {
    const Workplace place;
    for (const char* run : {"--threads 1 --out a", "--threads 2 --out b", "--threads 2 --out c"})
        REQUIRE(place.run(std::string("--scene sheet.toml --frames 25 --quiet ") + run).code == 0);
    const auto reference = hashes(report_of(place, "a"));
    REQUIRE(reference.size() == 25);
    CHECK(hashes(report_of(place, "b")) == reference);
    CHECK(hashes(report_of(place, "c")) == reference);
    for (const char* name : {"frames/frame_000024.png", "states/state_000024.bin"}) {
        CHECK(slurp(place / "a" / name) == slurp(place / "b" / name));
        CHECK(slurp(place / "b" / name) == slurp(place / "c" / name));
    }
    CHECK(slurp(place / "b/sheet.mp4") == slurp(place / "c/sheet.mp4"));
}

TEST_CASE("an odd size is kept in the pictures and padded in the movie", "[cli]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 2 --size 65x47").code == 0);
    const render::Image image = render::read_png(place / "o/frames/frame_000001.png");
    CHECK(image.width == 65);
    CHECK(image.height == 47);
    CHECK(std::system(("test \"$(ffprobe -v error -show_entries stream=width,height -of csv=p=0 '" +
                       (place / "o/sheet.mp4").string() + "')\" = 66,48")
                          .c_str()) == 0);
}

TEST_CASE("the flag --fps changes the rate of the movie, and keeps time true where it runs true", "[cli]") {
    const Workplace place;
    const auto rates = [&](const std::string& more) {
        REQUIRE(place.run("simulate " + base + "--frames 2 " + more).code == 0);
        const auto report = report_of(place, "o");
        return std::pair<double, double>(report["simulation"]["frame_rate_hz"],
                                         report["output"]["playback_rate_hz"]);
    };
    CHECK(rates("") == std::pair(60.0, 60.0));
    CHECK(rates("--fps 24") == std::pair(24.0, 24.0));
    CHECK(rates("--fps 12.5") == std::pair(12.5, 12.5));
    CHECK(rates("--set output.playback_rate=30") == std::pair(60.0, 30.0));
    CHECK(rates("--set output.playback_rate=30 --fps 24") == std::pair(60.0, 24.0));
}

TEST_CASE("a second run into a folder replaces the first", "[cli]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 6").code == 0);
    spit(place / "o/notes.txt", "mine");
    REQUIRE(place.run(base + "--frames 2 --no-video").code == 0);
    const auto run = pipeline::RunFolder::open(place / "o");
    CHECK(run.kept_states() == std::vector<std::int64_t>{0, 1});
    CHECK(run.kept_images() == std::vector<std::int64_t>{0, 1});
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    CHECK(slurp(place / "o/notes.txt") == "mine");
    // A refused run leaves it alone.
    CHECK(place.run(base + "--frames 2 --set cloth.densty=1").code == 3);
    CHECK(run.kept_states().size() == 2);
}

TEST_CASE("pictures are drawn again from kept states, without the scene and mesh they came from", "[cli]") {
    const Workplace place;
    spit(place / "cloth é.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0.1\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    REQUIRE(place.run(base + "--frames 4 --set 'cloth.mesh=\"cloth é.obj\"'").code == 0);
    const std::string picture = slurp(place / "o/frames/frame_000003.png");
    const std::string movie = slurp(place / "o/sheet.mp4");
    fs::remove(place / "cloth é.obj");
    fs::remove(place / "sheet.toml");
    fs::rename(place / "o", place / "moved");

    SECTION("all of them") {
        fs::remove_all(place / "moved/frames");
        fs::remove(place / "moved/sheet.mp4");
        const Outcome outcome = place.run("render --out moved --quiet");
        CHECK(outcome.code == 0);
        CHECK_THAT(outcome.out, Contains("sheet: 4 pictures of 64x48, a movie at 60 frames/s"));
        CHECK(slurp(place / "moved/frames/frame_000003.png") == picture);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("some of them; the movie follows once all are there") {
        fs::remove_all(place / "moved/frames");
        fs::remove(place / "moved/sheet.mp4");
        CHECK(place.run("render --out moved --quiet --frames 2:4").code == 0);
        CHECK(pipeline::RunFolder::open(place / "moved").kept_images() == std::vector<std::int64_t>{2, 3});
        CHECK_FALSE(fs::exists(place / "moved/sheet.mp4"));
        check_refusal(place.run("encode --out moved --quiet"), 1, {"pictures of 2 of the run's 4 frames"});
        CHECK(place.run("render --out moved --quiet --frames 0:2").code == 0);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("the movie alone") {
        fs::remove(place / "moved/sheet.mp4");
        CHECK(place.run("encode --out moved --quiet").code == 0);
        CHECK(slurp(place / "moved/sheet.mp4") == movie);
    }
    SECTION("at another size") {
        CHECK(place.run("render --out moved --quiet --size 96x64").code == 0);
        CHECK(render::read_png(place / "moved/frames/frame_000000.png").width == 96);
        check_refusal(place.run("render --out moved --quiet --size 64x48 --frames 1:2"), 1,
                      {"frame_000001.png is 64x48, the pictures before it 96x64"});
    }
    SECTION("frames without a state are refused") {
        check_refusal(place.run("render --out moved --frames 2:5"), 2,
                      {"the state of frame 4 is not kept", "kept: 4 frames from 0 to 3"});
    }
    SECTION("a damaged state is named") {
        std::string state = slurp(place / "moved/states/state_000002.bin");
        state[state.size() / 2] = static_cast<char>(state[state.size() / 2] ^ 1);
        spit(place / "moved/states/state_000002.bin", state);
        check_refusal(place.run("render --out moved --quiet"), 1, {"state_000002.bin: damaged"});
    }
    SECTION("a scene that is not the states' is refused") {
        check_refusal(place.run("render --out moved --quiet --set cloth.translate=[9,9,9] --set "
                                "cloth.mesh=moved/meshes/none.obj"),
                      3, {"none.obj"});
        spit(place / "moved/meshes/rest_000000.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\n");
        check_refusal(place.run("render --out moved --quiet"), 1,
                      {"its cloth is not the one of the kept states"});
    }
}

TEST_CASE(
    "a run keeps the meshes of colliders and the textures of its scene, and tells where contact's time goes",
    "[cli]") {
    const Workplace place;
    spit(place / "sheet.toml", R"(version = 1

[simulation]
integrator = "implicit_euler"
contact = "barrier"

[[cloth]]
texture = "print.png"

[[collider]]
shape = "mesh"
mesh = "roof.obj"
center = [0, -2, 0]

[output]
size = [64, 48]
)");
    spit(place / "roof.obj", "v -1 0 -1\nv 1 0 -1\nv 0 0.3 1\nf 1 2 3\n");
    render::write_png({2, 1, {255, 0, 0, 255, 0, 255, 0, 255}}, place / "print.png");
    REQUIRE(place.run(base + "--frames 2 --no-video").code == 0);
    const nlohmann::json report = report_of(place, "o");
    double sum = 0;
    for (const char* part : {"detection", "assembly", "factorization", "conjugate_gradients", "line_search"})
        sum += report["contact_times_s"].at(part).get<double>();
    CHECK(sum > 0);
    CHECK(sum <= report["times_s"]["simulate"]);
    const std::string picture = slurp(place / "o/frames/frame_000001.png");
    for (const char* original : {"sheet.toml", "roof.obj", "print.png"}) fs::remove(place / original);
    fs::rename(place / "o", place / "moved");
    fs::remove_all(place / "moved/frames");
    CHECK(place.run("render --out moved --quiet --no-video").code == 0);
    CHECK(slurp(place / "moved/frames/frame_000001.png") == picture);
}

TEST_CASE("a contact sheet holds pictures of a run or of a scene", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 9").code == 0);
    const auto before = place.files("o");
    const Outcome outcome = place.run("sheet --out o --quiet --count 4 --file s.png");
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.out, Contains("4 pictures in ") && Contains("s.png"));
    CHECK(place.files("o") == before);
    const render::Image sheet = render::read_png(place / "s.png");
    CHECK(sheet.width > 2 * 64);
    CHECK(sheet.width < 2 * 64 + 30);
    CHECK(sheet.height > 2 * 48);
    // Four in a row are half as high.
    CHECK(place.run("sheet --out o --quiet --count 4 --columns 4 --file row.png").code == 0);
    CHECK(render::read_png(place / "row.png").height < 48 + 40);
    check_refusal(place.run("sheet --out o --frames 5:20"), 2, {"--frames 5:20", "kept: 9 frames"});
    check_refusal(place.run("sheet --out nowhere"), 1, {"nowhere: holds no run"});

    const Outcome scene = place.run("sheet --scene sheet.toml --frames 3 --quiet");
    CHECK(scene.code == 0);
    CHECK(fs::exists(place / "out/sheet/sheet.png"));
    // The next run into that folder takes it away: it would show another run.
    CHECK(place.run("simulate --scene sheet.toml --frames 2 --quiet").code == 0);
    CHECK_FALSE(fs::exists(place / "out/sheet/sheet.png"));
}

TEST_CASE("two runs stand beside each other in one movie", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate --scene sheet.toml --out a --quiet --frames 6").code == 0);
    REQUIRE(
        place.run("simulate --scene sheet.toml --out b --quiet --frames 9 --set cloth.resolution=8").code ==
        0);
    const Outcome outcome = place.run(
        "compare-video a b --file ab.mp4 --size 128x96 --labels fine,coarse --shade gap --caption --quiet");
    CHECK(outcome.code == 0);
    CHECK(outcome.err.empty());
    CHECK_THAT(outcome.out, Contains("6 frames of 258x96 at 60 frames/s: ab.mp4"));
    CHECK(fs::exists(place / "ab.mp4"));
    CHECK_FALSE(fs::exists(place / "a/a.mp4"));
    check_refusal(place.run("compare-video a nowhere --file x.mp4"), 1, {"nowhere: holds no run"});
    CHECK_FALSE(fs::exists(place / "x.mp4"));
}

TEST_CASE("pictures that know the whole run are the same at once and redrawn, whole and in parts", "[cli]") {
    const Workplace place;
    const std::string wanted =
        "--shade stretch --curves energy,gap,iterations --caption --wireframe --motion-blur 2 --size 320x240 "
        "--set 'camera.frame=\"auto\"' --set camera.turntable=30 --quiet ";
    REQUIRE(place.run("--scene sheet.toml --frames 6 --out a " + wanted).code == 0);
    CHECK(fs::exists(place / "a/sheet.mp4"));
    const auto report = report_of(place, "a");
    CHECK(report["outcome"] == "complete");
    CHECK(report["output"]["images"] == 6);
    REQUIRE(place.run("simulate --scene sheet.toml --frames 6 --out b --quiet").code == 0);
    REQUIRE(place.run("render --out b --frames 3:5 " + wanted).code == 0);
    for (const char* name : {"frames/frame_000003.png", "frames/frame_000004.png"})
        CHECK(slurp(place / "a" / name) == slurp(place / "b" / name));
    // And differ from plain ones, which are as ever.
    REQUIRE(place.run("render --out b --frames 3:5 --size 320x240 --quiet").code == 0);
    CHECK(slurp(place / "a/frames/frame_000003.png") != slurp(place / "b/frames/frame_000003.png"));
}

TEST_CASE("a run that diverges is still drawn up to its last good frame, with its colours", "[cli]") {
    const Workplace place;
    const Outcome outcome =
        place.run(base + "--frames 30 --set simulation.gravity=[0,-1e307,0] --shade stretch");
    CHECK(outcome.code == 4);
    const auto run = pipeline::RunFolder::open(place / "o");
    CHECK_FALSE(run.kept_states().empty());
    CHECK(run.kept_images() == run.kept_states());
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
}

TEST_CASE("an exported frame has every digit of its state", "[cli]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 4").code == 0);
    const State state = pipeline::read_state(place / "o/states/state_000003.bin");
    const auto export_as = [&](const std::string& format) {
        const Outcome outcome =
            place.run("export --out o --frame 3 --format " + format + " --file m." + format);
        CHECK(outcome.code == 0);
        CHECK_THAT(outcome.out, Contains("m." + format));
        return slurp(place / ("m." + format));
    };
    SECTION("OBJ") {
        std::istringstream lines(export_as("obj"));
        std::string kind, x, y, z;
        int vertices = 0, faces = 0;
        for (std::string line; std::getline(lines, line);) {
            std::istringstream words(line);
            words >> kind >> x >> y >> z;
            if (kind == "v") {
                const double values[] = {std::stod(x), std::stod(y), std::stod(z)};
                CHECK(std::memcmp(values, state.positions.data() + 3 * vertices, sizeof values) == 0);
                ++vertices;
            }
            if (kind == "f") ++faces;
        }
        CHECK(vertices == 144);
        CHECK(faces == 242);
    }
    SECTION("PLY") {
        std::istringstream text(export_as("ply"));
        std::string line;
        while (std::getline(text, line) && line != "end_header") {
        }
        for (int i = 0; i < 144; ++i) {
            std::string x, y, z;
            text >> x >> y >> z;
            const double values[] = {std::stod(x), std::stod(y), std::stod(z)};
            CHECK(std::memcmp(values, state.positions.data() + 3 * i, sizeof values) == 0);
        }
    }
    SECTION("a frame that is not kept") {
        check_refusal(place.run("export --out o --frame 4 --format obj --file m.obj"), 2,
                      {"--frame 4: its state is not kept in o", "4 frames from 0 to 3"});
        CHECK_FALSE(fs::exists(place / "m.obj"));
    }
}

TEST_CASE("progress goes to standard error and --quiet silences it", "[cli]") {
    const Workplace place;
    const Outcome quiet = place.run(base + "--frames 3");
    CHECK(quiet.err.empty());
    CHECK_THAT(quiet.out, Contains("3 frames"));
    // A terminal, made by script(1) where the system has pseudo-terminals, shows the bar.
    if (std::system("script -qec true /dev/null >/dev/null 2>&1 </dev/null") == 0) {
        const std::string command =
            "cd '" + place.path().string() + "' && script -qec \"'" + RENDER_CLOTH_BINARY +
            "' --scene sheet.toml --frames 12 --out o\" /dev/null >tty.txt 2>&1 </dev/null";
        CHECK(std::system(command.c_str()) == 0);
        CHECK_THAT(slurp(place / "tty.txt"),
                   Contains("12/12 frames") && Contains("frames/s") && Contains(" left"));
    }
}

TEST_CASE("goldens: blessed, compared, and a change is told by exit code 6", "[cli]") {
    const Workplace place;
    check_refusal(place.run("compare sheet.toml --golden g --out o"), 6,
                  {"is missing", "render_cloth bless sheet"});
    const Outcome blessed = place.run("bless sheet.toml --golden g --out o");
    CHECK(blessed.code == 0);
    CHECK_THAT(blessed.out, Contains("nothing to compare with") && Contains("goldens written to g/sheet"));
    const Outcome same = place.run("compare sheet.toml --golden g --out o");
    CHECK(same.code == 0);
    CHECK_THAT(same.out,
               Contains("sheet: agrees (same build, states exact, same renderer, pictures exact)") &&
                   Contains("report: o/golden.html"));
    const Outcome other =
        place.run("compare sheet.toml --golden g --out o --set simulation.gravity=[0,-9.8,0]");
    CHECK(other.code == 6);
    CHECK_THAT(other.out, Contains("DIFFERS") && Contains("sheet: differs"));
    CHECK_THAT(other.err, Contains("render_cloth: sheet differs from its goldens, see o/golden.html") &&
                              Contains("render_cloth bless sheet"));
    const Outcome again = place.run("bless sheet.toml --golden g --out o");
    CHECK_THAT(again.out, Contains("old against new:") && Contains("sheet: agrees"));
}

TEST_CASE("the physics is checked by name, with parameters, a table and plots", "[cli]") {
    const Workplace place;
    const Outcome one = place.run("validate cantilever --gamma 0.5 --resolution 16");
    CHECK(one.code == 0);
    CHECK_THAT(one.out, Contains("measured") && Contains("H/W at Gamma 0.5") && Contains("good") &&
                            Contains("heavy elastica"));
    const Outcome plotted = place.run("validate space_order --plots p --markdown");
    CHECK(plotted.code == 0);
    CHECK_THAT(plotted.out, Contains("| check | quantity |") && Contains("| good |"));
    CHECK(place.files("p") == std::vector<std::string>{"space_order.svg"});
    check_refusal(place.run("validate cantilver"), 2, {"unknown check; known: cantilever, "});
    check_refusal(place.run("validate drape --gamma 3"), 2, {"validate drape: has no --gamma"});
    check_refusal(place.run("validate --gamma 3"), 2, {"--gamma: give the check that it belongs to"});
    check_refusal(place.run("validate cantilever --gamma -1"), 2,
                  {"--gamma -1: give a number, 0.001 … 100000"});
    check_refusal(place.run("validate cantilever --resolution 2"), 2, {"give a whole number, 4 … 2000"});
    check_refusal(place.run("validate drape --fabric tweed"), 2, {"--fabric tweed: unknown"});
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

TEST_CASE("a run whose step does not converge stops with exit code 4 and says where", "[cli]") {
    const Workplace place;
    // Pulled beyond the strain limit that nothing may pass.
    spit(place / "torn.toml", R"(
version = 1
[simulation]
integrator = "implicit_euler"
retries = 1
[[cloth]]
size = [0.1, 0.2]
resolution = [3, 5]
fabric = "cotton"
[[pin]]
edge = "top"
[[pin]]
edge = "bottom"
path = [{ time = 0.0 }, { time = 0.5, translate = [0.0, -0.1, 0.0] }]
[output]
size = [64, 48]
)");
    CHECK_THAT(message_of_stop(place, "torn.toml"), Contains("did not converge, not even cut into 2 parts") &&
                                                        Contains("farthest from balance is vertex"));
}

TEST_CASE("cloth pressed where there is no room for it stops with exit code 4 and says so", "[cli]") {
    const Workplace place;
    spit(place / "press.toml", R"(
version = 1
[simulation]
integrator = "implicit_euler"
contact = "barrier"
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
    CHECK_THAT(message_of_stop(place, "press.toml"),
               Contains("press: frame ") && Contains("even cut into 2 parts") &&
                   Contains("pins or colliders cannot get to where the scene wants them") &&
                   !Contains("residual"));
}

TEST_CASE("the program tells of itself", "[cli]") {
    const Workplace place;
    const Outcome version = place.run("--version");
    CHECK(version.code == 0);
    for (const char* part :
         {"render_cloth ", "compiler: ", "build: ", "renderer: ", "encoder: ffmpeg version"})
        CHECK_THAT(version.out, Contains(part));
    CHECK_THAT(version.out, !Contains("not available"));
    const Outcome help = place.run("--help");
    CHECK(help.code == 0);
    for (const char* part : {"--scene", "--frames", "--set", "--no-video", "simulate", "render", "export",
                             "compare", "bless", "list"})
        CHECK_THAT(help.out, Contains(part));
    for (const char* verb : {"run", "simulate", "render", "encode", "export", "compare", "bless", "list",
                             "sheet", "compare-video"})
        CHECK(place.run(std::string(verb) + " --help").code == 0);
    const Outcome list = place.run("list");
    CHECK(list.code == 0);
    const Outcome keys = place.run("list keys");
    CHECK(keys.code == 0);
    CHECK_THAT(keys.out, Contains("[[collider]]") && Contains("  contact_offset     number, ≥ 0 [m]"));
    for (const char* scene : {"seed_sheet", "seed_kick", "seed_drag", "drape_sphere", "hanging_sheet"})
        CHECK_THAT(list.out, Contains(scene));
    CHECK(place.run("list scenes").out == list.out);
    const Outcome fabrics = place.run("list fabrics");
    CHECK(fabrics.code == 0);
    for (const char* part : {"[g/m²]", "[N/m]", "[µN m]", "cotton", "paper", "--sources"})
        CHECK_THAT(fabrics.out, Contains(part));
    const Outcome silk = place.run("list fabrics silk");
    CHECK(silk.code == 0);
    CHECK_THAT(silk.out,
               Contains("density") && Contains("0.082 kg/m²") && Contains("19 momme") && !Contains("wool:"));
    const Outcome sources = place.run("list fabrics --sources");
    CHECK_THAT(sources.out, Contains("Kawabata") && Contains("wool:") && Contains("[µN m]"));
    CHECK(place.files() == std::vector<std::string>{"sheet.toml"});
}
