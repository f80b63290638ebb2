// Sweeps as a user meets them: run, interrupted, extended, changed, with cells that fail.

#include <signal.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "apps/workplace.h"
#include "pipeline/formats/npy.h"
#include "render/image/image.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

const std::string head =
    "version = 1\nscene = \"sheet.toml\"\n[set]\noutput.frames = 3\noutput.size = [32, 24]\n";

/// Rows of results.csv without the head, by cell.
std::map<std::string, std::vector<std::string>> rows(const Workplace& place) {
    std::map<std::string, std::vector<std::string>> table;
    std::istringstream lines(slurp(place / "o/results.csv"));
    std::string line;
    for (std::getline(lines, line); std::getline(lines, line);) {
        std::vector<std::string> fields;
        std::istringstream parts(line.substr(0, line.find('\r')));
        for (std::string field; std::getline(parts, field, ',');) fields.push_back(field);
        table[fields[0]] = fields;
    }
    return table;
}

/// Names of the cells of which cells.jsonl has a line, as often as it has one.
std::multiset<std::string> ended(const Workplace& place) {
    std::multiset<std::string> names;
    std::ifstream lines(place / "o/cells.jsonl");
    for (std::string line; std::getline(lines, line);)
        names.insert(nlohmann::json::parse(line).at("cell").get<std::string>());
    return names;
}

const std::string command = "sweep s.toml --out o --quiet --workers 2";

}  // namespace

TEST_CASE("a sweep leaves tables, a page and a movie, and does only what is missing", "[cli][sweep]") {
    const Workplace place;
    spit(place / "s.toml", head + "[grid]\ncollider.radius = [0.2, 0.25]\n");
    const Outcome dry = place.run("sweep s.toml --out o --dry-run");
    CHECK(dry.code == 0);
    CHECK_THAT(dry.out, Contains("radius=0.25  missing  collider.radius = 0.25") && Contains("2 cells"));
    CHECK_FALSE(fs::exists(place / "o"));

    const Outcome first = place.run(command);
    INFO(first.err);
    REQUIRE(first.code == 0);
    CHECK_THAT(first.out, Contains("s: 2 cells (wall ") && Contains("o/index.html"));
    for (const char* file :
         {"index.html", "results.csv", "results.npz", "sheet.mp4", "sweep.toml", "sweep.json",
          "cells/radius=0.2/states/state_000002.bin", "cells/radius=0.2/certificate.json",
          "cells/radius=0.2/frames/frame_000002.png", "logs/radius=0.2.log"})
        CHECK(fs::exists(place / "o" / file));
    const auto table = rows(place);
    REQUIRE(table.size() == 2);
    CHECK(table.at("radius=0.2")[1] == "done");
    CHECK(std::stod(table.at("radius=0.2")[4]) > 50);  // drape coefficient of a sheet that hardly fell
    CHECK(pipeline::NpzReader(place / "o/results.npz").read("lowest_point").numbers.size() == 2);
    CHECK_THAT(slurp(place / "o/index.html"),
               Contains("\"picture\":\"cells/radius=0.2/frames/frame_000002.png\""));

    SECTION("again: nothing is run") {
        const std::string movie = slurp(place / "o/sheet.mp4");
        CHECK_THAT(place.run(command).out, Contains("2 cells, 2 kept"));
        CHECK(ended(place).size() == 2);
        CHECK(slurp(place / "o/sheet.mp4") == movie);
    }
    SECTION("extended: the new cell is run") {
        spit(place / "s.toml", head + "[grid]\ncollider.radius = [0.15, 0.2, 0.25]\n");
        CHECK_THAT(place.run(command).out, Contains("3 cells, 2 kept"));
        CHECK(ended(place).size() == 3);
        CHECK(rows(place).size() == 3);
    }
    SECTION("more frames, and another cell less: states that are there are used again") {
        const auto state = fs::last_write_time(place / "o/cells/radius=0.2/states/state_000002.bin");
        spit(place / "s.toml", head + "simulation.drag = 0.0\n[grid]\ncollider.radius = [0.2]\n");
        std::string more = slurp(place / "s.toml");
        more.replace(more.find("frames = 3"), 10, "frames = 5");
        more.erase(more.find("simulation.drag = 0.0\n"), 22);
        spit(place / "s.toml", more);
        CHECK(place.run(command).code == 0);
        CHECK(fs::last_write_time(place / "o/cells/radius=0.2/states/state_000002.bin") == state);
        CHECK(fs::exists(place / "o/cells/radius=0.2/states/state_000004.bin"));
        CHECK(rows(place).size() == 1);
        CHECK(fs::exists(place / "o/cells/radius=0.25"));
    }
    SECTION("a cell whose folder is gone is run again") {
        fs::remove_all(place / "o/cells/radius=0.2");
        CHECK_THAT(place.run(command).out, Contains("2 cells, 1 kept"));
        CHECK(fs::exists(place / "o/cells/radius=0.2/certificate.json"));
    }
    SECTION("a plot of its results") {
        const Outcome plot = place.run(command + " --plot collider.radius:lowest_point p.svg");
        CHECK(plot.code == 0);
        CHECK_THAT(slurp(place / "p.svg"), Contains("lowest point [m]") && Contains("<circle"));
        check_refusal(place.run(command + " --plot collider.radius p.svg"), 2, {"give two columns"});
        check_refusal(place.run(command + " --plot collider.radiu:energy p.svg"), 2,
                      {"did you mean collider.radius?"});
    }
    SECTION("the folder is this sweep's alone") {
        fs::copy_file(place / "s.toml", place / "t.toml");
        check_refusal(place.run("sweep t.toml --out o"), 2,
                      {"--out o: holds the results of another sweep, s; give t a folder of its own"});
        check_refusal(place.run("sweep t.toml --out ."), 2, {"and no sweep; give a new or empty folder"});
        check_refusal(place.run("sweep t.toml --out s.toml"), 2, {"is a file; give a folder"});
    }
}

