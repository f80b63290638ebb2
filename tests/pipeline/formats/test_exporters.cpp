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

Topology grid() {
    const MeshData mesh = make_grid({.size = {1.0, 0.7}, .resolution = {7, 5}});
    return {mesh.positions, mesh.triangles, {}};
}

/// A frame's positions: of all magnitudes, and the ends of what a double holds.
Points positions_of(const Topology& topology, std::int64_t frame) {
    Points positions = topology.rest_positions;
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

/// The mesh of a frame, from what a sequence left. A format of one file per sequence needs a reader here.
MeshData read_back(const ExportFormat& format, const fs::path& file, std::int64_t frame) {
    REQUIRE(format.files == SequenceFiles::one_per_frame);
    return read_mesh(numbered_file(file, frame)).mesh;
}

std::string file_name(const ExportFormat& format) {
    return "m" + std::string(format.extension);
}

}  // namespace

TEST_CASE("a mesh comes back from every format with every bit", "[exporters]") {
    const Topology topology = grid();
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const fs::path file = folder / file_name(format);
        const Points positions = positions_of(topology, 0);
        const auto exporter = format.make(file, FrameNames::as_given);
        exporter->begin(topology, 60.0);
        exporter->frame(0, 0.0, positions);
        exporter->end();
        const MeshData back = read_mesh(file).mesh;
        CHECK(same_bits(back.positions, positions));
        CHECK(back.triangles == topology.triangles);
        CHECK(same_bits(read_points(file).mesh.positions, positions));
        CHECK(files_in(folder) == std::vector{file_name(format)});  // no temporary file is left
    }
}

TEST_CASE("a sequence comes back from every format, frame by frame", "[exporters]") {
    const Topology topology = grid();
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const fs::path file = folder / file_name(format);
        const auto exporter = format.make(file, FrameNames::numbered);
        exporter->begin(topology, 60.0);
        for (const std::int64_t frame : {7, 8, 1234567})
            exporter->frame(frame, static_cast<double>(frame) / 60.0, positions_of(topology, frame));
        for (const std::string& name : files_in(folder)) CHECK_THAT(name, Catch::EndsWith(".part"));
        exporter->end();
        for (const std::int64_t frame : {7, 8, 1234567}) {
            const MeshData back = read_back(format, file, frame);
            CHECK(same_bits(back.positions, positions_of(topology, frame)));
            CHECK(back.triangles == topology.triangles);
        }
        CHECK(files_in(folder).size() == (format.files == SequenceFiles::one ? 1 : 3));
    }
}

TEST_CASE("a sequence that is not finished leaves what was there, and nothing else", "[exporters]") {
    const Topology topology = grid();
    for (const ExportFormat& format : export_formats()) {
        INFO(format.name);
        const TemporaryFolder folder;
        const fs::path file = folder / file_name(format);
        const std::string old = format.files == SequenceFiles::one
                                    ? file_name(format)
                                    : numbered_file(file, 1).filename().string();
        spit(folder / old, "old");
        {
            const auto exporter = format.make(file, FrameNames::numbered);
            exporter->begin(topology, 60.0);
            for (const std::int64_t frame : {0, 1})
                exporter->frame(frame, static_cast<double>(frame) / 60.0, positions_of(topology, frame));
        }
        CHECK(files_in(folder) == std::vector{old});
        CHECK(slurp(folder / old) == "old");
    }
}

TEST_CASE("a mesh that cannot be written is told of by its name, and leaves no file", "[exporters]") {
    const Topology topology = grid();
    const auto refusal = [&](const ExportFormat& format, const fs::path& file) {
        return message_of(
            [&] {
                const auto exporter = format.make(file, FrameNames::as_given);
                exporter->begin(topology, 60.0);
                exporter->frame(0, 0.0, topology.rest_positions);
                exporter->end();
            },
            ExitCode::other);
    };
    for (const ExportFormat& format : export_formats()) {
        const TemporaryFolder folder;
        const fs::path nowhere = folder / ("none/" + file_name(format)), taken = folder / file_name(format);
        CHECK(refusal(format, nowhere) == "cannot write " + nowhere.string() + ": No such file or directory");
        fs::create_directory(taken);
        CHECK(refusal(format, taken) == "cannot write " + taken.string() + ": Is a directory");
        CHECK(files_in(folder) == std::vector{file_name(format)});
    }
}

TEST_CASE("a format is known by its name, or by a file's extension", "[exporters]") {
    std::set<std::string_view> names, extensions;
    for (const ExportFormat& format : export_formats()) {
        names.insert(format.name);
        extensions.insert(format.extension);
        CHECK(format.extension.starts_with('.'));
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
    CHECK(extensions.size() == export_formats().size());
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
