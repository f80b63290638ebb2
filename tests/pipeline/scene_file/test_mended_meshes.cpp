// Meshes as people have them, from file to scene: what becomes of vertices, pins, seams and poses, and what
// is told.

#include <catch2/catch.hpp>
#include <string>
#include <vector>

#include "pipeline/formats/obj.h"
#include "pipeline/scene_file/memory_need.h"
#include "pipeline/scene_file/scene_text.h"
#include "sim/scene/mesh.h"
#include "support/refusal.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
using Notes = std::vector<std::string>;

namespace {

/// Two squares side by side that share no vertex, and a loose one before them.
const std::string doubled =
    "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\n"
    "f 2 3 4\nf 2 4 5\nf 6 7 8\nf 8 6 9\n";

class Place {
  public:
    Place() {
        spit(folder_ / "doubled.obj", doubled);
        spit(folder_ / "grid.obj", obj_text(make_grid({.resolution = {3, 3}})));
    }
    SceneFile scene(const std::string& keys) const {
        return parse_scene(sheet(keys), "s.toml", folder_.path());
    }
    std::string told(const std::string& keys) const {
        return refusal_of([&] { scene(keys); });
    }
    /// Notes without the folder.
    Notes notes(const std::string& keys) const {
        Notes short_notes = scene(keys).notes;
        for (std::string& note : short_notes) {
            const std::string prefix = folder_.path().string() + "/";
            if (const std::size_t at = note.find(prefix); at != note.npos) note.erase(at, prefix.size());
        }
        return short_notes;
    }
    const TemporaryFolder& folder() const { return folder_; }

