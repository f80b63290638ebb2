// What a run makes, and that it makes the same again.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <utility>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("a run leaves states, pictures, a movie and a report, and says so in its last line", "[cli]") {
    const Workplace place;
    const Outcome outcome = place.run("--scene sheet.toml --frames 5");
    CHECK(outcome.code == 0);
    for (const char* part : {"sheet: 5 frames, 5 pictures of 64x48, a movie at 60 frames/s", "simulate ",
                             "wall ", ": out/sheet/sheet.mp4\n"})
        CHECK_THAT(outcome.out, Contains(part));
    CHECK(std::count(outcome.out.begin(), outcome.out.end(), '\n') == 1);
    std::vector<std::string> expected = {"certificate.json",     "ledger.jsonl",       "report.html",
                                         "report.json",          "scene.toml",         "sheet.mp4",
                                         "states/manifest.json", "states/topology.bin"};
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

TEST_CASE("a run that diverges is still drawn up to its last good frame, with its colours", "[cli]") {
    const Workplace place;
    const Outcome outcome =
        place.run(base +
                  "--frames 30 --set simulation.gravity=[0,1e4,0] --set simulation.frame_rate=0.01 "
                  "--set simulation.time_step=100 --set simulation.integrator=implicit_euler --set "
                  "simulation.contact=barrier --shade stretch");
    CHECK(outcome.code == 4);
    const auto run = pipeline::RunFolder::open(place / "o");
    CHECK_FALSE(run.kept_states().empty());
    CHECK(run.kept_images() == run.kept_states());
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
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
