#pragma once
// USD as text: a run as time samples.

#include <filesystem>
#include <memory>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// /World has a Mesh for each cloth (points and normals at each frame, primvars:st) and collider (a transform
/// at each frame, invisible while it is off), a Camera, and /World/Materials a UsdPreviewSurface for each.
/// Metres, y up; the time code is the frame, of which timeCodesPerSecond = frame rate make a second.
std::unique_ptr<Exporter> usda_exporter(const std::filesystem::path& file, FrameNames names);

}  // namespace cloth::pipeline