TEST_CASE("a bad sweep is refused before anything is written", "[cli][sweep]") {
    const Workplace place;
    spit(place / "s.toml", head + "[grid]\ncollider.radus = [0.2]\n");
    check_refusal(place.run(command), 3,
                  {"s.toml:7:10: cell radus=0.2: collider[0].radus: unknown key; did you "
                   "mean \"radius\""});
    spit(place / "s.toml", head + "[samples]\ncount = 40\ncollider.radius = { normal = [0.2, 0.2] }\n");
    check_refusal(place.run(command), 3, {"s.toml:8:10: cell s00", "collider[0].radius: is -", "; must be "});
    CHECK_FALSE(fs::exists(place / "o"));
    check_refusal(place.run("sweep nothing.toml"), 3, {"nothing.toml: there is no such file"});
    check_refusal(place.run("sweep s.toml --workers 0"), 2, {"--workers"});
}

TEST_CASE("a cell that fails keeps its reason and stops no other", "[cli][sweep]") {
    const Workplace place;
    std::string text = head;
    text.replace(text.find("frames = 3"), 10, "frames = 30");
    spit(place / "s.toml", text + R"([results]
pictures = "last"
[[list]]
name = "good"
collider.radius = 0.2
[[list]]
name = "bad"
simulation.gravity = [0, 1e4, 0]
simulation.frame_rate = 0.01
simulation.time_step = 100.0
simulation.integrator = "implicit_euler"
simulation.contact = "barrier"
)");
    const Outcome outcome = place.run(command);
    CHECK(outcome.code == 1);
    CHECK_THAT(outcome.err, Contains("note: cell bad: ") &&
                                Contains("1 of 2 cells failed, the first: bad: ") &&
                                Contains("--retry runs them again"));
    const auto table = rows(place);
    CHECK(table.at("good")[1] == "done");
    CHECK(table.at("bad")[1] == "failed");
    CHECK_THAT(slurp(place / "o/logs/bad.log"),
               Contains("cell bad of s.toml") && Contains("--set 'simulation.time_step=100.0'"));
    CHECK_THAT(slurp(place / "o/index.html"), Contains("\"status\":\"failed\""));
    CHECK(fs::exists(place / "o/cells/good/frames/frame_000029.png"));
    CHECK_FALSE(fs::exists(place / "o/cells/good/frames/frame_000028.png"));
    CHECK(ended(place).size() == 2);

    // Failed cells are left alone until they are asked for.
    CHECK(place.run(command).code == 1);
    CHECK(ended(place).size() == 2);
    CHECK(place.run(command + " --retry").code == 1);
    CHECK(ended(place).count("bad") == 2);
}

TEST_CASE("a sweep that is interrupted goes on", "[cli][sweep]") {
    const Workplace place;
    std::string text =
        head +
        "[grid]\ncollider.radius = { from = 0.2, to = 0.25, count = 6 }\n[results]\npictures = \"none\"\n";
    text.replace(text.find("frames = 3"), 10, "frames = 40");
    spit(place / "s.toml", text);
    SECTION("asked to stop") {
        Started sweep(place, command);
        REQUIRE(comes_true([&] { return !ended(place).empty(); }));
        sweep.send(SIGINT);
        const Outcome outcome = sweep.wait();
        CHECK(outcome.code == 130);
        CHECK_THAT(outcome.err, Contains("of 6 cells are done in o; the same command again continues"));
    }
    SECTION("killed") {
        Started sweep(place, command);
        REQUIRE(comes_true([&] { return !ended(place).empty(); }));
        sweep.send(SIGKILL);
        sweep.wait();
    }
    const auto before = ended(place);
    CHECK(before.size() < 6);
    REQUIRE(place.run(command).code == 0);
    const auto after = ended(place);
    CHECK(after.size() == 6);
    CHECK(std::set(after.begin(), after.end()).size() == 6);
    // The same bits as of a sweep that nobody disturbed.
    REQUIRE(place.run("sweep s.toml --out whole --quiet --workers 1").code == 0);
    for (const std::string& cell : after)
        CHECK(slurp(place / ("o/cells/" + cell + "/states/state_000039.bin")) ==
              slurp(place / ("whole/cells/" + cell + "/states/state_000039.bin")));
}

TEST_CASE("without a terminal a sweep tells how far it is in lines", "[cli][sweep]") {
    const Workplace place;
    spit(place / "s.toml", head + "[grid]\ncollider.radius = [0.2, 0.25]\n[results]\npictures = \"none\"\n");
    const Outcome outcome = place.run("sweep s.toml --out o");
    CHECK(outcome.code == 0);
    CHECK_THAT(outcome.err, Contains("0/2 cells done, ") &&
                                Contains("2/2 cells done, 0 running, 0 failed, ") &&
                                Contains(" cells/s, 0:00 left"));
    CHECK(outcome.err.find('\033') == std::string::npos);
}
