// Runs that are killed at any moment, or whose disk fills up, go on by the same command to the same bits.

#include <signal.h>

#include <catch2/catch.hpp>
#include <chrono>
#include <cstdlib>
#include <random>
#include <thread>

#include "apps/workplace.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
namespace fs = std::filesystem;

namespace {

const std::string flags =
    "--scene sheet.toml --quiet --frames 12 --set simulation.contact=barrier --set "
    "simulation.integrator=implicit_euler --set cloth.resolution=14 --out ";

void check_same(const Workplace& place, const std::string& out) {
    for (const std::string& name : place.files("whole")) {
        if (!name.ends_with(".bin") && !name.ends_with(".png") && !name.ends_with(".mp4")) continue;
        INFO(name);
        CHECK(slurp(place / out / name) == slurp(place / "whole" / name));
    }
}

}  // namespace

// CLOTH_KILLS=50 for more moments.
TEST_CASE("a run that is killed at any moment goes on to the same bits", "[cli][killed]") {
    const Workplace place;
    const auto begin = std::chrono::steady_clock::now();
    REQUIRE(place.run(flags + "whole").code == 0);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    const char* asked = std::getenv("CLOTH_KILLS");
    const int kills = asked != nullptr ? std::atoi(asked) : 3;
    std::mt19937 random(std::random_device{}());
    for (int k = 0; k < kills; ++k) {
        const double moment = std::uniform_real_distribution<double>(0.0, 1.1 * seconds)(random);
        INFO("killed after " << moment << " s, and again after a third of that");
        fs::remove_all(place / "o");
        for (const double pause : {moment, moment / 3}) {
            Started run(place, flags + "o");
            std::this_thread::sleep_for(std::chrono::duration<double>(pause));
            run.send(SIGKILL);
            run.wait();
        }
        const Outcome continued = place.run(flags + "o");
        INFO(continued.err);
        REQUIRE(continued.code == 0);
        check_same(place, "o");
        for (const std::string& name : place.files("o")) CHECK_FALSE(name.ends_with(".part"));
        REQUIRE_THAT(place.run(flags + "o").out, Catch::Contains("nothing to do"));
    }
}

TEST_CASE("a run whose files may grow no further says so, and goes on where they may", "[cli][killed]") {
    const Workplace place;
    REQUIRE(place.run(flags + "whole").code == 0);
    // Blocks of 512 bytes: enough for the first states, too few for the ledger or the movie of all.
    for (const char* limit : {"ulimit -f 9;", "ulimit -f 16;"}) {
        const Outcome full = place.run(flags + "o", limit);
        CHECK(full.code != 0);
        CHECK_THAT(full.err, Catch::Contains("File too large") || Catch::Contains("ffmpeg"));
        const Outcome continued = place.run(flags + "o");
        INFO(continued.err);
        CHECK(continued.code == 0);
        check_same(place, "o");
        fs::remove_all(place / "o");
    }
}

TEST_CASE("a run whose disk is full says so, and goes on to the same bits where there is room",
          "[cli][killed]") {
    const Workplace place;
    if (std::system("unshare -rm true 2>/dev/null") != 0) {
        WARN("no small file system can be made here (unshare -rm)");
        return;
    }
    REQUIRE(place.run(flags + "whole").code == 0);
    // A file system of so many kilobytes, which then grows.
    spit(place / "full.sh",
         "mkdir -p disk && mount -t tmpfs -o size=$1k tmpfs disk || exit 1\nshift\n"
         "\"$@\" 2>full.err; echo $? >full.code\n"
         "mount -o remount,size=64m disk\n"
         "\"$@\" 2>again.err; echo $? >again.code\n"
         "rm -rf kept && cp -r disk/run kept\n");
    for (const char* size : {"40", "80", "120"}) {
        INFO(size << " kB");
        // The shell runs it with the program and its flags behind the size.
        const Outcome shell = place.run(flags + "disk/run", std::string("unshare -rm sh ./full.sh ") + size);
        REQUIRE(shell.code == 0);
        CHECK(slurp(place / "full.code") != "0\n");
        INFO(slurp(place / "full.err"));
        CHECK_THAT(slurp(place / "full.err"),
                   Catch::Contains("No space left on device") || Catch::Contains("ffmpeg"));
        INFO(slurp(place / "again.err"));
        CHECK(slurp(place / "again.code") == "0\n");
        check_same(place, "kept");
    }
}
