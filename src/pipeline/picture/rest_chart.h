#pragma once
// Where a cloth's vertices lie in its rest shape, as in a pattern on a table.

#include "sim/algebra/types.h"

namespace cloth::pipeline {

/// Rest shape → the plane that it lies in, or nearly: u along x as far as that goes, v upwards from there,
/// shape (n, 2) [m].
Eigen::Matrix<double, Eigen::Dynamic, 2> rest_chart(const Points& rest, const Triangles& triangles);

}  // namespace cloth::pipeline
