// Ctrl-C, TERM and HUP: what each verb does, and that nothing outlives it. FFmpegs that fail, hang and lie.

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

bool alive(pid_t process) {
    return kill(process, 0) == 0;
}

/// The process that a stand-in for ffmpeg told of.
pid_t told_of(const Workplace& place) {
    REQUIRE(comes_true([&] { return slurp(place / "pid").ends_with('\n'); }));
    return std::stoi(slurp(place / "pid"));
}

void no_parts(const Workplace& place) {
    for (const std::string& name : place.files()) {
        CHECK_THAT(name, !Catch::EndsWith(".part"));
        CHECK_THAT(name, !Catch::EndsWith(".lock"));
    }
}

double seconds_since(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

constexpr double soon = 10;  // [s], on a machine that has other work too

}  // namespace

TEST_CASE("a signal ends a step in the middle, and the frames before it are kept", "[cli][signals]") {
    const Workplace place;
    const int signal = GENERATE(SIGINT, SIGTERM, SIGHUP);
    // A frame is one step of many iterations, each of them a matter of a second.
    Started run(
        place,
        "simulate --scene sheet.toml --out o --quiet --frames 50 --set simulation.contact=barrier "
        "--set simulation.integrator=implicit_euler --set simulation.time_step=0.2 "
        "--set simulation.frame_rate=5 --set cloth.resolution=150 --set simulation.newton_tolerance=1e-12");
    REQUIRE(comes_true([&] { return fs::exists(place / "o/states/state_000000.bin"); }));
    std::this_thread::sleep_for(std::chrono::milliseconds(500));
    run.send(signal);
    const Outcome outcome = run.wait(soon);
    CHECK(outcome.code == 130);
    CHECK_FALSE(fs::exists(place / "o/states/state_000001.bin"));
    CHECK_THAT(outcome.err, Contains("render_cloth: interrupted: "));
    CHECK(report_of(place, "o")["outcome"] == "interrupted");
    no_parts(place);
}

TEST_CASE("verbs that keep nothing end at once", "[cli][signals]") {
    const Workplace place;
    REQUIRE(place.run("bless sheet.toml --golden g --out p").code == 0);
    REQUIRE(place.run("simulate " + base + "--frames 500 --set cloth.resolution=4").code == 0);
    const auto before = place.files();
    spit(place / "sheet.toml", slurp(place / "sheet.toml") + "\n");
    const std::string verb = GENERATE("validate drape --quiet --plots v",
                                      "compare sheet.toml --golden g --out q --set simulation.time_step=1e-6",
                                      "sheet", "compare-video o o --file ab.mp4 --size 640x480 --quiet",
                                      "export --out o --frames 0:500 --file m.obj --quiet");
    const std::string arguments =
        verb.starts_with("sheet")
            ? "sheet --out o --count 500 --columns 40 --size 640x480 --motion-blur 64 --quiet"
            : verb;
    Started run(place, arguments);
    std::this_thread::sleep_for(std::chrono::milliseconds(verb.starts_with("export") ? 60 : 500));
    const auto start = std::chrono::steady_clock::now();
    run.send(SIGTERM);
    const Outcome outcome = run.wait(soon);
    INFO(arguments);
    if (!verb.starts_with("export") || outcome.code != 0) {
        CHECK(outcome.code == 130);
        CHECK(outcome.err == "render_cloth: interrupted\n");
        CHECK(seconds_since(start) < soon);
        CHECK(place.files() == before);
    }
    no_parts(place);
}

TEST_CASE("a doubled signal counts once, and a later one ends the program at once", "[cli][signals]") {
    const Workplace place;
    SECTION("doubled") {
        Started run(place, base + "--frames 5000");
        REQUIRE(comes_true([&] { return fs::exists(place / "o/frames/frame_000004.png"); }));
        run.send(SIGINT);
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        run.send(SIGTERM);
        const Outcome outcome = run.wait(soon);
        CHECK(outcome.code == 130);
        CHECK_THAT(outcome.err,
                   Contains("interrupted: ") && Contains(" are kept in o; a movie of them: render_cloth "));
        CHECK(report_of(place, "o")["outcome"] == "interrupted");
    }
    SECTION("later") {
        // A picture that is the mean of many large ones: the program looks at its request between pictures.
        REQUIRE(place.run(base + "--frames 2").code == 0);
        fs::remove(place / "o/frames/frame_000000.png");
        Started run(place, "render --out o --motion-blur 64 --size 4096x2304 --quiet");
        REQUIRE(comes_true([&] { return fs::exists(place / "o/frames/frame_000000.png"); }));
        run.send(SIGINT);
        CHECK(run.wait(0.7).code == -1);
        run.send(SIGINT);
        const Outcome outcome = run.wait(soon);
        CHECK(outcome.code == 130);
        CHECK(outcome.err == "render_cloth: interrupted\n");
    }
    no_parts(place);
}

TEST_CASE("a signal that the program was started to ignore is ignored", "[cli][signals]") {
    const Workplace place;
    ::signal(SIGHUP, SIG_IGN);
    Started run(place, base + "--frames 40");
    ::signal(SIGHUP, SIG_DFL);
    REQUIRE(comes_true([&] { return fs::exists(place / "o/states/state_000001.bin"); }));
    run.send(SIGHUP);
    CHECK(run.wait().code == 0);
}

