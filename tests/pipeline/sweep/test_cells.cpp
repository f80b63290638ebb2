// Sweep files: what cells they make, and what is refused before anything runs.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <set>

#include "pipeline/sweep/cells.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth::pipeline;
using Catch::Contains;

namespace {

const char* const scene = R"(version = 1
[[cloth]]
resolution = 4
fabric = "silk"
[[collider]]
center = [0, -3, 0]
[[collider]]
center = [0, -9, 0]
)";

/// A sweep of that scene, at /…/wind.toml, with `more` behind what every sweep has.
class Sweep {
  public:
    explicit Sweep(const std::string& more,
                   const std::string& head = "version = 1\nscene = \"base.toml\"\n") {
        spit(folder_ / "base.toml", scene);
        spit(folder_ / "wind.toml", head + more);
    }
    SweepFile load() const { return load_sweep(folder_ / "wind.toml"); }
    SweepCells cells() const { return cells_of(load()); }
    /// The message without the folder's name.
    std::string refusal() const {
        const std::string text = message_of([&] { cells(); }, ExitCode::invalid_scene),
                          at = (folder_ / "").string();
        return text.starts_with(at) ? text.substr(at.size()) : text;
    }

  private:
    TemporaryFolder folder_;
};

std::vector<std::string> names(const SweepCells& cells) {
    std::vector<std::string> list;
    for (const Cell& cell : cells.cells) list.push_back(cell.name);
    return list;
}

double number(const Cell& cell, const std::string& key) {
    for (const CellValue& value : cell.values)
        if (value.key == key) return value.number;
    return NAN;
}

}  // namespace

TEST_CASE("a grid, a list and samples are combined", "[sweep]") {
    const Sweep sweep(R"(
[grid]
cloth.fabric = ["silk", "wool"]
"collider[1].friction" = { from = 0.1, to = 0.4, count = 3 }
[[list]]
name = "still"
air.density = 0.5
[[list]]
air.density = 1.2
air.wind = [1, 0, 0]
[samples]
count = 2
seed = 5
cloth.fabric.bending = { log_uniform = [1e-6, 1e-5] }
)");
    const SweepCells cells = sweep.cells();
    REQUIRE(cells.cells.size() == 2 * 3 * 2 * 2);
    CHECK(cells.keys == std::vector<std::string>{"cloth.fabric", "collider[1].friction", "air.density",
                                                 "air.wind", "cloth.fabric.bending"});
    CHECK(cells.cells[0].name == "fabric=silk_friction=0.1_still_s0000");
    CHECK(cells.cells[7].name == "fabric=silk_friction=0.25_density=1.2_wind=1-0-0_s0001");
    const SceneFile file = load_cell(sweep.load(), cells.cells[7]);
    CHECK(file.scene.colliders[1].friction == 0.25);
    CHECK(file.scene.simulation.air.density == 1.2);
    CHECK(file.scene.cloths[0].fabric.bending == number(cells.cells[7], "cloth.fabric.bending"));
    // Of the pictures' size a sweep has its own default.
    CHECK(file.view.width == 320);
    std::set<std::string> keys;
    for (const Cell& cell : cells.cells) keys.insert(cell.key);
    CHECK(keys.size() == cells.cells.size());
}

TEST_CASE("more samples, and another key, leave the samples that are there", "[sweep]") {
    const std::string few = R"(
[samples]
count = 3
seed = 5
cloth.fabric.bending = { log_uniform = [1e-6, 1e-5] }
)";
    std::string more = few;
    more.replace(more.find("= 3"), 3, "= 9");
    more += "collider.friction = { uniform = [0, 1] }\n";
    const SweepCells a = Sweep(few).cells(), b = Sweep(more).cells();
    REQUIRE(b.cells.size() == 9);
    for (int k = 0; k < 3; ++k) {
        CHECK(a.cells[k].name == b.cells[k].name);
        CHECK(number(a.cells[k], "cloth.fabric.bending") == number(b.cells[k], "cloth.fabric.bending"));
    }
    std::string other = few;
    other.replace(other.find("= 5"), 3, "= 6");
    CHECK(number(Sweep(other).cells().cells[0], "cloth.fabric.bending") !=
          number(a.cells[0], "cloth.fabric.bending"));
}

