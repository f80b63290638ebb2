// Meshes that bend, as files have them: what is read, and what is refused.

#include <catch2/catch.hpp>
#include <cmath>
#include <limits>
#include <string>

#include "pipeline/formats/exporters.h"
#include "pipeline/formats/mesh_cache_file.h"
#include "pipeline/formats/npy.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/raw_bytes.h"
#include "sim/scene/mesh.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
namespace fs = std::filesystem;

namespace {

MeshData body() {
    return make_grid({.size = {1.0, 0.5}, .resolution = {4, 3}});
}

/// Floats alone, so that all formats keep them.
Points frame_of(int k) {
    Points positions = body().positions.cast<float>().cast<double>();
    positions.col(2).setConstant(static_cast<double>(0.25f * static_cast<float>(k)));
    return positions;
}

MeshCache three_frames() {
    return {{frame_of(0), frame_of(1), frame_of(2)}, {0.0, 0.25, 1.0}, body().triangles};
}

void check_frames(const MeshCache& cache, int count) {
    REQUIRE(static_cast<int>(cache.frames.size()) == count);
    for (int k = 0; k < count; ++k) CHECK(cache.frames[static_cast<std::size_t>(k)] == frame_of(k));
}

/// `count` frames of the body in a format, at 20 a second.
void export_frames(const fs::path& file, std::int64_t count) {
    ExportScene scene;
    scene.topology = {body().positions, body().triangles, {{"body", 0, 12, 0, 12}}};
    scene.uv = TexturePoints::Zero(12, 2);
    scene.frame_rate = 20.0;
    for (std::int64_t k = 0; k < count; ++k) scene.frames.push_back(k);
    const auto exporter = export_format("", file).make(file, FrameNames::numbered);
    exporter->begin(scene);
    for (std::int64_t k = 0; k < count; ++k)
        exporter->frame({k, scene.time(k), frame_of(static_cast<int>(k)), Points::Zero(12, 3), {}, {}, {}});
    exporter->end();
}

std::string refusal(const fs::path& file) {
    return message_of([&] { read_mesh_cache(file); }, ExitCode::invalid_scene);
}

}  // namespace

TEST_CASE("what is exported as PC2, MDD, npz or a sequence is read back as a mesh that bends", "[cache]") {
    const TemporaryFolder folder;
    for (const std::string format : {"pc2", "mdd", "npz", "obj", "ply"}) {
        INFO(format);
        export_frames(folder / ("walk." + format), 3);
        const bool sequence = format == "obj" || format == "ply";
        const LoadedCache read =
            read_mesh_cache(folder / (sequence ? "walk_000000." + format : "walk." + format));
        check_frames(read.cache, 3);
        CHECK(read.notes.empty());
        CHECK((read.cache.triangles.rows() == 12) == (format != "pc2" && format != "mdd"));
        CHECK(read.cache.times.empty() == (sequence || format == "pc2"));
        if (!read.cache.times.empty()) CHECK(read.cache.times[1] == Approx(0.05));
    }
}

TEST_CASE("a cache comes back from its own file with every bit", "[cache]") {
    const TemporaryFolder folder;
    MeshCache cache = three_frames();
    cache.frames[1](3, 1) = 1.0 / 3.0;
    write_mesh_cache(cache, folder / "c.npz");
    const MeshCache read = read_mesh_cache(folder / "c.npz").cache;
    REQUIRE(read.frames.size() == 3);
    CHECK(read.frames[1] == cache.frames[1]);
    CHECK(read.times == cache.times);
    CHECK(read.triangles == cache.triangles);
}

TEST_CASE("a sequence goes on from the file that is named, and a gap in it is told of", "[cache]") {
    const TemporaryFolder folder;
    for (const int k : {8, 9, 10}) {
        MeshData mesh{frame_of(k - 8), body().triangles};
        spit(folder / ("walk_" + std::to_string(k) + ".obj"), obj_text(mesh));
    }
    check_frames(read_mesh_cache(folder / "walk_8.obj").cache, 3);
    spit(folder / "walk_12.obj", obj_text(body()));
    spit(folder / "walking_11.obj", obj_text(body()));
    CHECK(refusal(folder / "walk_8.obj") ==
          (folder / "walk_8.obj").string() +
              ": the sequence has a gap: walk_11.obj is missing, and it goes on at 12");
    spit(folder / "walk.obj", obj_text(body()));
    CHECK(refusal(folder / "walk.obj") == (folder / "walk.obj").string() +
                                              ": is a single mesh; a sequence begins with a file that has a "
                                              "number, as walk_0001.obj");
    spit(folder / "walk_11.obj", obj_text(make_grid({.resolution = {3, 3}})));
    CHECK(refusal(folder / "walk_8.obj") ==
          (folder / "walk_8.obj").string() + ": frame 3 (counted from 0) has 9 vertices, the first 12");
}

TEST_CASE("a number in a cache that is not finite is told of with its frame and vertex", "[cache]") {
    const TemporaryFolder folder;
    export_frames(folder / "walk.pc2", 3);
    std::string bytes = slurp(folder / "walk.pc2");
    const float nothing = std::numeric_limits<float>::quiet_NaN();
    bytes.replace(32 + 12 * (2 * 12 + 7) + 4, 4, reinterpret_cast<const char*>(&nothing), 4);
    spit(folder / "walk.pc2", bytes);
    CHECK(refusal(folder / "walk.pc2") ==
          (folder / "walk.pc2").string() + ": vertex 7 of frame 2 (counted from 0) is not finite");
}

