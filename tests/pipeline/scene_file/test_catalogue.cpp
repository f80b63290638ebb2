// Scenes and their meshes are found by name and by path.

#include <stdlib.h>

#include <algorithm>
#include <catch2/catch.hpp>
#include <string>

#include "pipeline/formats/ply.h"
#include "pipeline/scene_file/scene_text.h"
#include "sim/scene/mesh.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

TEST_CASE("scenes are found by name and by path", "[scene_file]") {
    const TemporaryFolder assets;
    fs::create_directories(assets / "scenes");
    spit(assets / "scenes/mine.toml", "description = \"My own\"\n" + sheet());
    spit(assets / "scenes/drape_sphere.toml", "description = \"Mine comes first\"\n" + sheet());
    spit(assets / "scenes/broken.toml", "version = \n");
    setenv("RENDER_CLOTH_ASSETS", assets.path().c_str(), 1);
    CHECK(load_scene("mine").description == "My own");
    CHECK(load_scene("drape_sphere").description == "Mine comes first");
    CHECK(load_scene("seed_sheet").name == "seed_sheet");
    CHECK(load_scene((assets / "scenes/mine.toml").string()).name == "mine");
    const auto told = [](const std::string& name) { return refusal_of([&] { load_scene(name); }); };
    CHECK_THAT(told("drape_spere"),
               Contains("unknown scene \"drape_spere\"; did you mean \"drape_sphere\"?") &&
                   Contains("known: ") && Contains("mine") && Contains("seed_kick"));
    CHECK_THAT(told("quite different"), Contains("unknown scene \"quite different\"; (known: "));
    CHECK_THAT(told("none.toml"), Contains("none.toml: there is no such scene file"));
    CHECK_THAT(told(assets.path().string()), Contains("is a folder; a scene is a .toml file"));
    CHECK_THAT(told("broken"), Contains("broken.toml:1:"));
    const auto list = list_scenes();
    CHECK(std::is_sorted(list.begin(), list.end()));
    const auto row = [&](const std::string& name, const std::string& description) {
        return std::count(list.begin(), list.end(), std::array<std::string, 2>{name, description}) == 1;
    };
    CHECK(row("mine", "My own"));
    CHECK(row("drape_sphere", "Mine comes first"));
    CHECK(row("broken", "(cannot be read)"));
    unsetenv("RENDER_CLOTH_ASSETS");
    CHECK(load_scene("drape_sphere").description != "Mine comes first");
}

TEST_CASE("a relative mesh is looked for beside the scene", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "rest.ply", ply_bytes(make_grid({.resolution = {3, 3}})));
    spit(folder / "s.toml", sheet("mesh = \"rest.ply\"\n"));
    const fs::path before = fs::current_path();
    fs::current_path(folder.path().parent_path());
    const SceneFile f = load_scene(folder.path().filename().string() + "/s.toml");
    CHECK(f.scene.cloths[0].mesh.has_value());
    CHECK(f.files.at("cloth[0].mesh") == (folder / "rest.ply").string());
    // Else in the working folder.
    fs::current_path(folder.path());
    CHECK(parse_scene(sheet("mesh = \"rest.ply\"\n"), "s.toml", "/nonexistent")
              .scene.cloths[0]
              .mesh.has_value());
    fs::current_path(before);
}
