// Nothing of the user's is lost, and nothing else is touched: folders, files, links and devices.

#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <cstdlib>
#include <nlohmann/json.hpp>

#include "apps/workplace.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run_folder.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Every file below a folder with what it holds.
std::vector<std::string> everything(const Workplace& place) {
    std::vector<std::string> all;
    for (const std::string& name : place.files()) all.push_back(name + "\n" + slurp(place / name));
    return all;
}

void no_parts(const Workplace& place) {
    for (const std::string& name : place.files()) {
        CHECK_THAT(name, !Catch::EndsWith(".part"));
        CHECK_THAT(name, !Catch::EndsWith(".lock"));
    }
}

}  // namespace

TEST_CASE("a folder with the user's files is refused by every verb that writes into one", "[cli][folders]") {
    const Workplace place;
    REQUIRE(place.run("bless sheet.toml --golden g --out o").code == 0);
    for (const char* folder : {"mine", "scene", "deep/states", "pictures/frames", "gold/sheet"})
        fs::create_directories(place / folder);
    spit(place / "mine/report.json", "mine");
    spit(place / "gold/sheet/frame_000000.png", "mine");
    spit(place / "scene/scene.toml", "# mine");
    spit(place / "deep/states/state_000000.bin", "mine");
    spit(place / "pictures/frames/frame_000000.png", "mine");
    fs::create_symlink("nowhere", place / "deep/states/link");
    const auto before = everything(place);
    struct Case {
        std::string arguments;
        const char* found;
    };
    for (const Case& folder : {Case{"mine", "report.json"}, Case{"scene", "scene.toml"},
                               Case{"deep", "states/"}, Case{"pictures", "frames/frame_000000.png"}}) {
        for (const char* verb :
             {"--scene sheet.toml --frames 2 --out ", "simulate --scene sheet.toml --frames 2 --out ",
              "sheet --scene sheet.toml --frames 2 --out ", "compare sheet.toml --golden g --out ",
              "bless sheet.toml --golden g --out ",
              "validate cantilever --gamma 0.5 --resolution 8 --plots "}) {
            INFO(verb << folder.arguments);
            check_refusal(place.run(verb + folder.arguments), 2,
                          {folder.arguments + ": holds ", folder.found, "and no run; give a new folder"});
            CHECK(everything(place) == before);
        }
    }
    for (const char* reader : {"render --out ", "encode --out ", "sheet --out "}) {
        check_refusal(place.run(reader + std::string("mine")), 1, {"mine: holds no run"});
        check_refusal(place.run(reader + std::string("scene")), 1,
                      {"holds no run (no states/manifest.json)"});
    }
    check_refusal(place.run("bless sheet.toml --golden gold --out o"), 2, {"gold/sheet holds no goldens"});
    CHECK(everything(place) == before);
}

TEST_CASE("a folder that holds the scene or a mesh of it is refused", "[cli][folders]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 2 --no-video").code == 0);
    spit(place / "o/square.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n");
    fs::create_directory_symlink("o", place / "link");
    const auto before = everything(place);
    check_refusal(place.run("--scene sheet.toml --out ."), 2, {"--out .: holds "});
    check_refusal(place.run("--scene o/scene.toml --out o"), 2, {"--out o: o/scene.toml is read from there"});
    check_refusal(place.run("--scene o/scene.toml --out link/"), 2, {"o/scene.toml is read from there"});
    check_refusal(place.run(base + "--set cloth.mesh=o/square.obj"), 2, {"o/square.obj is read from there"});
    CHECK(everything(place) == before);
    // Beside it there is room.
    CHECK(place.run("simulate --scene o/scene.toml --frames 2 --quiet --out p").code == 0);
}

TEST_CASE("a run that was killed at its very start leaves a folder of ours", "[cli][folders]") {
    const Workplace place;
    fs::create_directories(place / "o/states");
    spit(place / "o/run.lock", "process 1 on the host loom");
    spit(place / "o/states/manifest.json.77-0.part", "{\"for");
    CHECK(place.run("simulate " + base + "--frames 2").code == 0);
    no_parts(place);
    // A little later: the manifest and no more.
    const std::string manifest = slurp(place / "o/states/manifest.json");
    fs::remove_all(place / "o");
    fs::create_directories(place / "o/states");
    spit(place / "o/states/manifest.json", manifest);
    spit(place / "o/states/state_000001.bin.77-3.part", "half");
    check_refusal(place.run("render --out o"), 1, {"o: holds no run (no scene.toml)"});
    CHECK(place.run("simulate " + base + "--frames 2").code == 0);
    no_parts(place);
    // What only a page of ours lies in takes a run too.
    REQUIRE(place.run("bless sheet.toml --golden g --out page").code == 0);
    CHECK(place.run("simulate --scene sheet.toml --frames 1 --quiet --out page").code == 0);
    CHECK(fs::exists(place / "page/golden.html"));
}

