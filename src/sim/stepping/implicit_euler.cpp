#include "sim/stepping/implicit_euler.h"

#include <algorithm>

namespace cloth {

bool step_implicit_euler(Step& step) {
    State& state = step.state;
    const double dt = step.dt;
    Terms& terms = step.workspace.terms;
    terms.begin({{{1.0, state.positions}}, dt, state.time + dt, state});
    const FilterOfStep filter(step);
    step.report.contacts = std::max(step.report.contacts, terms.penalty_contacts());
    VecX x = state.positions;
    if (!minimize(step, step.pins, dt, state.positions + dt * state.velocities, x)) return false;
    state.velocities = (x - state.positions) / dt;
    filter.apply(dt, x, state.velocities);
    state.positions = x;
    return true;
}

}  // namespace cloth
