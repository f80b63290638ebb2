// Nothing finished is lost, and nothing is made twice: runs that go on, change, branch, and prove themselves.

#include <sys/stat.h>
#include <utime.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// What a run makes, name and bytes: its states, pictures and movie.
std::vector<std::string> made(const Workplace& place, const std::string& out) {
    std::vector<std::string> all;
    for (const std::string& name : place.files(out))
        if (name.ends_with(".bin") || name.ends_with(".png") || name.ends_with(".mp4"))
            all.push_back(name + "\n" + slurp(place / out / name));
    return all;
}

/// Which inode a file is: a new one where it was written again.
ino_t file_id(const fs::path& path) {
    struct stat what = {};
    REQUIRE(::stat(path.c_str(), &what) == 0);
    return what.st_ino;
}

std::string state(int frame) {
    return "/states/state_00000" + std::to_string(frame) + ".bin";
}
std::string picture(int frame) {
    return "/frames/frame_00000" + std::to_string(frame) + ".png";
}

}  // namespace

TEST_CASE("the same command again does nothing, and a longer one extends to the bits of one run",
          "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 4").code == 0);
    const auto before = made(place, "o");
    const ino_t first = file_id(place / ("o" + state(1))), drawn = file_id(place / ("o" + picture(1)));
    const Outcome again = place.run(base + "--frames 4");
    CHECK(again.code == 0);
    CHECK_THAT(again.out, Contains("sheet: nothing to do, all of 4 frames is kept"));
    CHECK(again.err.empty());
    CHECK(made(place, "o") == before);

    const Outcome longer = place.run(base + "--frames 7");
    CHECK_THAT(longer.out, Contains("sheet: 3 frames after 4, 3 pictures"));
    CHECK(longer.err == "render_cloth: note: 7 frames instead of 4: the movie in o replaced\n");
    CHECK(file_id(place / ("o" + state(1))) == first);
    CHECK(file_id(place / ("o" + picture(1))) == drawn);
    REQUIRE(place.run("--scene sheet.toml --out p --quiet --frames 7").code == 0);
    CHECK(made(place, "o") == made(place, "p"));
    CHECK(hashes(report_of(place, "o")) == hashes(report_of(place, "p")));
    CHECK(report_of(place, "o")["kept"]["states"] == 4);

    // A shorter one is a part of it, and loses nothing: the rest is there for a longer one.
    CHECK(place.run(base + "--frames 3").code == 0);
    CHECK(pipeline::RunFolder::open(place / "o").kept_states().size() == 3);
    CHECK(fs::exists(place / ("o" + state(6))));
    CHECK_THAT(place.run(base + "--frames 7").out, Contains("a movie") && !Contains("pictures"));
    CHECK(made(place, "o") == made(place, "p"));
}

TEST_CASE("states alone, then pictures, then a movie are made of what is there", "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 3").code == 0);
    const ino_t first = file_id(place / ("o" + state(1)));
    CHECK_THAT(place.run(base + "--frames 3 --no-video").out, Contains("sheet: 3 pictures of 64x48 ("));
    CHECK_THAT(place.run(base + "--frames 3").out, Contains("sheet: a movie at 60 frames/s"));
    CHECK_THAT(place.run("simulate " + base + "--frames 3").out, Contains("nothing to do"));
    CHECK(fs::exists(place / "o/sheet.mp4"));
    CHECK(file_id(place / ("o" + state(1))) == first);
}

