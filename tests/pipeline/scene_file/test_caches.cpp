// Colliders that bend, from file to scene: what is read, noted and refused.

#include <catch2/catch.hpp>
#include <limits>
#include <string>
#include <vector>

#include "pipeline/formats/mesh_cache_file.h"
#include "pipeline/formats/obj.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/scene_file/scene_text.h"
#include "sim/model.h"
#include "sim/scene/mesh.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Notes = std::vector<std::string>;

namespace {

/// A grid of 3 x 3 vertices that rises by 1 m in 3 s, far below the cloth: with triangles, and without.
class Place {
  public:
    Place() {
        const MeshData mesh = make_grid({.resolution = {3, 3}});
        MeshCache cache{{mesh.positions, mesh.positions}, {0.0, 3.0}, mesh.triangles};
        cache.frames[1].col(1).array() += 1.0;
        write_mesh_cache(cache, folder_ / "body.npz");
        cache.triangles.resize(0, 3);
        cache.times.clear();
        write_mesh_cache(cache, folder_ / "bare.npz");
        spit(folder_ / "body.obj", obj_text(mesh));
        spit(folder_ / "large.obj", obj_text(make_grid({.resolution = {4, 4}})));
    }
    SceneFile scene(const std::string& keys, const std::string& frames = "61") const {
        return parse_scene("version = 1\n[output]\nframes = " + frames +
                               "\n[[cloth]]\n[[collider]]\nshape = \"mesh\"\ncenter = [0, -9, 0]\n" + keys,
                           "s.toml", folder_.path());
    }
    std::string told(const std::string& keys) const {
        return refusal_of([&] { scene(keys); });
    }
    std::string path(const std::string& name) const { return (folder_ / name).string(); }

  private:
    TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("a cache brings its triangles, or moves the mesh that is named", "[cache]") {
    const Place place;
    const SceneFile alone = place.scene("cache = \"body.npz\"\n");
    REQUIRE(alone.scene.colliders[0].mesh);
    CHECK(alone.scene.colliders[0].mesh->triangles.rows() == 8);
    CHECK(alone.notes == Notes{});
    const SceneFile both = place.scene(
        "mesh = \"body.obj\"\ncache = \"bare.npz\"\ncache_rate = 0.5\ncache_loop = true\ncache_start = "
        "-1.0\n");
    CHECK(both.notes == Notes{});
    CHECK(both.scene.colliders[0].cache->frames.size() == 2);
    CHECK(place.told("cache = \"bare.npz\"\n") ==
          "s.toml:8:9: collider[0].cache: " + place.path("bare.npz") +
              ": has vertices alone; name the mesh that they move with mesh");
}

TEST_CASE("a cache that ends before the run, or does not say how fast it is, is noted", "[cache]") {
    const Place place;
    const std::string begin = "collider[0].cache: ";
    CHECK(place.scene("cache = \"body.npz\"\n", "241").notes ==
          Notes{begin + place.path("body.npz") +
                ": ends at 3 s, the run at 4 s: its last frame stays (or cache_loop = true)"});
    CHECK(place.scene("cache = \"body.npz\"\ncache_loop = true\n", "241").notes == Notes{});
    CHECK(place.scene("cache = \"body.npz\"\ncache_speed = 0.5\n", "241").notes == Notes{});
    CHECK(place.scene("mesh = \"body.obj\"\ncache = \"bare.npz\"\n").notes ==
          Notes{begin + place.path("bare.npz") +
                    ": does not say its frame rate; taken as 24 frames per second, which cache_rate changes",
                begin + place.path("bare.npz") +
                    ": ends at 0.04167 s, the run at 1 s: its last frame stays (or cache_loop = true)"});
}

TEST_CASE("a cache that does not fit its mesh, or stands where none can, is refused by its key", "[cache]") {
    const Place place;
    CHECK(place.told("mesh = \"large.obj\"\ncache = \"body.npz\"\n") ==
          "s.toml:9:9: collider[0].cache: has 9 vertices in frame 0 (counted from 0); the mesh has 16");
    const std::string missing = place.told("cache = \"none.npz\"\n");
    CHECK_THAT(missing, Catch::StartsWith("s.toml:8:9: collider[0].cache: ") &&
                            Catch::EndsWith("none.npz: there is no such file"));
    CHECK(place.told("mesh = \"body.obj\"\ncache_loop = true\n") ==
          "s.toml:9:14: collider[0].cache_loop: belongs to a cache; name its file with cache");
    CHECK(refusal("version = 1\n[[cloth]]\n[[collider]]\ncache = \"walk.pc2\"\n") ==
          "s.toml:4:9: collider[0].cache: belongs to shape = \"mesh\"");
    MeshData mesh = make_grid({.resolution = {3, 3}});
    MeshCache cache{{mesh.positions}, {}, mesh.triangles};
    cache.frames[0](4, 1) = std::numeric_limits<double>::quiet_NaN();
    write_mesh_cache(cache, place.path("nan.npz"));
    CHECK(place.told("cache = \"nan.npz\"\n") == "s.toml:8:9: collider[0].cache: " + place.path("nan.npz") +
                                                     ": vertex 4 of frame 0 (counted from 0) is not finite");
    cache.frames[0](4, 1) = 2e6;
    write_mesh_cache(cache, place.path("far.npz"));
    CHECK(place.told("cache = \"far.npz\"\n") ==
          "s.toml:8:9: collider[0].cache: has a vertex at 2e+06 m; must be within 1000000 m of the origin");
}

TEST_CASE("a run keeps its caches, and is the same scene without the originals", "[cache]") {
    const TemporaryFolder folder;
    SceneFile file;
    {
        const Place place;
        file = place.scene("cache = \"body.npz\"\nunits = \"cm\"\ncache_speed = 2.0\ncache_rate = 30.0\n");
        const Model model = build_model(file.scene);
        start_run(folder / "run", {.file = file, .model = model, .frames = 1}, {});
    }
    CHECK(difference(load_run_scene(folder / "run"), file) == "");
}
