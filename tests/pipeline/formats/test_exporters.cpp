// Every row of the table of export formats: what is written is read back, together or not at all.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <random>
#include <set>
#include <string>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/exporters.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/mesh_file.h"
#include "sim/scene/mesh.h"
#include "support/error_message.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

bool same_bits(const Points& a, const Points& b) {
    return a.rows() == b.rows() &&
           std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(double)) == 0;
}

/// A grid above a ball, at 60 frames per second.
ExportScene grid(std::vector<std::int64_t> frames) {
    const MeshData mesh = make_grid({.size = {1.0, 0.7}, .resolution = {7, 5}});
    ExportScene scene;
    scene.name = "grid";
    scene.topology = {mesh.positions, mesh.triangles, {{"sheet", 0, 35, 0, 48}}};
    scene.uv = TexturePoints::Constant(35, 2, 0.25);
    scene.materials.resize(1);
    scene.colliders.push_back({"ball", make_shape(ColliderDesc{})->surface(), {}});
    scene.frames = std::move(frames);
    scene.fields = vertex_field_names();
    return scene;
}

/// A frame's positions: of all magnitudes that a float has.
Points positions_of(const ExportScene& scene, std::int64_t frame) {
    Points positions = scene.topology.rest_positions;
    std::mt19937_64 random(static_cast<std::uint64_t>(frame) + 1);
    std::uniform_real_distribution<double> wide(-30.0, 30.0);
    for (Eigen::Index i = 0; i < positions.size(); ++i) positions.data()[i] += std::exp2(wide(random));
    return positions;
}

ExportFrame frame_of(const ExportScene& scene, std::int64_t index, const Points& positions) {
    const Eigen::Index n = positions.rows();
    return {index,
            scene.time(index),
            positions,
            Points::Zero(n, 3),
            {ColliderPose{}},
            {Vec3(0.0, 0.0, 3.0), Vec3::Zero(), Vec3::UnitY(), 35.0},
            [n](VertexField) { return VecX(VecX::Ones(n)); }};
}
ExportFrame frame_of(const ExportScene& scene, std::int64_t index) {
    return frame_of(scene, index, positions_of(scene, index));
}

/// What a double holds, to its ends.
Points extreme_positions(const ExportScene& scene) {
    Points positions = scene.topology.rest_positions;
    const std::int64_t frame = 0;
    std::mt19937_64 random(static_cast<std::uint64_t>(frame) + 1);
    std::uniform_real_distribution<double> wide(-300.0, 300.0);
    for (Eigen::Index i = 0; i < positions.size(); ++i) positions.data()[i] += std::exp2(wide(random));
    positions(0, 0) = -0.0;
    positions(0, 1) = 5e-324;
    positions(0, 2) = 1.7976931348623157e308;
    return positions;
}

std::vector<std::string> files_in(const TemporaryFolder& folder) {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder.path()))
        names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

/// Formats that read_mesh() reads, each file of which is a mesh.
std::vector<ExportFormat> mesh_formats() {
    std::vector<ExportFormat> found;
    for (const ExportFormat& format : export_formats())
        if (format.files == SequenceFiles::one_per_frame) found.push_back(format);
    return found;
}

/// The names that frames leave, and a .gltf's numbers.
std::vector<std::string> names_of(const ExportFormat& format, const std::vector<std::int64_t>& frames) {
    const std::string file = "m" + std::string(format.extension());
    std::vector<std::string> names;
    if (format.files != SequenceFiles::one_per_frame) names.push_back(file);
    for (const std::int64_t frame : frames) {
        if (format.files == SequenceFiles::one_per_frame)
            names.push_back(numbered_file(file, frame).string());
        if (format.files == SequenceFiles::one_per_frame_and_a_list)
            names.push_back(numbered_file("m.vtp", frame).string());
    }
    if (format.files == SequenceFiles::one_per_frame_and_a_list)
        names.push_back(numbered_file("m_colliders.vtp", frames.front()).string());
    std::sort(names.begin(), names.end());
    return names;
}

