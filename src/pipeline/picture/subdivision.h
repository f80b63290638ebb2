#pragma once
// Loop subdivision of the drawn surface: a sheet's triangles are a coarse sample of a smooth surface, and lit
// as they are they show as a saw along sharp folds. Loop 1987, Smooth Subdivision Surfaces Based on
// Triangles; rims by Hoppe et al. 1994, so that a sheet's outline depends on its rim alone.

#include <Eigen/SparseCore>

#include "sim/algebra/types.h"

namespace cloth::pipeline {

struct Subdivision {
    Eigen::SparseMatrix<double, Eigen::RowMajor>
        weights;  ///< fine positions (n', 3) = weights · coarse (n, 3)
    Eigen::SparseMatrix<double, Eigen::RowMajor>
        flat;             ///< the same points where they lie on the coarse triangles
    Triangles triangles;  ///< of the fine surface, same orientation: 4^steps of each coarse one in a row
};

/// `steps` times over: each triangle becomes four. A rim vertex where the rest shape's rim turns by more than
/// 45° (the corner of a sheet) stays where it is. Requires a manifold mesh; 0 steps give the identity.
Subdivision subdivide(const Points& rest, const Triangles& triangles, int steps);

}  // namespace cloth::pipeline
