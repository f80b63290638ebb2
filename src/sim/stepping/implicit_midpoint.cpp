#include "sim/stepping/implicit_midpoint.h"

#include <algorithm>

namespace cloth {

bool step_implicit_midpoint(Step& step) {
    State& state = step.state;
    const double h = 0.5 * step.dt;
    Terms& terms = step.workspace.terms;
    terms.begin({{{1.0, state.positions}}, h, state.time + h, state});
    const FilterOfStep filter(step);
    step.report.contacts = std::max(step.report.contacts, terms.penalty_contacts());
    // Half of the way for the pins too.
    std::vector<Pin> half = step.pins;
    for (Pin& pin : half) {
        pin.position = 0.5 * (pin.position + Vec3(state.positions.segment<3>(3 * pin.vertex)));
    }
    VecX x = state.positions;
    if (!minimize(step, half, h, state.positions + h * state.velocities, x)) return false;
    VecX velocities = 2.0 / h * (x - state.positions) - state.velocities;
    x = 2.0 * x - state.positions;
    set_pinned_velocities(step.pins, state.positions, step.dt, velocities);
    place_pinned(step.pins, x);
    filter.apply(step.dt, x, velocities);
    state.positions = x;
    state.velocities = velocities;
    return true;
}

}  // namespace cloth