TEST_CASE("what changes is made anew, what does not is kept, and the reasons are told before",
          "[cli][continued]") {
    const Workplace place;
    const std::string events = " --set 'event=[]'";
    REQUIRE(place.run(base + "--frames 6").code == 0);
    const auto plain = made(place, "o");
    const auto explained = [&](const std::string& more) {
        const Outcome outcome = place.run(base + "--frames 6 --explain " + more);
        CHECK(outcome.code == 0);
        CHECK(outcome.err.empty());
        CHECK(made(place, "o") == plain);  // it only tells
        return outcome.out;
    };
    CHECK(explained("") == "states: 6 kept\npictures: 6 kept\nmovie: kept\n");
    const std::string camera = "--set camera.position=[1,1,2] --set cloth.color=\"#112233\" ";
    CHECK_THAT(
        explained(camera),
        Contains("states: 6 kept\npictures: 0 kept, 6 to draw (camera.position, cloth[0].color changed: "
                 "6)\nmovie: to encode (camera.position, cloth[0].color changed)\n"
                 "camera.position, cloth[0].color changed: 6 pictures, the movie in o replaced\n"));
    CHECK_THAT(explained("--set collider.friction=0.9"),
               Contains("states: 0 kept, 6 to simulate (collider[0].friction changed: 6)\n"));
    CHECK_THAT(explained("--set output.quality=30"),
               Contains("pictures: 6 kept\nmovie: to encode (its rate, quality or frames changed)"));
    CHECK_THAT(explained("--set expect.max_stretch=9"), Contains("pictures: 6 kept\nmovie: kept"));
    CHECK_THAT(explained("--fresh"), Contains("all is made anew"));

    const Outcome redrawn = place.run(base + "--frames 6 " + camera);
    CHECK(
        redrawn.err ==
        "render_cloth: note: camera.position, cloth[0].color changed: 6 pictures, the movie in o replaced\n");
    CHECK_THAT(redrawn.out, Contains("sheet: 6 pictures"));
    REQUIRE(place.run("--scene sheet.toml --out p --quiet --frames 6 " + camera).code == 0);
    CHECK(made(place, "o") == made(place, "p"));

    const Outcome fresh = place.run(base + "--frames 6 --fresh");
    CHECK_THAT(fresh.err, Contains("note: --fresh: 6 states and 6 pictures in o replaced"));
    CHECK_THAT(fresh.out, Contains("sheet: 6 frames, 6 pictures"));
    CHECK(made(place, "o") == plain);
}

TEST_CASE("an event changes states from its time on alone", "[cli][continued]") {
    const Workplace place;
    const std::string scene = slurp(place / "sheet.toml");
    REQUIRE(place.run(base + "--frames 6").code == 0);
    const ino_t before = file_id(place / ("o" + state(2))), drawn = file_id(place / ("o" + picture(2)));
    // It acts in the first step that starts then: the last one of frame 3, which ends at 0.05 s.
    spit(place / "sheet.toml", scene + "\n[[event]]\ntime = 0.045\ncollider = \"collider\"\n");
    const Outcome changed = place.run(base + "--frames 6");
    CHECK_THAT(changed.err, Contains("event[0] changed: 3 states, 3 pictures, the movie in o replaced"));
    CHECK_THAT(changed.out, Contains("sheet: 3 frames after 3"));
    CHECK(file_id(place / ("o" + state(2))) == before);
    CHECK(file_id(place / ("o" + picture(2))) == drawn);
    REQUIRE(place.run("--scene sheet.toml --out p --quiet --frames 6").code == 0);
    CHECK(made(place, "o") == made(place, "p"));
}

TEST_CASE("a damaged or cut state or picture is named, never drawn, and made again", "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 5").code == 0);
    const auto whole = made(place, "o");
    std::string damaged = slurp(place / ("o" + state(2)));
    damaged[damaged.size() / 2] = static_cast<char>(damaged[damaged.size() / 2] ^ 4);
    spit(place / ("o" + state(2)), damaged);
    spit(place / ("o" + state(3)), slurp(place / ("o" + state(3))).substr(0, 60));
    spit(place / ("o" + picture(4)), "half a pict");
    fs::remove(place / ("o" + state(0)));
    const Outcome mended = place.run(base + "--frames 5");
    CHECK(mended.code == 0);
    for (const std::string& file : {state(2), state(3), picture(4)})
        CHECK_THAT(mended.err, Contains("note: o" + file + ": damaged or cut short; it is made again"));
    CHECK_THAT(mended.out, Contains("sheet: 3 frames after 2, 1 picture of"));
    CHECK(made(place, "o") == whole);
}