TEST_CASE("an ffmpeg that hangs holds nobody up, and ends with the program", "[cli][signals]") {
    const Workplace place;
    struct Case {
        const char *hang, *verb;
        int signal;
    };
    const char* const deaf = "echo $$ >pid; exec sleep 1000";
    const char* const silent = "echo $$ >pid; cat >/dev/null; exec sleep 1000";
    const char* const closed = "exec <&-; echo $$ >pid; exec sleep 1000";
    const auto [hang, verb, signal] = GENERATE_COPY(
        Case{deaf, "--scene sheet.toml --frames 20 --size 320x240 --out p --quiet", SIGINT},
        Case{silent, "render --out o --quiet", SIGTERM}, Case{closed, "encode --out o --quiet", SIGINT},
        Case{deaf, "compare-video o o --file ab.mp4 --quiet", SIGHUP},
        Case{silent, "encode --out o --quiet", SIGKILL});
    REQUIRE(place.run(base + "--frames 4 --no-video").code == 0);
    place.stand_in_for_ffmpeg(hang);
    INFO(hang << ", " << verb << ", signal " << signal);
    Started run(place, verb);
    const pid_t child = told_of(place);
    CHECK(alive(child));
    run.send(signal);
    const Outcome outcome = run.wait(soon);
    CHECK(comes_true([&] { return !alive(child); }, soon));
    if (signal == SIGKILL) {
        CHECK(outcome.code == 128 + SIGKILL);
        return;
    }
    CHECK(outcome.code == 130);
    CHECK_THAT(outcome.err, Contains("render_cloth: interrupted"));
    CHECK(std::count(outcome.err.begin(), outcome.err.end(), '\n') == 1);
    no_parts(place);
    CHECK_FALSE(fs::exists(place / "p/sheet.mp4"));
}

TEST_CASE("an ffmpeg that lies is found out: the movie is read back", "[cli][signals]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 8").code == 0);
    const std::string movie = slurp(place / "o/sheet.mp4");
    fs::remove(place / "o/sheet.mp4");
    spit(place / "real.mp4", movie);
    // The last argument is the movie. Reading back goes to the true one.
    const std::string honest =
        "PATH=${PATH#*:}; case \"$*\" in *rawvideo*) ;; *) exec ffmpeg \"$@\";; esac; for last; do :; "
        "done; last=${last#file:}; cat >/dev/null; ";
    struct Lie {
        std::string script, part;
    };
    const Lie lie = GENERATE(Lie{"echo no movie >$last", "ffmpeg failed on o/sheet.mp4"},
                             Lie{": >$last", "ffmpeg failed on o/sheet.mp4"},
                             Lie{"rm $last", "ffmpeg failed on o/sheet.mp4"},
                             Lie{"head -c 1500 real.mp4 >$last", "ffmpeg failed on o/sheet.mp4"},
                             Lie{"ffmpeg -loglevel error -i real.mp4 -c copy -frames:v 5 -f mp4 -y $last",
                                 "it wrote 5 frames of 8"});
    place.stand_in_for_ffmpeg(honest + lie.script);
    INFO(lie.script);
    check_refusal(place.run("encode --out o --quiet", "PATH=$PWD/bin:$PATH"), 7, {lie.part});
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    no_parts(place);
}

TEST_CASE("an interrupted run gives a movie of what it has, and each command names the next",
          "[cli][signals]") {
    const Workplace place;
    const auto frames_of_movie = [&](const std::string& name) {
        const std::string command =
            "test \"$(ffprobe -v error -count_packets -show_entries stream=nb_read_packets -of csv=p=0 '" +
            (place / name).string() + "')\" = ";
        for (int n = 1; n < 100; ++n)
            if (std::system((command + std::to_string(n)).c_str()) == 0) return n;
        return 0;
    };
    REQUIRE(place.run("simulate " + base + "--frames 6").code == 0);
    // As if it had been stopped at its fourth frame.
    for (const char* state : {"4", "5"})
        fs::remove(place / ("o/states/state_00000" + std::string(state) + ".bin"));
    check_refusal(
        place.run("encode --out o --quiet"), 1,
        {"o: has pictures of 0 of its 4 frames: no movie; draw the rest with render_cloth render --out o"});
    REQUIRE(place.run("render --out o --quiet").code == 0);
    CHECK(frames_of_movie("o/sheet.mp4") == 4);
    fs::remove(place / "o/sheet.mp4");
    REQUIRE(place.run("encode --out o --quiet").code == 0);
    CHECK(frames_of_movie("o/sheet.mp4") == 4);

    // A gap is no end. The picture that is still there belongs to nothing.
    fs::rename(place / "o/states/state_000002.bin", place / "aside");
    fs::remove(place / "o/sheet.mp4");
    const std::vector<std::string> gap = {
        "the state of frame 2 is missing: no movie; simulate again with render_cloth "
        "simulate --scene o/scene.toml --out NEW_FOLDER"};
    check_refusal(place.run("encode --out o --quiet"), 1, gap);
    check_refusal(place.run("render --out o --quiet"), 1, gap);
    CHECK(place.run("render --out o --quiet --frames 0:2").code == 0);
    CHECK_FALSE(fs::exists(place / "o/sheet.mp4"));
    CHECK(place.run("simulate --scene o/scene.toml --out again --frames 2 --quiet").code ==
          0);  // the command works
    fs::rename(place / "aside", place / "o/states/state_000002.bin");
    fs::copy(place / "o/frames/frame_000000.png", place / "o/frames/frame_000004.png");
    check_refusal(place.run("encode --out o --quiet"), 1,
                  {"o/frames/frame_000004.png has no state: no movie; remove it"});
}
