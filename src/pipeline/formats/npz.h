#pragma once
// NumPy's .npz: arrays by name, each an .npy in an uncompressed zip.

#include <filesystem>
#include <memory>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// positions and velocities (frames, n, 3) [m], [m/s]; times (frames) [s]; frames (frames); frame_rate ();
/// rest_positions (n, 3) [m]; triangles (m, 3); uv (n, 2); cloth_names (cloths) in UTF-8,
/// cloth_first_vertex and cloth_first_triangle (cloths + 1): cloth c has the vertices from entry c up to the
/// next. Doubles, and integers of 32 or (frames) 64 bits.
std::unique_ptr<Exporter> npz_exporter(const std::filesystem::path& file, FrameNames names);

}  // namespace cloth::pipeline
