// Animations of files as meshes that bend: nodes, skeletons, morph targets.

#include <catch2/catch.hpp>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/formats/exporters.h"
#include "pipeline/formats/mesh_cache_file.h"
#include "pipeline/formats/raw_bytes.h"
#include "sim/scene/mesh.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using nlohmann::json;
namespace fs = std::filesystem;

namespace {

/// Of floats near 1 m.
constexpr double float_error = 1e-6;

/// A strip of two triangles along x, from 0 to 1 to 2 m, whose second half hangs on a joint at x = 1 that
/// turns by 90° about z within a second, linearly; `bound`: whether its last vertex has a weight.
void write_arm(const fs::path& file, bool bound, bool animated = true) {
    std::string bytes;
    json views = json::array(), accessors = json::array();
    const auto add = [&](const std::string& data, int component, int count, const char* type) {
        views.push_back({{"buffer", 0}, {"byteOffset", bytes.size()}, {"byteLength", data.size()}});
        accessors.push_back({{"bufferView", views.size() - 1},
                             {"componentType", component},
                             {"count", count},
                             {"type", type}});
        bytes += data;
        bytes.resize((bytes.size() + 3) / 4 * 4);
    };
    const auto floats = [](const std::vector<float>& numbers) {
        std::string data;
        for (const float number : numbers) put(data, number);
        return data;
    };
    add(floats({0, 0, 0, 0, 0, 1, 1, 0, 0, 2, 0, 0}), 5126, 4, "VEC3");
    accessors[0]["min"] = {0, 0, 0};
    accessors[0]["max"] = {2, 0, 1};
    std::string corners, joints;
    for (const int corner : {0, 1, 2, 1, 3, 2}) put(corners, static_cast<std::uint16_t>(corner));
    for (const int joint : {0, 0, 0, 1})
        for (const int j : {joint, 0, 0, 0}) joints.push_back(static_cast<char>(j));
    add(corners, 5123, 6, "SCALAR");
    add(joints, 5121, 4, "VEC4");
    const float last = bound ? 1.0f : 0.0f;
    add(floats({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, last, 0, 0, 0}), 5126, 4, "VEC4");
    // Inverse bind matrices, column by column: the second joint stands at x = 1.
    add(floats({1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0,  0, 0, 1,
                1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, -1, 0, 0, 1}),
        5126, 2, "MAT4");
    add(floats({0, 1}), 5126, 2, "SCALAR");
    accessors[5]["min"] = {0};
    accessors[5]["max"] = {1};
    const auto half = static_cast<float>(std::sqrt(0.5));
    add(floats({0, 0, 0, 1, 0, 0, half, half}), 5126, 2, "VEC4");
    json root = {
        {"asset", {{"version", "2.0"}}},
        {"scene", 0},
        {"scenes", {{{"nodes", {0, 1}}}}},
        {"nodes",
         {{{"name", "arm"}, {"mesh", 0}, {"skin", 0}},
          {{"name", "shoulder"}, {"children", {2}}},
          {{"name", "elbow"}, {"translation", {1, 0, 0}}}}},
        {"meshes",
         {{{"primitives",
            {{{"attributes", {{"POSITION", 0}, {"JOINTS_0", 2}, {"WEIGHTS_0", 3}}}, {"indices", 1}}}}}}},
        {"skins", {{{"joints", {1, 2}}, {"inverseBindMatrices", 4}}}},
        {"accessors", accessors},
        {"bufferViews", views},
        {"buffers", {{{"byteLength", bytes.size()}, {"uri", "arm.bin"}}}}};
    if (animated)
        root["animations"] = {
            {{"samplers", {{{"input", 5}, {"output", 6}, {"interpolation", "LINEAR"}}}},
             {"channels", {{{"sampler", 0}, {"target", {{"node", 2}, {"path", "rotation"}}}}}}}};
    spit(file.parent_path() / "arm.bin", bytes);
    spit(file, root.dump());
}

}  // namespace

TEST_CASE("a skeleton's turn bends the mesh, vertex by vertex", "[cache]") {
    const TemporaryFolder folder;
    write_arm(folder / "arm.gltf", true);
    const LoadedCache read = read_mesh_cache(folder / "arm.gltf");
    REQUIRE(read.cache.frames.size() == 61);
    CHECK(read.cache.triangles.rows() == 2);
    CHECK(read.cache.times.back() == Approx(1.0).margin(1e-9));
    for (const std::size_t k : {0u, 20u, 45u, 60u}) {
        const double angle = 0.5 * 3.14159265358979 * read.cache.times[k];
        const Points& frame = read.cache.frames[k];
        CHECK((frame.row(2) - Eigen::RowVector3d(1.0, 0.0, 0.0)).norm() < float_error);  // the shoulder's
        CHECK((frame.row(3) - Eigen::RowVector3d(1.0 + std::cos(angle), std::sin(angle), 0.0)).norm() <
              float_error);
    }
}

TEST_CASE("morph targets and moving nodes, as they are exported, bend the mesh", "[cache]") {
    const TemporaryFolder folder;
    const MeshData mesh = make_grid({.resolution = {3, 3}});
    ExportScene scene;
    scene.topology = {mesh.positions, mesh.triangles, {{"sheet", 0, 9, 0, 8}}};
    scene.uv = TexturePoints::Zero(9, 2);
    scene.materials.resize(1);
    scene.colliders.push_back({"box", make_shape({.shape = Shape::box})->surface(), {}});
    scene.frame_rate = 10.0;
    scene.frames = {0, 1, 2};
    const auto exporter = export_format("gltf", "").make(folder / "m.glb", FrameNames::numbered);
    exporter->begin(scene);
    for (const std::int64_t k : scene.frames) {
        Points positions = mesh.positions;
        positions.col(2).array() += 0.1 * static_cast<double>(k * k) * positions.col(0).array();
        Placement placement;
        placement.translation.y() = static_cast<double>(k);
        exporter->frame({k,
                         scene.time(k),
                         positions,
                         Points::Zero(9, 3),
                         {{true, placement}},
                         {Vec3(0.0, 0.0, 3.0), Vec3::Zero(), Vec3::UnitY(), 35.0},
                         {}});
    }
    exporter->end();
    const MeshCache cache = read_mesh_cache(folder / "m.glb").cache;
    REQUIRE(cache.frames.size() == 13);  // 0.2 s at 60 a second
    const double corner = mesh.positions(8, 0);
    CHECK(cache.frames[6](8, 2) == Approx(0.1 * corner).margin(float_error));
    CHECK(cache.frames[9](8, 2) == Approx(0.25 * corner).margin(float_error));  // half-way between frames
    CHECK(cache.frames[12](8, 2) == Approx(0.4 * corner).margin(float_error));
    CHECK(cache.frames[9](9, 1) - cache.frames[0](9, 1) == Approx(1.5).margin(float_error));  // the box
}

TEST_CASE("an animation that is none, or a skeleton without weights, is refused", "[cache]") {
    const TemporaryFolder folder;
    const fs::path file = folder / "arm.gltf";
    const auto refusal = [&] { return message_of([&] { read_mesh_cache(file); }, ExitCode::invalid_scene); };
    write_arm(file, true, false);
    CHECK(refusal() == file.string() + ": has no animation; a body that stands still is named by mesh alone");
    write_arm(file, false);
    CHECK_THAT(refusal(), Catch::Contains("arm.gltf: vertex 3 (counted from 0) of mesh ") &&
                              Catch::Contains("has no weight at any bone of its skeleton"));
}
