#pragma once
// Flat pieces of cloth, filled with triangles.

#include <array>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth::pipeline {

struct PlanarMesh {
    std::vector<Vec2> points;                   ///< the polygon's corners, then points inside
    std::vector<std::array<int, 3>> triangles;  ///< counter-clockwise
};

/// Fills a polygon with nearly equilateral triangles of about `edge_length`: points of a triangular lattice
/// inside, a constrained Delaunay triangulation, and some rounds of each point to the middle of its
/// neighbours. Its own edges stay whole: who wants small triangles there gives short ones. No triangles where
/// the polygon crosses itself or has no area. Requires 3 … most_corners (triangulate.h) corners, finite.
PlanarMesh fill_polygon(const std::vector<Vec2>& polygon, double edge_length);

}  // namespace cloth::pipeline