std::string file_name(const ExportFormat& format) {
    return "m" + std::string(format.extension());
}

}  // namespace

TEST_CASE("a mesh comes back from every format of meshes with every bit", "[exporters]") {
    const ExportScene scene = grid({0});
    REQUIRE(mesh_formats().size() == 2);
    for (const ExportFormat& format : mesh_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const fs::path file = folder / file_name(format);
        const Points positions = extreme_positions(scene);
        const auto exporter = format.make(file, FrameNames::as_given);
        exporter->begin(scene);
        exporter->frame(frame_of(scene, 0, positions));
        exporter->end();
        const MeshData back = read_mesh(file).mesh;
        CHECK(same_bits(back.positions, positions));
        CHECK(back.triangles == scene.topology.triangles);
        CHECK(same_bits(read_points(file).mesh.positions, positions));
        CHECK(files_in(folder) == std::vector{file_name(format)});  // no temporary file is left
    }
}

TEST_CASE("a sequence leaves the files that its format has, and nothing before its end", "[exporters]") {
    const std::vector<std::int64_t> frames{7, 8, 1234567};
    const ExportScene scene = grid(frames);
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const fs::path file = folder / file_name(format);
        const auto exporter = format.make(file, FrameNames::numbered);
        exporter->begin(scene);
        for (const std::int64_t frame : frames) exporter->frame(frame_of(scene, frame));
        for (const std::string& name : files_in(folder)) CHECK_THAT(name, Catch::EndsWith(".part"));
        exporter->end();
        CHECK(files_in(folder) == names_of(format, frames));
        if (format.files != SequenceFiles::one_per_frame) continue;
        for (const std::int64_t frame : frames) {
            const MeshData back = read_mesh(numbered_file(file, frame)).mesh;
            CHECK(same_bits(back.positions, positions_of(scene, frame)));
            CHECK(back.triangles == scene.topology.triangles);
        }
    }
}

TEST_CASE("a sequence that is not finished leaves what was there, and nothing else", "[exporters]") {
    const ExportScene scene = grid({0, 1});
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const std::string old = names_of(format, {1}).front();
        spit(folder / old, "old");
        {
            const auto exporter = format.make(folder / file_name(format), FrameNames::numbered);
            exporter->begin(scene);
            for (const std::int64_t frame : {0, 1}) exporter->frame(frame_of(scene, frame));
        }
        CHECK(files_in(folder) == std::vector{old});
        CHECK(slurp(folder / old) == "old");
    }
}

TEST_CASE("a mesh that cannot be written is told of by its name, and leaves no file", "[exporters]") {
    const ExportScene scene = grid({0});
    const auto refusal = [&](const ExportFormat& format, const fs::path& file) {
        return message_of(
            [&] {
                const auto exporter = format.make(file, FrameNames::as_given);
                exporter->begin(scene);
                exporter->frame(frame_of(scene, 0));
                exporter->end();
            },
            ExitCode::other);
    };
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        // A list of files is written last: the first that cannot be is one that it lists.
        const bool listed = format.files == SequenceFiles::one_per_frame_and_a_list;
        const fs::path nowhere = folder / ("none/" + file_name(format)), taken = folder / file_name(format);
        CHECK(refusal(format, nowhere) == "cannot write " +
                                              (listed ? folder / "none/m_000000.vtp" : nowhere).string() +
                                              ": No such file or directory");
        fs::create_directory(taken);
        CHECK(refusal(format, taken) == "cannot write " + taken.string() + ": Is a directory");
        CHECK(files_in(folder) == std::vector{file_name(format)});
    }
}

