#include "pipeline/formats/exporters.h"

#include <fmt/format.h>

#include <array>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/obj.h"
#include "pipeline/formats/ply.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The maker of a format whose files hold one mesh each.
template <MeshBytes bytes>
std::unique_ptr<Exporter> each_frame(const fs::path& file, FrameNames names) {
    return file_per_frame(bytes, file, names);
}

constexpr std::array formats{
    ExportFormat{"obj", ".obj", "Wavefront OBJ, every digit", SequenceFiles::one_per_frame,
                 each_frame<obj_text>},
    ExportFormat{"ply", ".ply", "PLY in ASCII, every digit", SequenceFiles::one_per_frame,
                 each_frame<ply_text>},
};

}  // namespace

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
        if (name.empty() ? format.extension == extension : format.name == name) return format;
    const std::string known = join(export_format_names());
    if (!name.empty()) throw Error(ExitCode::usage, fmt::format("--format {}: is none of {}", name, known));
    throw Error(ExitCode::usage, fmt::format("--file {}: its extension is that of no mesh format; give "
                                             "--format, one of {}",
                                             file.string(), known));
}

std::string export_format_list() {
    std::string list;
    for (const ExportFormat& format : formats)
        list +=
            fmt::format("{:<16}{:<8}{}; {}\n", format.name, format.extension, format.meaning,
                        format.files == SequenceFiles::one ? "a file for all frames" : "a file per frame");
    return list;
}

}  // namespace cloth::pipeline