TEST_CASE("derived keys are computed from keys, variables and what the scene says", "[sweep]") {
    const Sweep sweep(R"(
variables = ["side", "weight"]
constraints = ["side != 3", "cloth.size[1] < 9"]
[grid]
side = [1, 2, 3, 5]
[derived]
cloth.size = ["side", "2 * side", ]
cloth.resolution = "4 + 2 * side"
weight = "cloth.fabric.density * cloth.size[0] * cloth.size[1]"
cloth.fabric.density = "2 * cloth.fabric.density"
[results]
columns = ["cloth.fabric.density", "collider[1].center[1]"]
)");
    const SweepCells cells = sweep.cells();
    CHECK(names(cells) == std::vector<std::string>{"side=1", "side=2"});
    CHECK(cells.left_out == 2);
    const SceneFile file = load_cell(sweep.load(), cells.cells[1]);
    CHECK(file.scene.cloths[0].grid.size == cloth::Vec2(2, 4));
    CHECK(file.scene.cloths[0].grid.resolution == std::array<int, 2>{8, 8});
    CHECK(file.scene.cloths[0].fabric.density == Approx(2 * 0.082));
    CHECK(number(cells.cells[1], "weight") == Approx(0.082 * 8));
    CHECK(cells.cells[1].columns == std::vector<double>{file.scene.cloths[0].fabric.density, -9});
}

TEST_CASE("cells are named by a pattern", "[sweep]") {
    const Sweep sweep(R"(
cell_name = "{cell} {cloth.fabric}/{sample}"
[grid]
cloth.fabric = ["silk", "wool"]
[samples]
count = 1
cloth.fabric.density = { normal = [0.2, 0.1], min = 0.1, max = 0.3 }
)");
    CHECK(names(sweep.cells()) == std::vector<std::string>{"0000silk-s0000", "0001wool-s0000"});
    CHECK_THAT(Sweep("cell_name = \"{fabric}\"\n[grid]\ncloth.fabric = [\"silk\"]\n").refusal(),
               Contains("cell_name: has {fabric}; known: {cell}, {cloth.fabric}"));
}