TEST_CASE("a cache of points refuses a scene of several cloths, and names them", "[exporters]") {
    ExportScene scene = grid({0});
    scene.topology.cloths = {{"front", 0, 20, 0, 20}, {"back", 20, 15, 20, 28}};
    const TemporaryFolder folder;
    for (const std::string format : {"pc2", "mdd"}) {
        const fs::path file = folder / ("m." + format);
        const auto exporter = export_format(format, "").make(file, FrameNames::numbered);
        CHECK(message_of([&] { exporter->begin(scene); }, ExitCode::usage) ==
              "--file " + file.string() + ": a " + (format == "pc2" ? "PC2" : "MDD") +
                  " holds the vertices of one object, and the run has 2 cloths; name one by --cloth, of "
                  "front, back");
    }
    CHECK(files_in(folder).empty());
}

TEST_CASE("a .glb that would be larger than one can be is refused before it is begun", "[exporters]") {
    // 40000 frames have 1.6e9 weights of 4 bytes.
    ExportScene scene = grid(std::vector<std::int64_t>(40000));
    const TemporaryFolder folder;
    const ExportFormat& gltf = export_format("gltf", "");
    const auto exporter = gltf.make(folder / "m.glb", FrameNames::numbered);
    CHECK(message_of([&] { exporter->begin(scene); }, ExitCode::usage) ==
          "--file " + (folder / "m.glb").string() +
              ": these 40000 frames take 6.4 GB, and a .glb holds 4.3 GB; name a .gltf, which holds any "
              "size, or fewer --frames");
    CHECK(files_in(folder).empty());
    CHECK_NOTHROW(gltf.make(folder / "m.gltf", FrameNames::numbered)->begin(scene));
}

TEST_CASE("a format is known by its name, or by a file's extension", "[exporters]") {
    std::set<std::string_view> names, extensions;
    for (const ExportFormat& format : export_formats()) {
        names.insert(format.name);
        for (const std::string_view each : format.extensions)
            if (!each.empty()) CHECK(extensions.insert(each).second);
        CHECK(format.extension().starts_with('.'));
        CHECK_FALSE(format.meaning.empty());
        CHECK(&export_format(format.name, "m.txt") == &format);
        CHECK(&export_format("", "a.b/" + file_name(format)) == &format);
        std::string shouted = file_name(format);
        for (char& c : shouted) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
        CHECK(&export_format("", shouted) == &format);
        CHECK_THAT(export_format_list(), Contains("\n" + std::string(format.name) + " ") ||
                                             Catch::StartsWith(std::string(format.name) + " "));
        CHECK_THAT(export_format_list(), Contains(std::string(format.meaning)));
    }
    CHECK(names.size() == export_formats().size());
    const std::string known = join(export_format_names());
    CHECK(message_of([] { export_format("", "m.clay"); }, ExitCode::usage) ==
          "--file m.clay: its extension is that of no mesh format; give --format, one of " + known);
    CHECK_THAT(message_of([] { export_format("", "obj"); }, ExitCode::usage), Contains("--file obj: "));
    CHECK(message_of([] { export_format("clay", "m.obj"); }, ExitCode::usage) ==
          "--format clay: is none of " + known);
}

TEST_CASE("the number of a frame stands before the extension", "[exporters]") {
    CHECK(numbered_file("out/sheet.obj", 12) == "out/sheet_000012.obj");
    CHECK(numbered_file("a.b/c.d.ply", 1234567) == "a.b/c.d_1234567.ply");
    CHECK(numbered_file("sheet", 0) == "sheet_000000");
}

TEST_CASE("files of a set have their names once all are written", "[file_io]") {
    const TemporaryFolder folder;
    {
        FileSet files;
        files.write(folder / "a", "1");
        files.write(folder / "b", "2");
        for (const std::string& name : files_in(folder)) CHECK_THAT(name, Catch::EndsWith(".part"));
        CHECK(files_in(folder).size() == 2);
        files.finish();
        CHECK(files_in(folder) == std::vector<std::string>{"a", "b"});
        files.write(folder / "a", "3");
    }
    CHECK(slurp(folder / "a") == "1");
    CHECK(files_in(folder) == std::vector<std::string>{"a", "b"});
}