TEST_CASE("a manifest that says what cannot be is refused, and leads nowhere else", "[cli][folders]") {
    const Workplace place;
    REQUIRE(place.run(base + "--frames 2").code == 0);
    spit(place / "victim.mp4", "mine");
    const auto good = nlohmann::json::parse(slurp(place / "o/states/manifest.json"));
    struct Case {
        const char *key, *value, *part;
    };
    for (const Case& c :
         {Case{"scene", "\"../victim\"", "scene must be a scene's name"},
          Case{"scene", "\"\"", "scene must be"}, Case{"scene", "7", "scene must be"},
          Case{"frames", "0", "frames must be 1 … "}, Case{"frames", "-4", "frames must be"},
          Case{"frames", "1e9", "frames must be"}, Case{"frames", "\"two\"", "frames must be"},
          Case{"format", "null", "format must be"}, Case{"build", "[]", "build must be"}}) {
        auto bad = good;
        bad[c.key] = nlohmann::json::parse(c.value);
        spit(place / "o/states/manifest.json", bad.dump());
        INFO(bad.dump());
        for (const char* verb : {"render --out o", "encode --out o", "export --out o --frame 0 --file m.obj"})
            check_refusal(place.run(verb), 1, {"o/states/manifest.json: damaged: ", c.part});
        check_refusal(place.run(base + "--frames 2"), 2, {"--out o: holds ", "and no run (", c.part});
    }
    for (const char* text : {"", "{", "[]", "{\"scene\": \"sheet\"}"}) {
        spit(place / "o/states/manifest.json", text);
        check_refusal(place.run("render --out o"), 1, {"manifest.json: damaged"});
    }
    auto other = good;
    other["format"] = 1;
    spit(place / "o/states/manifest.json", other.dump());
    check_refusal(place.run("render --out o"), 1, {"its states are of format 1, this program reads 2"});
    CHECK(place.run(base + "--frames 1 --no-video").code == 0);  // but it is a run, and may be replaced
    CHECK(slurp(place / "victim.mp4") == "mine");
}

TEST_CASE("one program writes into a folder at a time", "[cli][folders]") {
    const Workplace place;
    Started first(place, base + "--frames 5000");
    REQUIRE(comes_true([&] { return fs::exists(place / "o/frames/frame_000001.png"); }));
    for (const char* verb : {"--scene sheet.toml --frames 2 --out o --quiet", "render --out o --quiet",
                             "encode --out o --quiet"})
        check_refusal(place.run(verb), 1,
                      {"o: process " + std::to_string(first.pid()) + " on the host ", " is writing there"});
    CHECK(place.run("export --out o --frame 0 --file m.obj").code == 0);
    first.send(SIGKILL);
    CHECK(first.wait().code == 128 + SIGKILL);
    // The lock went with it.
    CHECK(place.run(base + "--frames 2").code == 0);
    no_parts(place);
    CHECK(pipeline::RunFolder::open(place / "o").kept_images() == std::vector<std::int64_t>{0, 1});
}

TEST_CASE("of two runs into one folder one is made, whole", "[cli][folders]") {
    const Workplace place;
    Started first(place, base + "--frames 12"), second(place, base + "--frames 12");
    const Outcome a = first.wait(), b = second.wait();
    CHECK(std::min(a.code, b.code) == 0);
    if (std::max(a.code, b.code) != 0) CHECK_THAT(a.err + b.err, Contains(" is writing there"));
    CHECK(pipeline::RunFolder::open(place / "o").kept_images().size() == 12);
    no_parts(place);
}

TEST_CASE("only regular files are replaced, devices and pipes are written to, links refused",
          "[cli][folders]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 2").code == 0);
    const std::string one = "export --out o --frame 0 --format obj --file ";
    REQUIRE(place.run(one + "m.obj").code == 0);
    const std::string mesh = slurp(place / "m.obj");
    spit(place / "mine", "mine");
    fs::create_symlink("mine", place / "link");
    fs::create_symlink("none", place / "dangling");
    for (const char* link : {"link", "dangling"}) {
        check_refusal(place.run(one + link), 1, {std::string("cannot write ") + link + ": is a link to "});
        check_refusal(place.run(std::string("sheet --out o --quiet --file ") + link), 1, {"is a link to "});
        check_refusal(
            place.run("compare-video o o --quiet --file ab.mp4", "ln -s " + std::string(link) + " ab.mp4;"),
            7, {"ab.mp4: is a link to "});
        fs::remove(place / "ab.mp4");
    }
    CHECK(slurp(place / "mine") == "mine");
    CHECK_FALSE(fs::exists(place / "none"));
    CHECK(place.run(one + "/dev/null").code == 0);
    CHECK(fs::is_character_file("/dev/null"));
    CHECK_THAT(place.run(one + "/dev/full").err, Contains("cannot write /dev/full: No space left on device"));

    REQUIRE(mkfifo((place / "pipe").c_str(), 0600) == 0);
    CHECK(place.run(one + "pipe", "(cat pipe >got &);").code == 0);
    CHECK(comes_true([&] { return slurp(place / "got") == mesh; }));
    CHECK(fs::is_fifo(place / "pipe"));
    CHECK(place.run("sheet --out o --quiet --file pipe", "(cat pipe >got.png &);").code == 0);
    CHECK(
        comes_true([&] { return slurp(place / "got.png").ends_with(std::string("IEND\xae\x42\x60\x82")); }));
    CHECK(fs::is_fifo(place / "pipe"));
    check_refusal(place.run(one + "o"), 2, {"--file o: is a folder; give a name in it, as in o/sheet.obj"});
    no_parts(place);

    // A link in the folder of a run leads nowhere either.
    fs::remove(place / "o/report.json");
    fs::create_symlink("../mine", place / "o/report.json");
    CHECK(place.run("render --out o --quiet").code == 1);
    CHECK(slurp(place / "mine") == "mine");
    CHECK(place.run(base + "--frames 1 --no-video").code == 0);  // a new run takes the link away
    CHECK(slurp(place / "mine") == "mine");
}

