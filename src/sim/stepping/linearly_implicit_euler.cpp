#include "sim/stepping/linearly_implicit_euler.h"

namespace cloth {

bool step_linearly_implicit_euler(Step& step) {
    const Model& model = step.model;
    State& state = step.state;
    const double dt = step.dt;
    Terms& terms = step.workspace.terms;
    NewtonWorkspace& w = step.workspace.newton;
    LinearSolver& solver = *step.workspace.solver;

    const VecX start = state.positions;
    terms.begin({{{1.0, start}}, dt, state.time + dt, state});
    const FilterOfStep filter(step);
    step.report.contacts = std::max(step.report.contacts, terms.penalty_contacts());

    const HessianKind kind = model.scene.simulation.hessian == LinearHessian::assignment
                                 ? HessianKind::assignment
                                 : HessianKind::projected;
    terms.hessian(start, kind, w.system.inside);
    add_inertia(model, dt, w.system.inside);
    terms.gradient(start, w.gradient);
    multiply(model.pattern, model.mass, state.velocities, w.rhs);
    w.rhs -= dt * w.gradient;
    ++step.report.iterations;
    if (!solver.factorize(w.system, true, step.report)) return false;

    // Pins that move take their neighbours along.
    w.trial.setZero(w.rhs.size());
    set_pinned_velocities(step.pins, start, dt, w.trial);
    if (!w.trial.isZero(0.0)) {
        multiply(model.pattern, w.system, w.trial, w.product);
        w.rhs -= w.product;
    }
    VecX velocities;
    if (!solver.solve(w.rhs, 0.0, velocities, step.report)) return false;
    filter.apply(velocities);
    set_pinned_velocities(step.pins, start, dt, velocities);

    state.positions += dt * velocities;
    state.velocities = std::move(velocities);
    return true;
}

}  // namespace cloth
