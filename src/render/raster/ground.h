#pragma once
// What stands between the light and the floor.

#include <vector>

#include "render/raster/ambient_occlusion.h"
#include "render/raster/projection.h"
#include "render/raster/shot.h"
#include "render/raster/tile_mask.h"

namespace cloth::render {

/// Squares of the picture at half its size, each of them in one of the two at most.
struct GroundTiles {
    TileMask shadowed;  ///< where shadow can fall on the floor
    TileMask occluded;  ///< where else objects can hide the sky from it
};
/// `tile`: pixels of the half picture along a square's side.
GroundTiles ground_tiles(const Shot& shot, const GroundPatch& patch, bool shadow, int tile);

/// Share of the sky's light that reaches the floor's patch, on a grid of `size` x `size`, rows by x. The
/// outermost are 1: clamping spreads that outwards.
std::vector<float> ground_openness(const Shot& shot, const GroundPatch& patch,
                                   const AmbientOcclusion& occlusion, int size);

}  // namespace cloth::render
