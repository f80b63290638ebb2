#pragma once
// The formats that meshes are written in. A new one is a file pair here and a row in exporters.cpp.

#include <array>
#include <filesystem>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// What a sequence becomes.
enum class SequenceFiles {
    one_per_frame,             ///< numbered_file() for each
    one_per_frame_and_a_list,  ///< and one of the name that was given
    one,                       ///< all frames in one file
};

struct ExportFormat {
    std::string_view name;  ///< as --format has it
    std::array<std::string_view, 2>
        extensions;            ///< of its files: in lower case, with dots; the usual one first
    std::string_view meaning;  ///< in a few words
    SequenceFiles files;
    /// What writes `file`. With SequenceFiles::one it has the name that was given, whatever `names` says.
    std::unique_ptr<Exporter> (*make)(const std::filesystem::path& file, FrameNames names);

    std::string_view extension() const { return extensions[0]; }
    bool has(std::string_view extension) const;
};

std::span<const ExportFormat> export_formats();
/// "obj", "ply", …
std::vector<std::string> export_format_names();
/// The format of this name; for an empty name, the one one of whose extensions (in any case) `file` has.
/// Throws Error(usage) naming those there are.
const ExportFormat& export_format(std::string_view name, const std::filesystem::path& file);
/// A line for each: name, extensions, meaning, files of a sequence.
std::string export_format_list();

}  // namespace cloth::pipeline