TEST_CASE("runs with memory of what they met go on to the same bits", "[cli][continued]") {
    const Workplace place;
    const std::string kind =
        GENERATE("--set simulation.contact=barrier --set simulation.integrator=implicit_euler",
                 "--set simulation.contact=barrier --set simulation.integrator=tr_bdf2 --set "
                 "cloth.fabric.friction=0.4",
                 "--set simulation.contact=penalty --set simulation.integrator=implicit_euler",
                 "--set simulation.contact=penalty --set simulation.integrator=tr_bdf2 --set "
                 "cloth.fabric.bending_model=hinges --set cloth.fabric.bending=1e-3 --set "
                 "cloth.fabric.yield_curvature=1",
                 "--set simulation.integrator=implicit_midpoint --set cloth.velocity=[0,0,6]");
    INFO(kind);
    const std::string flags =
        " --quiet --set simulation.time_step=0.02 --set simulation.frame_rate=25 " + kind;
    REQUIRE(place.run("simulate --scene sheet.toml --out whole --frames 14" + flags).code == 0);
    for (const char* frames : {"3", "6", "7", "11", "14"})
        REQUIRE(place.run("simulate --scene sheet.toml --out parts --frames " + std::string(frames) + flags)
                    .code == 0);
    CHECK(made(place, "parts") == made(place, "whole"));
}

TEST_CASE("a branch goes on from a frame with other keys, and shares the past", "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 6").code == 0);
    const auto before = made(place, "o");
    const std::string branch =
        "resume o --from 3 --out b --quiet --frames 7 --set simulation.gravity=[0,9.81,0] ";
    const Outcome made_branch = place.run(branch);
    CHECK(made_branch.err.empty());
    CHECK_THAT(made_branch.out, Contains("sheet: 3 frames after 4, 4 pictures"));
    CHECK(made(place, "o") == before);
    for (int frame : {0, 2}) {
        CHECK(file_id(place / ("b" + state(frame))) == file_id(place / ("o" + state(frame))));
        CHECK(file_id(place / ("b" + picture(frame))) == file_id(place / ("o" + picture(frame))));
    }
    CHECK(slurp(place / ("b" + state(3))) == slurp(place / ("o" + state(3))));
    CHECK(slurp(place / ("b" + state(4))) != slurp(place / ("o" + state(4))));
    CHECK_THAT(place.run(branch).out, Contains("nothing to do"));
    // Part of it gone: it goes on by the same command.
    const auto whole = made(place, "b");
    for (int frame : {1, 3, 5}) fs::remove(place / ("b" + state(frame)));
    CHECK(place.run(branch).code == 0);
    CHECK(made(place, "b") == whole);
    CHECK(place.run("audit b --windows 4").code == 0);
    // Linked files are replaced, never written into.
    CHECK(place.run("resume o --from 3 --out b --quiet --set camera.position=[1,1,2]").code == 0);
    CHECK(made(place, "o") == before);

    check_refusal(place.run("resume o --from 6 --frames 9 --out c"), 2,
                  {"--from 6: its state is not kept in o", "6 frames from 0 to 5"});
    check_refusal(place.run("resume o --from 3 --frames 3 --out c"), 2,
                  {"--frames 3: a branch from frame 3"});
    check_refusal(place.run("resume o --from 3 --out o"), 2, {"--out o: is the run itself"});
    check_refusal(place.run("resume o --from 3 --out c --set cloth.resolution=9"), 3,
                  {"a branch of o cannot change the cloth's rest shape"});
    check_refusal(place.run("resume o --from 3 --out c --set simulation.frame_rate=30"), 3,
                  {"cannot change simulation.frame_rate"});
    check_refusal(place.run("resume nowhere --from 3 --out c"), 1, {"nowhere: holds no run"});
    CHECK_FALSE(fs::exists(place / "c"));
}

