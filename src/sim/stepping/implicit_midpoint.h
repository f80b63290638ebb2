#pragma once
// Implicit midpoint, one stage (newton.h) to the middle of the step: y = q + h v, h = dt/2; then q' = 2x - q,
// v' = 2(x - q)/h - v, and the velocity filter.

#include "sim/stepping/step.h"

namespace cloth {

bool step_implicit_midpoint(Step& step);

}  // namespace cloth
