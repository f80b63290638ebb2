#pragma once
// Implicit Euler, one stage (newton.h): y = q + dt v, h = dt; then q' = x, v' = (x - q)/dt, and the velocity
// filter.

#include "sim/stepping/step.h"

namespace cloth {

bool step_implicit_euler(Step& step);

}  // namespace cloth