TEST_CASE("an audit finds the frames that are not what their past leads to, and who made them",
          "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 8").code == 0);
    const Outcome good = place.run("audit o --windows 2 --length 3 --seed 5");
    CHECK(good.code == 0);
    CHECK_THAT(good.out, Contains(" simulated again\n") && Contains("o: 8 states are whole, "));
    // A state that another computer got wrong, with everything about it in order.
    State state = pipeline::read_state(place / "o/states/state_000004.bin");
    state.positions[7] += 1e-15;
    const std::string file = pipeline::write_state(state, place / "o/states/state_000004.bin");
    std::string ledger = slurp(place / "o/ledger.jsonl");
    const std::size_t line = ledger.find("{\"state\":4,");
    const auto replace = [&](const std::string& key, const std::string& value) {
        const std::size_t begin = ledger.find("\"" + key + "\":\"", line) + key.size() + 4;
        ledger.replace(begin, ledger.find('"', begin) - begin, value);
    };
    replace("file", file);
    replace("host", "shaky");
    spit(place / "o/ledger.jsonl", ledger);
    const Outcome bad = place.run("audit o --windows 20 --length 3");
    CHECK(bad.code == 8);
    CHECK_THAT(bad.out,
               Contains("frame 4 is not what the frame before it leads to, made by the host shaky\n"));
    CHECK_THAT(bad.err, Contains("o: 1 of 8 states are bad, the first is that of frame 4"));
    spit(place / "o/states/state_000006.bin", "no state");
    CHECK_THAT(place.run("audit o").out,
               Contains("frame 6 is not the file that its line in the ledger tells of"));
    check_refusal(place.run("audit nowhere"), 1, {"nowhere: holds no run"});
}

TEST_CASE("limits of a scene are checked, and a broken one is named with its first frame",
          "[cli][continued]") {
    const Workplace place;
    const std::string limits = "--frames 8 --set expect.max_stretch=1.0001 --set expect.max_residual=0.5 ";
    const Outcome broken = place.run(base + limits);
    CHECK(broken.code == 8);
    CHECK_THAT(broken.err, Contains("sheet: expect.max_stretch = 1.0001 is broken: frame ") &&
                               Contains("; all is kept in o\n") && !Contains("max_residual"));
    CHECK(pipeline::RunFolder::open(place / "o").kept_images().size() == 8);
    CHECK(fs::exists(place / "o/sheet.mp4"));
    CHECK(report_of(place, "o")["outcome"] == "complete");
    const auto certificate = nlohmann::json::parse(slurp(place / "o/certificate.json"));
    CHECK(certificate["verdict"] == "broken");
    CHECK(certificate["expect"][0]["key"] == "max_stretch");
    CHECK(certificate["expect"][0]["holds"] == false);
    CHECK(certificate["expect"][1]["holds"] == true);
    CHECK(certificate["frames"].size() == 8);
    CHECK(certificate["frames"][3]["seconds"]["simulate"] > 0);
    CHECK(certificate["frames"][3]["seconds"]["draw"] > 0);
    // Nothing is made again for it, and it is still broken.
    CHECK(place.run(base + limits).code == 8);
    const Outcome wider = place.run(base + "--frames 8 --set expect.max_stretch=9");
    CHECK(wider.code == 0);
    CHECK_THAT(wider.out, Contains("nothing to do"));
    CHECK(nlohmann::json::parse(slurp(place / "o/certificate.json"))["verdict"] == "good");

    check_refusal(place.run(base + "--set expect.min_gap=0.0001"), 3,
                  {"expect.min_gap", "0.0001 m cannot hold: only contact = \"barrier\" knows of gaps"});
    check_refusal(place.run(base + "--set expect.min_gap=0.01 --set simulation.contact=barrier --set "
                                   "simulation.integrator=implicit_euler"),
                  3,
                  {"expect.min_gap", "0.01 m cannot hold: ", "simulation.contact_activation, 0.001 m here"});
}

TEST_CASE("garbage collection lists what no run needs, and removes it when told to", "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run("--scene sheet.toml --out out/a --quiet --frames 5").code == 0);
    REQUIRE(place.run("--scene sheet.toml --out out/b --quiet --frames 2").code == 0);
    CHECK_THAT(place.run("gc").out, Contains("nothing that no run needs in 2 runs"));
    REQUIRE(place.run("--scene sheet.toml --out out/a --quiet --frames 3").code == 0);
    spit(place / "out/a/states/state_000009.bin.77-0.part", "half");
    spit(place / "out/a/states/mine.bin", "mine");
    const auto before = place.files("out");
    const Outcome listed = place.run("gc out");
    CHECK(place.files("out") == before);
    for (const char* part :
         {"out/a/states/state_000003.bin", "behind the run's last frame", "out/a/frames/frame_000004.png",
          "left unfinished by a program that was killed", "5 files in 2 runs", "--yes removes them"})
        CHECK_THAT(listed.out, Contains(part));
    CHECK_THAT(place.run("gc out/a --yes").out, Contains("removed 5 files in 1 run"));
    CHECK(place.files("out").size() == before.size() - 5);
    CHECK(slurp(place / "out/a/states/mine.bin") == "mine");
    CHECK_THAT(place.run("--scene sheet.toml --out out/a --quiet --frames 3").out, Contains("nothing to do"));
    check_refusal(place.run("gc nowhere"), 1, {"nowhere: there is no run in it"});
}

