#pragma once
// Polygons into triangles.

#include <array>
#include <span>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth::pipeline {

/// The largest polygon that is cut; time goes with the square of the corners.
inline constexpr std::size_t most_corners = 2000;

/// Triangles of a polygon, convex or not, by its corners counted from 0, wound as it is: ears are clipped,
/// the best shaped first, as seen along the polygon's mean normal (Newell's). A square is cut from its first
/// corner. Empty where the polygon crosses itself or has no area. Requires 3 … most_corners corners, finite.
std::vector<std::array<int, 3>> triangulate(std::span<const Vec3> polygon);

}  // namespace cloth::pipeline
