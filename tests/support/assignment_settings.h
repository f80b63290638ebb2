#pragma once
// How the assignment steps.

#include "sim/scene/scene.h"

namespace cloth::testing {

/// One linear solve a step, and velocities filtered at colliders; cloth does not feel itself.
inline SimulationDesc assignment_settings() {
    SimulationDesc s;
    s.integrator = IntegratorKind::linearly_implicit_euler;
    s.contact = ContactKind::velocity_filter;
    return s;
}

}  // namespace cloth::testing