TEST_CASE("nobody else's file is taken for a temporary one", "[cli][folders]") {
    const Workplace place;
    REQUIRE(place.run("simulate " + base + "--frames 1").code == 0);
    spit(place / "victim", "mine");
    spit(place / "m.obj.part", "mine");
    fs::create_symlink("victim", place / "n.obj.part");
    CHECK(place.run("export --out o --frame 0 --file m.obj").code == 0);
    CHECK(place.run("export --out o --frame 0 --file n.obj").code == 0);
    CHECK(slurp(place / "m.obj.part") == "mine");
    CHECK(slurp(place / "victim") == "mine");
    CHECK(slurp(place / "n.obj") == slurp(place / "m.obj"));
}

TEST_CASE("what cannot be printed is told of, and names of any bytes do no harm", "[cli][folders]") {
    const Workplace place;
    const auto shell = [&](const std::string& line) {
        return std::system(
            ("cd '" + place.path().string() + "' && P='" + RENDER_CLOTH_BINARY + "'; " + line).c_str());
    };
    for (const char* verb :
         {"list", "list keys", "--help", "version", "simulate --scene sheet.toml --frames 1 --out o"}) {
        INFO(verb);
        CHECK(shell(std::string("$P ") + verb + " >/dev/full 2>err; test $? = 1") == 0);
        CHECK(slurp(place / "err") ==
              "render_cloth: cannot write to standard output: No space left on device\n");
        CHECK(shell(std::string("$P ") + verb + " >&- 2>err; test $? = 1") == 0);
        CHECK_THAT(slurp(place / "err"), Contains("cannot write to standard output: Bad file descriptor"));
    }
    CHECK(shell("$P list nothing >/dev/full 2>/dev/full; test $? = 2") == 0);
    CHECK(shell("$P list keys 2>err | head -n 1 >/dev/null") == 0);
    CHECK(slurp(place / "err").empty());
    // Progress that cannot be told ends no run; closed streams are not taken for files.
    CHECK(shell("$P --scene sheet.toml --frames 3 --out o 2>/dev/full >/dev/null") == 0);
    CHECK(shell("$P --scene sheet.toml --frames 3 --out o --quiet <&- >&- 2>&-; test $? = 1") == 0);
    CHECK(fs::exists(place / "o/sheet.mp4"));

    const std::string odd = "$(printf 'a\\377\\nb')";
    CHECK(shell("cp sheet.toml \"" + odd + ".toml\"; $P --scene \"" + odd +
                ".toml\" --frames 1 --out p 2>err >out; test $? = 3") == 0);
    CHECK_THAT(slurp(place / "err"), Contains("is not UTF-8 text: rename it"));
    CHECK_FALSE(fs::exists(place / "p"));
    CHECK(shell("$P --scene sheet.toml --frames 2 --out \"" + odd + "\" >out 2>err") == 0);
    CHECK(shell("$P --scene sheet.toml --frames 30 --set simulation.gravity=[0,1e4,0] --set "
                "simulation.frame_rate=0.01 "
                "--set simulation.time_step=100 --set simulation.integrator=implicit_euler --set "
                "simulation.contact=barrier --out \"" +
                odd + "\" --quiet >out 2>err; test $? = 4") == 0);
    CHECK(shell("$P compare-video \"" + odd + "\" \"" + odd + "\" --file \"" + odd +
                ".mp4\" --quiet >out 2>err") == 0);
    for (const char* words : {"", "list ", "simulate --scene ", "export --format ",
                              "--scene sheet.toml --set ", "--scene sheet.toml --shade "}) {
        INFO(words);
        CHECK(shell(std::string("$P ") + words + "\"" + odd +
                    "\" >out 2>err; c=$?; test $c -ge 1 && test $c -le 3") == 0);
        const std::string line = slurp(place / "err");
        CHECK(std::count(line.begin(), line.end(), '\n') == 1);
        CHECK_THAT(line, Catch::StartsWith("render_cloth: ") && !Contains("json") && !Contains("terminate"));
    }
}
