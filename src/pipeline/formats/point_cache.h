#pragma once
// PC2 and MDD: vertices over time, as floats, for a mesh that another file has.
//
// PC2 (lower byte first): "POINTCACHE2", 0, int 1, int vertices, float first frame, float 1 (frames between
// samples), int samples; then x y z of each vertex, sample by sample.
// MDD (higher byte first): int samples, int vertices, float time of each [s]; then the same.

#include <filesystem>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// Both refuse a scene of several cloths (a cache belongs to one object).
std::unique_ptr<Exporter> pc2_exporter(const std::filesystem::path& file, FrameNames names);
std::unique_ptr<Exporter> mdd_exporter(const std::filesystem::path& file, FrameNames names);

}  // namespace cloth::pipeline