TEST_CASE("a sweep that cannot be is refused with its place before anything runs", "[sweep]") {
    struct Bad {
        const char *text, *message;
    };
    const Bad table[] = {
        // an unknown key
        {"[grid]\ncloth.fabric.bendin = [1e-6]\n",
         "wind.toml:4:14: cell bendin=1e-06: cloth[0].fabric.bendin: unknown key; did you mean \"bending\""},
        {"[set]\noutput.frame = 3\n[grid]\ncloth.fabric.bending = [1e-6]\n",
         "wind.toml:4:8: [set]: output.frame: unknown key"},
        {"[grid]\nside = [1]\n", "wind.toml:4:1: cell side=1: side: unknown key"},
        {"[grid]\n\"collider[7].friction\" = [1]\n", "the scene has 2 [[collider]], counted from 0"},
        // a value or sample outside of its key's range
        {"[grid]\ncloth.fabric.bending = [1e-6, -1.0]\n",
         "wind.toml:4:14: cell bending=-1: cloth[0].fabric.bending: is -1; must be 0"},
        {"[samples]\ncount = 50\ncloth.fabric.poisson_ratio = { normal = [0.3, 0.7] }\n",
         "cloth[0].fabric.poisson_ratio: is "},
        {"[grid]\ncloth.resolution = [4.5]\n", "must be a whole number"},
        // two cells of one name
        {"[[list]]\nname = \"a\"\ncollider.friction = 0.1\n[[list]]\nname = \"a\"\ncollider.friction = 0.2\n",
         "wind.toml: two cells are named \"a\": collider.friction = 0.1, and collider.friction = 0.2; give "
         "cell_name"},
        {"[grid]\ncollider.friction = [0.1, 0.1]\n", "two cells are named \"friction=0.1\""},
        // the file itself
        {"", "sweeps over nothing; give a [grid], a [[list]] or [samples]"},
        {"[gird]\ncollider.friction = [1]\n", "wind.toml:3:2: gird: unknown key; did you mean \"grid\""},
        {"[grid]\ncollider.friction = 0.1\n",
         "friction: is a number; must be a list of values, or { from = a"},
        {"[grid]\ncollider.friction = { from = 1, to = 2 }\n", "has no count"},
        {"[grid]\ncollider.friction = { from = 0, to = 2, count = 3, scale = \"log\" }\n",
         "both ends of a logarithmic scale"},
        {"[samples]\ncollider.friction = { uniform = [0, 1] }\n", "samples: has no count"},
        {"[samples]\ncount = 3\n", "samples no key"},
        {"[samples]\ncount = 3\ncollider.friction = 3\n",
         "must be a distribution: { uniform = [low, high] }"},
        {"[samples]\ncount = 3\ncollider.friction = { lognormal = [0, 1] }\n", "must be a distribution"},
        {"[samples]\ncount = 3\ncollider.friction = { uniform = [1, 0] }\n", "goes from 1 down to 0"},
        {"[samples]\ncount = 3\ncollider.friction = { uniform = [0, 1], normal = [0, 1] }\n",
         "must be one distribution"},
        {"[samples]\ncount = 3\ncollider.friction = { log_uniform = [0, 1] }\n", "must be greater than 0"},
        {"[samples]\ncount = 3\ncloth.fabric = { choice = [\"silk\"], weights = [1, 2] }\n",
         "must be one number for each choice"},
        {"[set]\ncollider.friction = 0\n[grid]\ncollider.friction = [1]\n",
         "wind.toml:6:10: collider.friction: is given a value twice"},
        {"[grid]\ncollider.friction = [1]\n[derived]\ncloth.fabric.bending = \"2 * bendin\"\n",
         "wind.toml:6:14: cloth.fabric.bending: \"2 * bendin\" uses bendin, which is no key"},
        {"[grid]\ncollider.friction = [0]\n[derived]\ncloth.fabric.bending = \"1 / collider.friction\"\n",
         "is inf, which is no number"},
        {"[grid]\ncloth.fabric = [\"silk\"]\n[derived]\ncloth.fabric.bending = \"2 * cloth.fabric\"\n",
         "which is \"silk\" and no number"},
        {"constraints = [\"collider.friction = 3\"]\n[grid]\ncollider.friction = [1]\n",
         "wind.toml:3:16: constraints: \"collider.friction = 3\" has a single ="},
        {"constraints = [\"collider.friction > 3\"]\n[grid]\ncollider.friction = [1]\n",
         "constraints leave no cell"},
        {"variables = [\"a.b\"]\n[grid]\ncollider.friction = [1]\n", "variables: has \"a.b\""},
        {"[grid]\ncollider.friction = [1]\n[results]\nmeasures = [\"drape\", \"enrgy\"]\n",
         "results.measures: has \"drape\""},
        {"[grid]\ncollider.friction = [1]\n[results]\npictures = \"some\"\n", "one of all, last, none"},
        {"[grid]\ncollider.friction = { from = 0, to = 1, count = 1000000 }\n"
         "\"collider[1].friction\" = [0, 1]\n",
         "has more than 1000000 cells"},
    };
    for (const Bad& bad : table) {
        INFO(bad.text);
        CHECK_THAT(Sweep(bad.text).refusal(), Contains(bad.message));
    }
    CHECK_THAT(Sweep("[grid]\n", "scene = \"base.toml\"\n").refusal(), Contains("write version = 1"));
    CHECK_THAT(Sweep("", "version = 1\n").refusal(), Contains("name the scene that is swept"));
    CHECK_THAT(Sweep("[grid]\ncollider.friction = [1]\n", "version = 1\nscene = \"cusik\"\n").refusal(),
               Contains("wind.toml: scene: unknown scene \"cusik\""));
    CHECK_THAT(message_of([] { load_sweep("nowhere.toml"); }, ExitCode::invalid_scene),
               Contains("there is no such file"));
}
