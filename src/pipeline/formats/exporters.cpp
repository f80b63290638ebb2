#include "pipeline/formats/exporters.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/gltf.h"
#include "pipeline/formats/npz.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/ply.h"
#include "pipeline/formats/point_cache.h"
#include "pipeline/formats/usda.h"
#include "pipeline/formats/vtk.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The maker of a format whose files hold one mesh each.
template <MeshBytes bytes>
std::unique_ptr<Exporter> each_frame(const fs::path& file, FrameNames names) {
    return file_per_frame(bytes, file, names);
}

constexpr std::array formats{
    ExportFormat{"obj",
                 {".obj"},
                 "Wavefront OBJ: every digit, normals, texture coordinates, an object a cloth",
                 SequenceFiles::one_per_frame,
                 each_frame<obj_text>},
    ExportFormat{"ply",
                 {".ply"},
                 "binary PLY of doubles, with normals and texture coordinates",
                 SequenceFiles::one_per_frame,
                 each_frame<ply_bytes>},
    ExportFormat{"pc2",
                 {".pc2"},
                 "vertices over time as floats, for a mesh of one cloth",
                 SequenceFiles::one,
                 pc2_exporter},
    ExportFormat{
        "mdd", {".mdd"}, "the same with times, as other programs have it", SequenceFiles::one, mdd_exporter},
    ExportFormat{"gltf",
                 {".glb", ".gltf"},
                 "glTF 2.0: cloths as an animation, colliders, materials, camera",
                 SequenceFiles::one,
                 gltf_exporter},
    ExportFormat{"vtk",
                 {".pvd", ".vtp"},
                 "VTK XML for ParaView: stretch, curvature, gap, velocity; colliders",
                 SequenceFiles::one_per_frame_and_a_list,
                 vtk_exporter},
    ExportFormat{"usda",
                 {".usda"},
                 "USD as text: cloths as time samples, colliders, materials, camera",
                 SequenceFiles::one,
                 usda_exporter},
    ExportFormat{"npz",
                 {".npz"},
                 "arrays for NumPy: positions, velocities, times, triangles, uv",
                 SequenceFiles::one,
                 npz_exporter},
};

}  // namespace

bool ExportFormat::has(std::string_view extension) const {
    return !extension.empty() &&
           std::find(extensions.begin(), extensions.end(), extension) != extensions.end();
}

std::span<const ExportFormat> export_formats() {
    return formats;
}

std::vector<std::string> export_format_names() {
    std::vector<std::string> names;
    for (const ExportFormat& format : formats) names.emplace_back(format.name);
    return names;
}

const ExportFormat& export_format(std::string_view name, const fs::path& file) {
    const std::string extension = extension_of(file);
    for (const ExportFormat& format : formats)
        if (name.empty() ? format.has(extension) : format.name == name) return format;
    const std::string known = join(export_format_names());
    if (!name.empty()) throw Error(ExitCode::usage, fmt::format("--format {}: is none of {}", name, known));
    throw Error(ExitCode::usage, fmt::format("--file {}: its extension is that of no mesh format; give "
                                             "--format, one of {}",
                                             file.string(), known));
}

std::string export_format_list() {
    const auto files = [](SequenceFiles kind) {
        return kind == SequenceFiles::one             ? "a file for all frames"
               : kind == SequenceFiles::one_per_frame ? "a file per frame"
                                                      : "a file per frame and one that lists them";
    };
    std::string list;
    for (const ExportFormat& format : formats) {
        std::string extensions;
        for (const std::string_view each : format.extensions)
            if (!each.empty()) extensions += (extensions.empty() ? "" : " ") + std::string(each);
        list +=
            fmt::format("{:<8}{:<12}{}; {}\n", format.name, extensions, format.meaning, files(format.files));
    }
    return list;
}

}  // namespace cloth::pipeline
