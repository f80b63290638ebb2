// Keys set over what a scene file says.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "pipeline/scene_file/scene_text.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;

TEST_CASE("overrides reach every kind of key", "[scene_file]") {
    const std::string text = sheet(
        "[[cloth]]\nname = \"b\"\n[simulation]\ntime_step = 0.01\n[[collider]]\n"
        "contact_offset = 0.1\n");
    const SceneFile f =
        parse(text, {"cloth.fabric.density=0.2", "cloth[1].resolution=[3, 4]", "cloth[1].diagonals=uniform",
                     "simulation.substeps=4", "camera.position=[0, 1, 3]", "output.size=640x360",
                     "collider[0].contact_radius = 0.4", "light.softness=0.5", "ground.height=-2",
                     "description=two words", "cloth.color=#336699", "expect.frames=[1]",
                     "cloth[1].fabric={mu = 2.0, lambda = 1.0}", "cloth.bump=1", "cloth.bump=0.025"});
    CHECK(f.scene.cloths[0].fabric.density == 0.2);
    CHECK(f.scene.cloths[0].fabric.bending == default_fabric().bending);
    CHECK(f.scene.cloths[1].grid.resolution == std::array<int, 2>{3, 4});
    CHECK(f.scene.cloths[1].grid.diagonals == Diagonals::uniform);
    CHECK(f.scene.simulation.substeps == 4);
    CHECK(!f.scene.simulation.time_step);
    CHECK(f.view.eye == render::Float3{0, 1, 3});
    CHECK(f.view.width == 640);
    CHECK(f.scene.colliders[0].contact_radius == 0.4);
    CHECK(f.scene.colliders[0].contact_offset == 0.0);
    CHECK(f.view.light.softness == 0.5f);
    CHECK(f.ground->height == -2.0f);
    CHECK(f.description == "two words");
    CHECK(f.scene.cloths[1].fabric.mu == 2.0);
    CHECK(f.scene.cloths[0].bump == 0.025);  // the last one counts
    CHECK(parse(text, {"simulation.time_step=0.02"}).scene.simulation.time_step == 0.02);
    // Young's modulus takes the place of mu and lambda, and the other way round.
    const std::string given = sheet("fabric = { mu = 2, lambda = 1 }\n");
    CHECK(!parse(given, {"cloth.fabric.young_modulus=3"}).scene.cloths[0].fabric.mu);
    CHECK(parse(sheet("fabric.young_modulus = 7\n"), {"cloth.fabric.mu=2", "cloth.fabric.lambda=1"})
              .scene.cloths[0]
              .fabric.lambda == 1.0);
}

TEST_CASE("an override's choice of vertices takes the place of the file's", "[scene_file]") {
    const std::string text = sheet(
        "[[pin]]\nnearest = [0, 0, 0]\n[[seam]]\nfirst = { edge = \"left\" }\nsecond = { greatest = \"x\" "
        "}\n");
    const SceneFile f = parse(text, {"pin.edge=top", "seam.second.edge=right", "seam.stiffness=5",
                                     "pin.path=[{ time = 1, translate = [0, 1, 0] }]"});
    CHECK(f.scene.pins[0].edge == "top");
    CHECK(!f.scene.pins[0].nearest);
    CHECK(f.scene.pins[0].path[0].translate == Vec3(0, 1, 0));
    CHECK(f.scene.seams[0].sides[1].edge == "right");
    CHECK(!f.scene.seams[0].sides[1].greatest);
    CHECK(f.scene.seams[0].stiffness == 5.0);
}

TEST_CASE("an override's mesh takes the grid's place", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string text = sheet("size = [2, 2]\nresolution = 9\ndiagonals = \"uniform\"\n");
    const SceneFile f = parse_scene(text, "s.toml", folder.path(), {"cloth.mesh=m.obj"});
    REQUIRE(f.scene.cloths[0].mesh);
    CHECK(f.scene.cloths[0].mesh->positions.rows() == 3);
    CHECK_THAT(f.resolved(), Contains((folder / "m.obj").string()));
}

TEST_CASE("a refused override is named as it was given", "[scene_file]") {
    struct Case {
        std::string override, message;
    };
    const std::vector<Case> cases = {
        {"nonsense", "--set nonsense: must be KEY=VALUE"},
        {"=3", "--set =3: must be KEY=VALUE"},
        {"cloth.bump=", "--set cloth.bump=: cloth.bump: has no value"},
        {"cloth..bump=1", "a part of the key is empty"},
        {"cloth[x].bump=1", "an index is written [0], [1], …"},
        {"cloth[0.bump=1", "an index is written [0], [1], …"},
        {"cloth=1", "names a whole table; name one of its keys"},
        {"cloth.densty=1", "--set cloth.densty=1: cloth[0].densty: unknown key; known here: "},
        {"cloth.fabric.densty=1",
         "--set cloth.fabric.densty=1: cloth[0].fabric.densty: unknown key; did you mean \"density\" "
         "[kg/m²]?"},
        {"cloth.fabric={densty=1}",
         "--set cloth.fabric={densty=1}: cloth[0].fabric.densty: unknown key; did you mean"},
        {"wibble.x=1", "--set wibble.x=1: wibble: unknown key"},
        {"cloth[1].bump=1",
         "--set cloth[1].bump=1: cloth[1].bump: the scene has 1 [[cloth]], counted from 0"},
        {"collider.radius=1", "the scene has 0 [[collider]], counted from 0"},
        {"simulation[0].substeps=1", "\"simulation\" is no list of tables"},
        {"version.x=1", "\"version\" is no table"},
        {"cloth.bump=high", "--set cloth.bump=high: cloth[0].bump: is a string; must be a number [m]"},
        {"cloth.bump=1\ncloth.size = 3", "cloth[0].bump: is a string; must be a number [m]"},
        {"cloth.bump=nan", "--set cloth.bump=nan: cloth[0].bump: is not finite"},
        {"simulation.time_step=0",
         "--set simulation.time_step=0: simulation.time_step: is 0; must be 1e-9 … 1000 s"},
        {"cloth.resolution=1",
         "--set cloth.resolution=1: cloth[0].resolution: is 1; must be 2 … 4096 vertices"},
        {"cloth.mesh=none.obj", "--set cloth.mesh=none.obj: cloth[0].mesh: "},
        {"pin.path=[{ time = 0, roatte = 1 }]", "the scene has 0 [[pin]], counted from 0"},
        {"air.drag=-1", "--set air.drag=-1: air.drag: is -1; must be 0 … 1000"},
        {"cloth.name=\xff\xfe", "has a value that is not UTF-8 text"},
    };
    for (const Case& c : cases) {
        INFO(c.override);
        const std::string message = refusal(sheet(), {c.override});
        CHECK_THAT(message, Contains(c.message));
        CHECK_THAT(message, Catch::StartsWith("--set "));
    }
}
