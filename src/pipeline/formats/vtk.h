#pragma once
// VTK's XML, for ParaView: a .vtp for each frame, and a .pvd that tells the time of each.

#include <filesystem>
#include <memory>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// Of sheet.pvd, or sheet.vtp, a sequence is sheet.pvd and sheet_000000.vtp …; the colliders are in
/// sheet_colliders_000000.vtp … (one file where they stand still), which is part 1 of the .pvd. A single
/// frame named .vtp is that file alone, cloths only.
///
/// A vertex has velocity [m/s], normal, uv and the scene's fields, a triangle the number of its cloth (or
/// collider) as `object`; the time [s] of cloths is the field TimeValue. Positions are doubles, all else
/// floats.
std::unique_ptr<Exporter> vtk_exporter(const std::filesystem::path& file, FrameNames names);

}  // namespace cloth::pipeline