TEST_CASE("runs of other programs and hosts, other clocks and lost states are told from good ones",
          "[cli][continued]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 3").code == 0);
    const auto whole = made(place, "o");
    const auto manifest = nlohmann::json::parse(slurp(place / "o/states/manifest.json"));
    const auto with = [&](const char* key, const nlohmann::json& value) {
        auto other = manifest;
        other[key] = value;
        spit(place / "o/states/manifest.json", other.dump());
    };
    SECTION("of a newer program") {
        with("format", 9);
        check_refusal(
            place.run(base + "--frames 3"), 1,
            {"o: made by a newer program: its states are of format 9, this one knows 2", "--fresh"});
        CHECK(made(place, "o") == whole);
        CHECK(place.run(base + "--frames 3 --fresh").code == 0);
    }
    SECTION("of another build") {
        with("build", "g++ 1.0");
        std::string ledger = slurp(place / "o/ledger.jsonl");
        for (std::size_t at = 0; (at = ledger.find("\"key\":\"", at)) != ledger.npos; at += 8)
            ledger[at + 7] = 'x';
        spit(place / "o/ledger.jsonl", ledger);
        CHECK_THAT(place.run(base + "--frames 3 --explain").out,
                   Contains("states: 0 kept, 3 to simulate (made by another build: 3)"));
        check_refusal(place.run("audit o"), 1, {"o: made by another build (g++ 1.0)"});
        CHECK(place.run(base + "--frames 3").err ==
              "render_cloth: note: made by another build: 3 states, 3 pictures, the movie in o replaced\n");
    }
    SECTION("a manifest without states") {
        fs::remove_all(place / "o/states");
        fs::create_directories(place / "o/states");
        spit(place / "o/states/manifest.json", manifest.dump());
        CHECK_THAT(place.run(base + "--frames 3 --explain").out,
                   Contains("states: 0 kept, 3 to simulate (gone: 3)\npictures: 3 kept"));
        CHECK_THAT(place.run(base + "--frames 3").out, Contains("sheet: 3 frames"));
    }
    SECTION("a run without a ledger") {
        fs::remove(place / "o/ledger.jsonl");
        CHECK_THAT(place.run(base + "--frames 3").err,
                   Contains("no record of how it was made: 3 states, 3 pictures, the movie in o replaced"));
    }
    SECTION("a clock that jumps") {
        for (const std::string& name : place.files("o")) {
            const time_t time = name.size() % 2 == 0 ? 0 : 4'000'000'000;
            const utimbuf times{time, time};
            REQUIRE(::utime((place / "o" / name).c_str(), &times) == 0);
        }
        CHECK_THAT(place.run(base + "--frames 3").out, Contains("nothing to do"));
    }
    SECTION("a lock of another host") {
        spit(place / "o/run.lock", "process 12 on the host loom, boot 0");
        check_refusal(
            place.run(base + "--frames 3"), 1,
            {"o: process 12 on the host loom may be writing there; if it is not, remove o/run.lock"});
        CHECK(fs::exists(place / "o/run.lock"));
        fs::remove(place / "o/run.lock");
    }
    SECTION("a folder that cannot be written") {
        check_refusal(place.run("--scene sheet.toml --frames 3 --quiet --out /proc/cloth"), 1,
                      {"cannot write to the folder /proc/cloth"});
    }
    CHECK(place.run(base + "--frames 3").code == 0);
    CHECK(made(place, "o") == whole);
}
