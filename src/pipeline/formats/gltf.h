#pragma once
// glTF 2.0: a run as an animation. One node a cloth, whose mesh is that of the first frame with a morph
// target for each later one; their weights go from one to the next, linearly, so that it stands as simulated
// at each frame's time. A collider is a node that is moved, turned and, while it is off, scaled to nothing;
// the camera another.

#include <filesystem>
#include <memory>

#include "pipeline/formats/exporter.h"
#include "pipeline/formats/file_per_frame.h"

namespace cloth::pipeline {

/// `file` with the extension .gltf: a text, with its numbers in a .bin beside it; else all in one, a .glb,
/// which holds at most 4 GiB: more is refused.
std::unique_ptr<Exporter> gltf_exporter(const std::filesystem::path& file, FrameNames names);

}  // namespace cloth::pipeline
