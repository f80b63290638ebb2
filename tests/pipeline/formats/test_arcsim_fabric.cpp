// Measured fabrics in ARCSim's files.

#include "pipeline/formats/arcsim_fabric.h"

#include <catch2/catch.hpp>
#include <string>

#include "pipeline/scene_file/scene_text.h"
#include "sim/energies/woven.h"
#include "support/refusal.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;

namespace {

std::string file(const std::string& density, const std::string& at_rest, const std::string& bias) {
    return "{ \"density\": " + density + ",\n\"stretching\": [[" + at_rest +
           "],\n[1,2,3,4],[1,2,3,4],[1,2,3,4],[1,2,3,4],[1,2,3,4]],\n" + "\"bending\": [[3e-5,1,1,1,1],[" +
           bias + ",1,1,1,1],[1e-5,1,1,1,1]] }\n";
}

}  // namespace

TEST_CASE("a fabric of ARCSim's keeps the energy of small strains and curvatures", "[arcsim]") {
    const TemporaryFolder folder;
    spit(folder / "wool.json", file("0.187", "60, 15, 40, 36", "1.5e-5"));
    const LoadedFabric loaded = read_arcsim_fabric(folder / "wool.json");
    const Fabric& f = loaded.fabric;
    CHECK(f.name == "wool");
    CHECK(f.density == 0.187);
    // Its stiffness back from the moduli: over E11, E22 and 2 E12, as C33 E12² = C33/4 (2 E12)².
    const Mat3 C =
        f.thickness * woven_stiffness(f.young_modulus, *f.young_weft, f.poisson_ratio, *f.shear_modulus);
    Mat3 expected;
    expected << 60, 15, 0, 15, 40, 0, 0, 0, 9;
    CHECK((C - expected).norm() < 1e-10);
    CHECK(f.bending == 3e-5);
    CHECK(*f.bending_weft == 1e-5);
    CHECK(*f.bending_bias == 1.5e-5);
    REQUIRE(loaded.notes.size() == 1);
    CHECK_THAT(loaded.notes[0], Contains("is left out"));

    spit(folder / "odd.json", file("0.187", "60, 15, 40, 36", "0.5e-5"));
    const LoadedFabric odd = read_arcsim_fabric(folder / "odd.json");
    CHECK(*odd.fabric.bending_bias == Approx(1e-5));
    REQUIRE(odd.notes.size() == 2);
    CHECK_THAT(odd.notes[1], Contains("45 degrees, 5e-06 N m, is less than"));
}

TEST_CASE("scenes name a fabric's file, alone or as a base", "[arcsim]") {
    const TemporaryFolder folder;
    spit(folder / "wool.json", file("0.187", "60, 15, 40, 36", "1.5e-5"));
    const auto scene = [&](const std::string& keys) {
        return parse_scene(sheet(keys), "s.toml", folder.path());
    };
    const SceneFile alone = scene("fabric = \"wool.json\"\n");
    CHECK(alone.scene.cloths[0].fabric.density == 0.187);
    REQUIRE(alone.notes.size() == 1);
    CHECK_THAT(alone.notes[0], Contains("cloth[0].fabric: ") && Contains("wool.json: how it stiffens"));
    const SceneFile based = scene("fabric = { base = \"wool.json\", friction = 0.4 }\n");
    CHECK(based.scene.cloths[0].fabric.density == 0.187);
    CHECK(based.scene.cloths[0].fabric.friction == 0.4);
    // The kept scene has the numbers, and needs the file no more.
    CHECK(parse_scene(alone.resolved(), "kept.toml", "/").scene.cloths[0].fabric.young_modulus ==
          alone.scene.cloths[0].fabric.young_modulus);
    CHECK_THAT(refusal_of([&] { scene("fabric = \"felt.json\"\n"); }),
               Contains("s.toml:") && Contains("felt.json"));
}

TEST_CASE("a file that is no fabric of ARCSim's is refused by what is wrong", "[arcsim]") {
    const TemporaryFolder folder;
    const auto told = [&](const std::string& text) {
        spit(folder / "f.json", text);
        return refusal_of([&] { read_arcsim_fabric(folder / "f.json"); });
    };
    CHECK_THAT(told("{ \"density\": 1,\n\n oops }"), Contains("f.json:3: is no JSON from here on"));
    CHECK_THAT(told("[1, 2]"), Contains("f.json: holds no JSON object"));
    CHECK_THAT(told("{}"), Contains("has no number density"));
    CHECK_THAT(told("{\"density\": \"1\"}"), Contains("has no number density"));
    CHECK_THAT(told("{\"density\": 1}"), Contains("stretching is not 6 rows of 4 numbers"));
    CHECK_THAT(told(file("0.1", "60, 15, 40", "1e-5")), Contains("stretching is not 6 rows of 4 numbers"));
    CHECK_THAT(told(file("0.1", "60, 15, 40, 36", "\"x\"")), Contains("bending is not 3 rows of 5 numbers"));
    CHECK_THAT(told(file("0.1", "10, 25, 40, 36", "2e-5")), Contains("is no stiffness"));
}
