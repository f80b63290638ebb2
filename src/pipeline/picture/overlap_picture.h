#pragma once
// A picture of the place where a step starts with things that overlap.

#include "pipeline/scene_file/scene_file.h"
#include "render/image/image.h"
#include "render/raster/rasterizer.h"
#include "sim/contact/overlap.h"
#include "sim/model.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

/// The camera near the triangles, from where they show most of their faces; cloth around them in a third of
/// the picture to each side.
CameraDesc overlap_camera(const SceneFile& file, const OverlapError& overlap);

/// Cloth and colliders in grey with the edges of the simulated triangles; those that overlap in red over it,
/// also where they are hidden. Requires at least one triangle. Throws as Rasterizer::draw().
render::Image draw_overlap(const SceneFile& file, const Model& model, const State& state,
                           const OverlapError& overlap, render::Rasterizer& rasterizer);

}  // namespace cloth::pipeline
