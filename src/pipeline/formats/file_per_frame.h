#pragma once
// The exporter of formats whose files hold one mesh each.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/mesh_draft.h"

namespace cloth::pipeline {

enum class FrameNames {
    as_given,  ///< for a single frame
    numbered,  ///< as numbered_file() says
};

/// sheet.obj → sheet_000012.obj, in the same folder.
std::filesystem::path numbered_file(const std::filesystem::path& file, std::int64_t frame);

/// What a file of a format holds for a mesh.
using MeshBytes = std::string (*)(const MeshOut& mesh);

std::unique_ptr<Exporter> file_per_frame(MeshBytes bytes, const std::filesystem::path& file,
                                         FrameNames names);

}  // namespace cloth::pipeline
