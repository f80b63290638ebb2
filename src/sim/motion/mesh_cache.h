#pragma once
// Meshes that bend: where a collider's cache has its vertices at a time.

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Frames per second of a cache that says nothing of it.
inline constexpr double usual_cache_rate = 24.0;

/// Place of the vertices at `time` of the run: linear between the cache's frames, scaled, turned and moved as
/// the collider says, but without its path and spin; shape (n, 3) [m]. Requires a cache.
Points cached_vertices(const ColliderDesc& collider, double time);

/// When the last frame stands [s]; of one that loops, never: infinite.
double cache_end(const ColliderDesc& collider);

}  // namespace cloth
