#pragma once
// The assignment's step: (M + dt² H) v' = M v - dt ∇V, solved once, at the old positions; then the velocity
// filter; then q += dt v'.

#include "sim/stepping/step.h"

namespace cloth {

bool step_linearly_implicit_euler(Step& step);

}  // namespace cloth