  private:
    TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("a cloth's mesh is mended as it is read, and each mend is told in a line", "[mended]") {
    const Place place;
    const SceneFile file = place.scene("mesh = \"doubled.obj\"\n");
    CHECK(file.scene.cloths[0].mesh->positions.rows() == 6);
    CHECK(file.vertices_in_file[0] == std::vector<int>{1, 2, 3, 4, 6, 7});
    CHECK(
        place.notes("mesh = \"doubled.obj\"\n") ==
        Notes{
            "cloth[0].mesh: doubled.obj: 2 doubled vertices joined with what stands at the same place; "
            "weld = false leaves them apart",
            "cloth[0].mesh: doubled.obj: 1 vertex of no triangle left out",
            "cloth[0].mesh: doubled.obj: 1 triangle of 4 turned over, so that each piece faces the way that "
            "most of it does"});
    CHECK(place.notes("mesh = \"grid.obj\"\n").empty());
    // A collider's mesh may be any triangles.
    CHECK(place.notes("[[collider]]\nshape = \"mesh\"\nmesh = \"doubled.obj\"\n").empty());
}

TEST_CASE("weld = false leaves doubled vertices, told or refused", "[mended]") {
    const Place place;
    const std::string keys = "mesh = \"doubled.obj\"\nweld = false\n";
    CHECK_THAT(place.told(keys),
               Contains("s.toml:4:8: cloth[0].weld: is false, and 2 vertices stand at the place of another: "
                        "contact = \"barrier\" cannot hold them apart; leave weld out to join them"));
    const Notes notes = place.notes(keys + "[simulation]\ncontact = \"penalty\"\n");
    CHECK_THAT(notes.at(0),
               Contains("2 vertices at the place of another left as weld = false wants it: the cloth "
                        "is open there"));
    CHECK(place.told("mesh = \"grid.obj\"\nweld = false\n") == "");
}

TEST_CASE("pins, seams and poses go with the vertices of the file", "[mended]") {
    const Place place;
    spit(place.folder() / "pose.obj", doubled.substr(0, doubled.find('f')));
    spit(place.folder() / "few.obj", "v 0 0 0\n");
    const std::string mesh = "mesh = \"doubled.obj\"\n";
    SceneFile file = place.scene(mesh + "pose = \"pose.obj\"\n[[pin]]\nvertices = [7, 2, 5]\n");
    CHECK(file.scene.pins[0].vertices == std::vector<int>{5, 1});  // 5 is one with 2
    CHECK(file.scene.cloths[0].pose->rows() == 6);
    // Written with the file's name it has the file's numbers, with a kept mesh those of that.
    CHECK_THAT(file.resolved(), Contains("vertices = [7, 2]"));
    CHECK_THAT(file.resolved({{"cloth[0].mesh", "m.obj"}}), Contains("vertices = [5, 1]"));
    const SceneFile again = parse_scene(file.resolved(), "s.toml", place.folder().path());
    CHECK(difference(file, again) == "");

    CHECK_THAT(place.told(mesh + "[[pin]]\nvertices = [0]\n"),
               Contains("s.toml:5:12: pin[0].vertices: vertex 0 belongs to no triangle of the cloth"));
    CHECK_THAT(place.told(mesh + "[[pin]]\nvertices = [9]\n"),
               Contains("pin[0].vertices: vertex 9 does not exist; the cloth's file has vertices 0 … 8"));
    CHECK_THAT(place.told(mesh + "[[seam]]\nfirst = { vertices = [2, 3] }\nsecond = { vertices = [5, 8] }\n"),
               Contains("seam[0]: sews vertices that stand at one place and are joined already"));
    CHECK_THAT(place.told(mesh + "pose = \"few.obj\"\n"), Contains("cloth[0].pose: "));
}

TEST_CASE("units scale the rest shape with the start, and odd sizes are told of", "[mended]") {
    const Place place;
    MeshData large = make_grid({.size = {60.0, 80.0}, .resolution = {3, 3}});
    spit(place.folder() / "cm.obj", obj_text(large));
    const SceneFile file = place.scene("mesh = \"cm.obj\"\nunits = \"cm\"\n[[collider]]\n");
    CHECK(file.notes.empty());
    CHECK(rest_shape(file.scene.cloths[0]).positions.isApprox(0.01 * large.positions, 1e-15));
    CHECK_THAT(
        place.notes("mesh = \"cm.obj\"\n[[collider]]\n").at(0),
        Contains("cloth[0].mesh: is 100 m across, 200 times the largest thing that it can meet; is \"m\" the "
                 "unit of its file? units names it: one of m, cm, mm, in, ft"));
    CHECK_THAT(place.notes("mesh = \"cm.obj\"\n").at(0), Contains("cloth[0].mesh: is 100 m across; is"));
    CHECK_THAT(place.notes("mesh = \"cm.obj\"\nunits = \"mm\"\nscale = 0.01\n[[collider]]\n").at(0),
               Contains("is 0.001 m across, the smallest thing that it can meet is 500 times as large"));
    CHECK_THAT(place.notes("[[collider]]\nshape = \"mesh\"\nmesh = \"cm.obj\"\n").at(0),
               Contains("collider[0].mesh: is 100 m across, 70.7 times the largest"));
    CHECK(place.notes("[[collider]]\nshape = \"mesh\"\nmesh = \"cm.obj\"\nunits = \"cm\"\n").empty());
    CHECK(place.notes("size = [100, 100]\n[[collider]]\n").empty());  // sizes in a scene are meant
}

TEST_CASE("a mesh whose numbers are absurd is refused", "[mended]") {
    const Place place;
    spit(place.folder() / "far.obj", "v 0 0 0\nv 1e300 0 0\nv 0 1e300 0\nf 1 2 3\n");
    for (const char* keys : {"mesh = \"far.obj\"\n", "mesh = \"far.obj\"\nunits = \"mm\"\n",
                             "[[collider]]\nshape = \"mesh\"\nmesh = \"far.obj\"\n"})
        CHECK_THAT(place.told(keys), Contains(".mesh: has a vertex at 1e+") &&
                                         Contains(" m; must be within 1000000 m of the origin"));
}

TEST_CASE("what needs more memory than there is is refused with key, need and what is there", "[mended]") {
    const SceneFile grid = parse(sheet("resolution = 1000\n[[cloth]]\nresolution = 9\n")),
                    disc = parse(sheet("radius = 1\nrings = 500\nsubdivisions = 3\n"));
    const auto told = [](const MemoryNeed& need, std::size_t available, std::string* key) {
        return refusal([&] { require_memory(need, available); }, key);
    };
    std::string key;
    CHECK(told(simulation_need(grid.scene), 2'000'000'000, &key) ==
          "needs about 22.9 GB of memory; 2.0 GB are there");
    CHECK(key == "cloth[0].resolution");
    CHECK(told(simulation_need(disc.scene), 2'000'000'000, &key) != "accepted");
    CHECK(key == "cloth[0].rings");
    CHECK(told(picture_need(disc), 2'000'000'000, &key) != "accepted");
    CHECK(key == "cloth[0].subdivisions");
    CHECK(told(picture_need(parse(sheet("[output]\nsize = [8192, 8192]\n"))), 2'000'000'000, &key) !=
          "accepted");
    CHECK(key == "output.size");
    CHECK(told(reading_need(grid.scene), 100'000'000, &key) != "accepted");
    CHECK(told(reading_need(grid.scene), 2'000'000'000, &key) == "accepted");
}

TEST_CASE("a scene whose file name is not UTF-8 is refused", "[mended]") {
    CHECK_THAT(refusal_of([&] { parse_scene(sheet(), "a\xff.toml", "/"); }),
               Contains("is not UTF-8 text: rename it"));
}
