// Meshes from files: exactness, order, and every refusal.

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <bit>
#include <catch2/catch.hpp>
#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

#include "pipeline/formats/assimp_import.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/formats/obj.h"
#include "sim/scene/mesh.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

/// Message of the refusal, without the folder; "" where the file is accepted.
std::string refusal(const TemporaryFolder& folder, const std::string& name) {
    try {
        read_mesh(folder / name);
    } catch (const Error& e) {
        CHECK(e.code == ExitCode::invalid_scene);
        const std::string message = e.what(), prefix = folder.path().string() + "/";
        CHECK(message.find('\n') == std::string::npos);
        const std::size_t at = message.find(prefix);
        return at == std::string::npos ? message : message.substr(0, at) + message.substr(at + prefix.size());
    }
    return "";
}

std::string refusal_of_text(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    spit(folder / name, text);
    return refusal(folder, name);
}

MeshData read_text(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    spit(folder / name, text);
    return read_mesh(folder / name).mesh;
}

/// The notes of a mesh that is accepted.
std::vector<std::string> notes_of_text(const std::string& name, const std::string& text) {
    const TemporaryFolder folder;
    spit(folder / name, text);
    return read_mesh(folder / name).notes;
}

bool same_bits(const Points& a, const Points& b) {
    return a.rows() == b.rows() &&
           std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

template <class T>
void put(std::string& bytes, T value, bool big) {
    auto raw = std::bit_cast<std::array<char, sizeof(T)>>(value);
    if (big) std::reverse(raw.begin(), raw.end());
    bytes.append(raw.data(), raw.size());
}

std::string binary_quad(bool big) {
    std::string text = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                       "_endian 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n"
                       "element face 1\nproperty list uchar uint vertex_indices\nend_header\n";
    for (const auto& [x, y] : {std::array{0.0f, 0.0f}, {1.0f, 0.0f}, {1.0f, 1.0f}, {0.0f, 1.0f}}) {
        for (const float each : {x, y, 0.0f}) put(text, each, big);
    }
    put(text, std::uint8_t{4}, big);
    for (std::uint32_t v = 0; v < 4; ++v) put(text, v, big);
    return text;
}

/// One triangle, with a property and a list that have to be skipped.
std::string binary_ply(bool big, int corners = 3) {
    std::string text =
        std::string("ply\nformat binary_") + (big ? "big" : "little") +
        "_endian 1.0\ncomment a comment\nelement vertex 3\nproperty float x\nproperty double y\n"
        "property float z\nproperty uchar red\nelement face 1\nproperty list uchar uint vertex_index\n"
        "property list ushort short extra\nend_header\n";
    for (int v = 0; v < 3; ++v) {
        put(text, static_cast<float>(v) + 0.5f, big);
        put(text, v * 0.1, big);
        put(text, -1.25f, big);
        put(text, std::uint8_t{200}, big);
    }
    put(text, static_cast<std::uint8_t>(corners), big);
    for (int v = 0; v < corners; ++v) put(text, static_cast<std::uint32_t>((v + 1) % 3), big);
    put(text, std::uint16_t{2}, big);
    put(text, std::int16_t{-7}, big);
    put(text, std::int16_t{7}, big);
    return text;
}

const std::string ply_head =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty double x\nproperty double y\n"
    "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n";
/// A triangle whose node moves from 0 to 1 along x.
const std::string animated_gltf = R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],
"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[1,1,0]},
{"bufferView":1,"componentType":5126,"count":2,"type":"SCALAR","min":[0],"max":[1]},
{"bufferView":2,"componentType":5126,"count":2,"type":"VEC3"}],
"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":36},{"buffer":0,"byteOffset":36,"byteLength":8},
{"buffer":0,"byteOffset":44,"byteLength":24}],
"animations":[{"channels":[{"sampler":0,"target":{"node":0,"path":"translation"}}],
"samplers":[{"input":1,"output":2}]}],
"buffers":[{"byteLength":68,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAAAAAAAAAA="}]})";

const std::string corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

}  // namespace

TEST_CASE("an OBJ keeps its vertices and their order, whatever its faces use", "[mesh_file]") {
    // Vertex 2 has two normals and two texture coordinates, and the faces begin at the end.
    const MeshData mesh =
        read_text("m.obj",
                  "# comment\nmtllib x.mtl\no thing\nv 0.1 0 0\nv 1 0 0 \r\nv\t1 1 0 1.0\n"
                  "v 0 1 0.30000000000000004 0.5 0.5 0.5\nvt 0 0\nvt 1 1\nvn 0 0 1\nvn 0 1 0\n"
                  "usemtl a\ns off\nf 4/1/1 1/2/1 3//2 # last\nf 1//1 2/1/1 -2/2/2\nl 1 2\n"
                  "f 1 \\\n 2 4\n");
    REQUIRE(mesh.positions.rows() == 4);
    CHECK(mesh.positions(0, 0) == 0.1);
    CHECK(mesh.positions(3, 2) == 0.30000000000000004);
    Triangles expected(3, 3);
    expected << 3, 0, 2, 0, 1, 2, 0, 1, 3;
    CHECK(mesh.triangles == expected);
}

TEST_CASE("an OBJ that is no triangle mesh is refused with its line", "[mesh_file]") {
    CHECK(refusal_of_text("m.obj", "") == "m.obj: is empty");
    CHECK(refusal_of_text("m.obj", " \n\n") == "m.obj: is empty");
    CHECK(refusal_of_text("m.obj", "# nothing\n") == "m.obj: has no vertices");
    CHECK(refusal_of_text("m.obj", corners) == "m.obj: has no faces");
    CHECK(refusal_of_text("m.obj", "v 0 0 x\n") == "m.obj:1: \"x\" is no number");
    CHECK(refusal_of_text("m.obj", "v 0 0 1,5\n") == "m.obj:1: \"1,5\" is no number");
    CHECK(refusal_of_text("m.obj", "v 0 0 0x10\n") == "m.obj:1: \"0x10\" is no number");
    CHECK(refusal_of_text("m.obj", "v 0 0 +-1\n") == "m.obj:1: \"+-1\" is no number");
    CHECK(refusal_of_text("m.obj", "v 0 0 0\nv 0 nan 0\n") == "m.obj:2: \"nan\" is not a finite number");
    CHECK(refusal_of_text("m.obj", "v -inf 0 0\n") == "m.obj:1: \"-inf\" is not a finite number");
    CHECK(refusal_of_text("m.obj", "v 1e999 0 0\n") == "m.obj:1: \"1e999\" does not fit a double");
    CHECK(refusal_of_text("m.obj", "v 0 0\n") == "m.obj:1: a vertex of 2 numbers; it has 3: x y z");
    CHECK(refusal_of_text("m.obj", "v 0 0 0 0.5\n") == "m.obj:1: a vertex with a weight other than 1");
    CHECK(refusal_of_text("m.obj", corners + "f 1 2 3\nf 1 2\n") ==
          "m.obj:5: face 1 (counted from 0) has 2 corners; a face has three or more");
    CHECK(
        refusal_of_text("m.obj", corners + "f 1 2 3 2\n") ==
        "m.obj:4: face 0 (counted from 0) has 4 corners and no triangles: it crosses itself or has no area; "
        "triangulate the mesh in a modeller");
    std::string large = corners + "f";
    for (int i = 0; i < 2001; ++i) large += " 1";
    CHECK_THAT(refusal_of_text("m.obj", large),
               Contains("m.obj:4: face 0") && Contains("has 2001 corners, more than 2000"));
    CHECK(refusal_of_text("m.obj", corners + "f 1 2 3\nf 1 2 4\n") ==
          "m.obj:5: face 1 refers to vertex 3; there are 3, both counted from 0");
    CHECK(refusal_of_text("m.obj", corners + "f 0 1 2\n") ==
          "m.obj:4: \"0\" has the index 0; an OBJ counts from 1");
    CHECK(refusal_of_text("m.obj", corners + "f -4 1 2\n") ==
          "m.obj:4: \"-4\" counts back further than the 3 vertices so far");
    CHECK(refusal_of_text("m.obj", corners + "f 1/a 2 3\n") == "m.obj:4: \"a\" is no whole number");
    CHECK(refusal_of_text("m.obj", corners + "f /1 2 3\n") == "m.obj:4: \"/1\" is no corner of a face");
    CHECK(refusal_of_text("m.obj", corners + "f 1/ 2 3\n") == "");  // an empty texture coordinate is common
    CHECK(refusal_of_text("m.obj", corners + "f 1/1/1/1 2 3\n") ==
          "m.obj:4: \"1/1/1/1\" is no corner of a face");
    CHECK(refusal_of_text("m.obj", corners + "f 99999999999999999999 2 3\n") ==
          "m.obj:4: \"99999999999999999999\" is too large");
    CHECK(refusal_of_text("m.obj", "this is no mesh\n\x01\x02") ==
          "m.obj:1: \"this\" begins no line of an OBJ mesh");
    CHECK_THAT(refusal_of_text("m.obj", std::string(100000, 'x')), Contains("…"));
}

TEST_CASE("polygons are cut into triangles, in all formats, and that is told", "[mesh_file]") {
    // An arrow head, which a fan from its first corner would cut outside.
    const std::string arrow = "v 0 0 0\nv 2 -1 0\nv 0.5 0 0\nv 2 1 0\n";
    Triangles expected(2, 3);
    expected << 0, 1, 2, 0, 2, 3;
    CHECK(read_text("m.obj", arrow + "f 1 2 3 4\n").triangles == expected);
    CHECK(read_text("m.obj", arrow + "f -4 -3 -2 -1\n").triangles == expected);
    expected << 0, 1, 2, 2, 3, 0;
    const MeshData turned = read_text("m.obj", arrow + "f 2 3 4 1\nf 2/1 3/2 4/3 1/4\n");
    CHECK(turned.triangles.rows() == 4);
    CHECK(notes_of_text("m.obj", arrow + "f 1 2 3 4\n") ==
          std::vector<std::string>{"1 face of more than three corners cut into 2 triangles"});
    CHECK(notes_of_text("m.obj", arrow + "f 1 2 3\nf 1 2 3 4\nf 4 3 2 1\n") ==
          std::vector<std::string>{"2 faces of more than three corners cut into 4 triangles"});
    CHECK(notes_of_text("m.obj", corners + "f 1 2 3\n").empty());
    const std::string quad =
        "ply\nformat ascii 1.0\nelement vertex 4\nproperty double x\nproperty double y\n"
        "property double z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n";
    expected << 0, 1, 2, 0, 2, 3;
    CHECK(read_text("m.ply", quad).triangles == expected);
    for (const bool big : {false, true}) CHECK(read_text("m.ply", binary_quad(big)).triangles == expected);
}

TEST_CASE("what is no regular file, or never ends, is refused", "[mesh_file]") {
    const TemporaryFolder folder;
    REQUIRE(mkfifo((folder / "pipe.obj").c_str(), 0600) == 0);
    fs::create_symlink("/dev/zero", folder / "zero.ply");
    fs::create_symlink("/dev/zero", folder / "zero.glb");
    for (const char* name : {"pipe.obj", "zero.ply", "zero.glb"})
        CHECK(refusal(folder, name) == "cannot read " + std::string(name) + ": is no regular file");
    spit(folder / "huge.stl", "solid");
    fs::resize_file(folder / "huge.stl", std::uintmax_t{1} << 42);  // a hole: it takes no room
    CHECK_THAT(refusal(folder, "huge.stl"),
               Contains("cannot read huge.stl: is 4398 GB large; ") && Contains("of memory are free"));
}

TEST_CASE("only the reader of the extension is asked, and its crashes and hangs are one line",
          "[mesh_file]") {
    // Text of other formats, over which readers that were asked for their opinion crashed or hung.
    for (const char* text :
         {"ply\nformat ascii 1.0\nelement vertex 1000000000\nend_header\n",
          "ply\nformat ascii 1.0\nelement face 3\nproperty list uchar int vertex_indices\n",
          "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "solid s\nendsolid s\n"}) {
        CAPTURE(text);
        CHECK_THAT(refusal_of_text("m.glb", text), Catch::StartsWith("m.glb: cannot be read as a mesh: "));
        CHECK_THAT(refusal_of_text("m.fbx", text), Catch::StartsWith("m.fbx: cannot be read as a mesh: "));
    }
    const TemporaryFolder folder;
    spit(folder / "m.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
    CHECK(import_by_assimp(folder / "m.off", ".off").positions.size() == 3);
    // What the file names may hang as well: here a pipe that nobody writes to.
    REQUIRE(mkfifo((folder / "buffer.bin").c_str(), 0600) == 0);
    const std::size_t data = animated_gltf.find("data:"), end = animated_gltf.find('"', data);
    spit(folder / "m.gltf", animated_gltf.substr(0, data) + "buffer.bin" + animated_gltf.substr(end));
    CHECK_THAT(
        message_of([&] { import_by_assimp(folder / "m.gltf", ".gltf", {.seconds = 1}); },
                   ExitCode::invalid_scene),
        Catch::EndsWith("m.gltf: cannot be read as a mesh: the reader of .gltf files took longer than 1 s"));
}

TEST_CASE("files that are not there or are no mesh are refused", "[mesh_file]") {
    const TemporaryFolder folder;
    CHECK(refusal(folder, "none.obj") == "none.obj: there is no such file");
    fs::create_directory(folder / "folder.obj");
    CHECK(refusal(folder, "folder.obj") == "folder.obj: is a folder, not a mesh file");
    CHECK_THAT(refusal_of_text("m.xyzzy", "text"), Contains("m.xyzzy: \".xyzzy\" is no format of a mesh"));
    CHECK_THAT(refusal_of_text("m", "text"), Contains("is no format of a mesh"));
    CHECK_THAT(refusal_of_text("m.stl", "garbage"), Contains("m.stl: cannot be read as a mesh"));
    CHECK_THAT(refusal_of_text("m.glb", "garbage"), Contains("m.glb: cannot be read as a mesh"));
}

TEST_CASE("a PLY is read in all three formats", "[mesh_file]") {
    const MeshData text =
        read_text("m.ply", ply_head + "0.1 0 0\n1 0 0\n\n0 1 0.30000000000000004\n3 2 0 1\n");
    CHECK(text.positions(0, 0) == 0.1);
    CHECK(text.positions(2, 2) == 0.30000000000000004);
    CHECK(text.triangles.row(0) == Eigen::RowVector3i(2, 0, 1));
    for (const bool big : {false, true}) {
        const MeshData mesh = read_text("m.PLY", binary_ply(big));
        CHECK(mesh.positions.row(2) == Eigen::RowVector3d(2.5, 0.2, -1.25));
        CHECK(mesh.triangles.row(0) == Eigen::RowVector3i(1, 2, 0));
    }
}

TEST_CASE("a PLY that is no triangle mesh is refused", "[mesh_file]") {
    const std::string vertices = "0 0 0\n1 0 0\n0 1 0\n";
    CHECK(refusal_of_text("m.ply", "plu\n") == "m.ply:1: is no PLY mesh: its first line is not \"ply\"");
    CHECK(refusal_of_text("m.ply", "ply\nformat ascii 1.0\n") ==
          "m.ply:2: the header has no end_header: cut short");
    CHECK(refusal_of_text("m.ply", "ply\nend_header\n") == "m.ply:2: the header has no format");
    CHECK(refusal_of_text("m.ply", "ply\nformat ascii 2.0\n") ==
          "m.ply:2: \"ascii\" is no format of PLY 1.0");
    CHECK(refusal_of_text("m.ply", "ply\nformat ascii 1.0\nelement vertex -1\n") ==
          "m.ply:3: a negative number of vertex");
    CHECK(refusal_of_text("m.ply", "ply\nproperty float x\n") ==
          "m.ply:2: \"property\" begins no line of a PLY header, or has other words behind it");
    CHECK(refusal_of_text("m.ply", "ply\nelement vertex 1\nproperty half x\n") ==
          "m.ply:3: \"half\" is no type of a PLY property");
    CHECK(refusal_of_text("m.ply", "ply\nelement face 1\nproperty list float int vertex_indices\n") ==
          "m.ply:3: a list's length is no whole number");
    CHECK_THAT(refusal_of_text("m.ply",
                               "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nend_header\n1\n"),
               Contains("the vertices lack one of x, y, z"));
    CHECK_THAT(
        refusal_of_text("m.ply", "ply\nformat ascii 1.0\nelement face 1\nproperty int x\nend_header\n1\n"),
        Contains("the faces have no list vertex_indices"));
    CHECK_THAT(refusal_of_text("m.ply",
                               "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\n"
                               "property float y\nproperty float z\nend_header\n"),
               Contains("promises 4000000000 of vertex, more than the file holds: cut short"));
    CHECK(refusal_of_text("m.ply", ply_head + "0 0 0\n1 0 0\n0 1 nan\n3 0 1 2\n") ==
          "m.ply:12: \"nan\" is not a finite number");
    CHECK(refusal_of_text("m.ply", ply_head + "0 0 0\n1 0\n0 1 0\n3 0 1 2\n") ==
          "m.ply:11: 2 numbers, fewer than the header promises");
    CHECK(refusal_of_text("m.ply", ply_head + "0 0 0 9\n1 0 0\n0 1 0\n3 0 1 2\n") ==
          "m.ply:10: 4 numbers where the header promises 3");
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "4 0 1 2 0\n"),
               Contains("m.ply:13: face 0") && Contains("crosses itself"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "2 0 1\n"), Contains("has 2 corners"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "3 0 1 3\n"),
               Contains("m.ply:13: face 0 refers to vertex 3; there are 3"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "3 0 1 -1\n"), Contains("refers to vertex -1"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "3 0 1 1.5\n"),
               Contains("\"1.5\" is no whole number"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices), Contains("cut short"));
    CHECK_THAT(refusal_of_text("m.ply", ply_head + vertices + "3 0 1 2\n3 0 1 2\n"),
               Contains("more follows than the header promises"));
    CHECK_THAT(refusal_of_text("m.ply", binary_ply(false, 2)),
               Contains("m.ply: face 0") && Contains("2 corners"));
    std::string broken = binary_ply(false);
    const std::size_t body = broken.find("end_header\n") + 11;
    for (const std::size_t length : {body + 2, body + 30, broken.size() - 1}) {
        CHECK_THAT(refusal_of_text("m.ply", broken.substr(0, length)), Contains("cut short"));
    }
    broken[body + 3] = '\x7f';  // the top bits of a float infinity
    broken[body + 2] = '\x80';
    CHECK(refusal_of_text("m.ply", broken) == "m.ply: x of vertex 0 (counted from 0) is not a finite number");
}

TEST_CASE("other formats come through assimp", "[mesh_file]") {
    SECTION("an STL's equal corners are one vertex") {
        const MeshData mesh =
            read_text("m.stl",
                      "solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\n"
                      "vertex 0 1 0\nendloop\nendfacet\nfacet normal 0 0 1\nouter loop\n"
                      "vertex 1 0 0\nvertex 1 1 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid s\n");
        CHECK(mesh.positions.rows() == 4);
        CHECK(mesh.triangles.row(1) == Eigen::RowVector3i(1, 3, 2));
    }
    SECTION("a polygon is cut") {
        CHECK(read_text("m.off", "OFF\n4 1 0\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n4 0 1 2 3\n").triangles.rows() ==
              2);
    }
    SECTION("an animation is told of") {
        CHECK(notes_of_text("m.gltf", animated_gltf) ==
              std::vector<std::string>{
                  "1 animation ignored: the mesh stands still, where its nodes are at rest"});
    }
}

TEST_CASE("a start pose needs no faces", "[mesh_file]") {
    const TemporaryFolder folder;
    MeshData mesh = make_grid({.resolution = {3, 3}});
    mesh.triangles.resize(0, 3);
    write_file(folder / "pose.obj", obj_text(mesh));
    CHECK(same_bits(read_points(folder / "pose.obj").mesh.positions, mesh.positions));
    CHECK(refusal(folder, "pose.obj") == "pose.obj: has no faces");
}
