#pragma once
// Normals of a surface at its vertices.

#include "sim/algebra/types.h"

namespace cloth {

/// Of each vertex, weighted by the areas around it; unit length. Where its triangles fold flat any will do:
/// +y.
Points vertex_normals(const Points& positions, const Triangles& triangles);

}  // namespace cloth