TEST_CASE("a cache that is cut short, of another kind or not there is refused by its file", "[cache]") {
    const TemporaryFolder folder;
    export_frames(folder / "walk.pc2", 3);
    export_frames(folder / "walk.mdd", 3);
    export_frames(folder / "walk.npz", 3);
    const auto begins = [&](const std::string& name) { return (folder / name).string() + ": "; };
    const std::string pc2 = slurp(folder / "walk.pc2"), mdd = slurp(folder / "walk.mdd"),
                      npz = slurp(folder / "walk.npz");
    spit(folder / "walk.pc2", pc2.substr(0, pc2.size() - 1));
    CHECK(refusal(folder / "walk.pc2") ==
          begins("walk.pc2") + "is cut short: 3 frames of 12 vertices have 108 numbers, the file 107");
    spit(folder / "walk.pc2", mdd);
    CHECK(refusal(folder / "walk.pc2") == begins("walk.pc2") + "is no PC2: it does not begin as one");
    spit(folder / "walk.mdd", pc2);
    CHECK(refusal(folder / "walk.mdd") ==
          begins("walk.mdd") + "is no MDD, or cut short: it tells of 1347373390 frames");
    spit(folder / "walk.mdd", "abc");
    CHECK(refusal(folder / "walk.mdd") == begins("walk.mdd") + "is no MDD: it is too short for one");
    spit(folder / "walk.npz", npz.substr(0, npz.size() / 2));
    CHECK(refusal(folder / "walk.npz") == begins("walk.npz") + "is no .npz (a zip of arrays)");
    std::string damaged = npz;
    damaged[300] = static_cast<char>(damaged[300] + 1);
    spit(folder / "walk.npz", damaged);
    CHECK(refusal(folder / "walk.npz") == begins("walk.npz") + "its array positions is missing or damaged");
    CHECK(refusal(folder / "none.pc2") == begins("none.pc2") + "there is no such file");
    fs::create_directory(folder / "f.npz");
    CHECK(refusal(folder / "f.npz") == begins("f.npz") + "is a folder, not a file");
    spit(folder / "walk.abc", pc2);
    CHECK(refusal(folder / "walk.abc") == begins("walk.abc") +
                                              "\".abc\" is no format of a mesh that bends; PC2, MDD, NPZ, "
                                              "glTF, FBX, Collada and sequences of OBJ or PLY are");
    std::string none = pc2;
    none.replace(28, 4, std::string(4, '\0'));
    spit(folder / "walk.pc2", none);
    CHECK(refusal(folder / "walk.pc2") ==
          begins("walk.pc2") + "has 0 frames of 12 vertices; there must be at least one");
}

TEST_CASE("arrays of an npz that are none of a mesh that bends are refused by their names", "[cache]") {
    const TemporaryFolder folder;
    const fs::path file = folder / "walk.npz";
    const std::string begin = file.string() + ": ";
    {
        NpzWriter zip(file, file);
        zip.array("poses", "<f8", {0}, "");
        zip.close();
    }
    CHECK(refusal(file) == begin + "has no array vertices of the shape (frames, n, 3)");
    const auto with = [&](const std::string& type, const NpzWriter::Shape& shape, std::size_t bytes,
                          const std::string& more = "", const NpzWriter::Shape& more_shape = {},
                          const std::vector<double>& numbers = {}) {
        NpzWriter zip(file, file);
        zip.array("vertices", type, shape, std::string(bytes, '\0'));
        std::string values;
        for (const double number : numbers) put(values, number);
        if (!more.empty()) zip.array(more, "<f8", more_shape, values);
        zip.close();
        return refusal(file);
    };
    CHECK(with("<f8", {2, 3}, 48) ==
          begin + "its array vertices has the shape (2, 3); must be (frames, n, 3)");
    CHECK(with("<f8", {2, 3, 2}, 96) ==
          begin + "its array vertices has the shape (2, 3, 2); must be (frames, n, 3)");
    CHECK(with("<f8", {2, 3, 3}, 140) == begin + "its array vertices is cut short");
    CHECK(with(">f8", {2, 3, 3}, 144) ==
          begin + "its array vertices is of the kind '>f8'; floats and integers are read");
    CHECK(with("<f8", {2, 3, 3}, 144, "faces", {1, 3}, {0.0, 1.0, 3.0}) ==
          begin + "face 0 (counted from 0) has the corner 3; there are 3 vertices");
    CHECK(with("<f8", {2, 3, 3}, 144, "faces", {3}, {0.0, 1.0, 2.0}) ==
          begin + "its array faces has the shape (3); must be (m, 3)");
    CHECK(with("<f8", {2, 3, 3}, 144, "times", {3}, {0.0, 1.0, 2.0}) == begin + "has 3 times for 2 frames");
    CHECK(with("<f8", {2, 3, 3}, 144, "times", {2}, {1.0, 1.0}) ==
          begin + "frame 1 (counted from 0) is at 1 s; times must rise");
    CHECK(with("<f8", {2, 3, 3}, 144, "fps", {}, {0.0}) == begin + "its fps must be one number above 0");
}
