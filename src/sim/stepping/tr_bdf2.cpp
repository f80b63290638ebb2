#include "sim/stepping/tr_bdf2.h"

#include <algorithm>
#include <cmath>

namespace cloth {

bool step_tr_bdf2(Step& step) {
    State& state = step.state;
    Terms& terms = step.workspace.terms;
    const double dt = step.dt;
    const double root2 = std::sqrt(2.0), gamma = 2.0 - root2, h = 0.5 * gamma * dt;
    const FilterOfStep filter(step);
    const VecX q = state.positions, v = state.velocities;

    // The forces at the start, dissipation apart: that of the first stage is taken at its mean velocity.
    VecX force;
    {
        const VecX before = q - h * v;
        terms.begin({{{1.0, before}}, h, state.time, state}, 0.0);
        terms.gradient(q, force);
        if (terms.barrier()) terms.barrier()->add_gradient(q, force);
        force *= -1.0;
        zero_pinned(step.pins, force);
    }
    VecX x = q, v_gamma;
    {
        terms.begin({{{1.0, q}}, 2.0 * h, state.time + gamma * dt, state}, 2.0);
        step.report.contacts = std::max(step.report.contacts, terms.penalty_contacts());
        std::vector<Pin> part = step.pins;
        for (Pin& pin : part) {
            const Vec3 from = q.segment<3>(3 * pin.vertex);
            if (pin.position != from) pin.position = from + gamma * (pin.position - from);
        }
        if (!minimize(step, part, h, q + 2.0 * h * v, x, force)) return false;
        v_gamma = (x - q) / h - v;
        for (const Pin& pin : step.pins) v_gamma.segment<3>(3 * pin.vertex) = v.segment<3>(3 * pin.vertex);
    }
    const double c1 = 1.0 / (gamma * (2.0 - gamma)), c0 = (1.0 - gamma) * (1.0 - gamma) * c1;
    const VecX x_gamma = x;
    const Stage stage{{{c1, x_gamma}, {-c0, q}}, h, state.time + dt, state, state.time + gamma * dt, x_gamma};
    terms.begin(stage);
    const VecX base = stage.base();
    if (!minimize(step, step.pins, h, base + h * (c1 * v_gamma - c0 * v), x)) return false;
    state.velocities = (x - base) / h;
    set_pinned_velocities(step.pins, q, dt, state.velocities);
    filter.apply(dt, x, state.velocities);
    state.positions = x;
    return true;
}

}  // namespace cloth
