#pragma once
// The shadow of cloth under light from straight above, and what it says of how the cloth drapes.

#include "sim/algebra/types.h"

namespace cloth {

/// Area of the shadow on a level floor [m²]: of the squares of side `cell` [m] those whose middle lies in it.
/// `positions`: shape (3n) [m]. Throws std::invalid_argument where it is larger than 2^28 cells.
double shadow_area(const VecRef& positions, const Triangles& triangles, double cell);

/// Sum of the triangles' areas [m²]. `positions`: shape (3n) [m].
double surface_area(const VecRef& positions, const Triangles& triangles);

/// Share of the overhanging cloth's area that its shadow keeps [%]: 100 (shadow - pedestal) / (flat -
/// pedestal), areas in [m²]; `pedestal` is what carries the cloth, `flat` the cloth spread out.
/// (Cusick 1968; BS 5058.)
double drape_coefficient(double shadow, double pedestal, double flat);

}  // namespace cloth
