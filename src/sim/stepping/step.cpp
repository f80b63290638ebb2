#include "sim/stepping/step.h"

#include <algorithm>

namespace cloth {

bool minimize(Step& step, const std::vector<Pin>& pins, double h, const VecX& y, VecX& x, const VecX& force) {
    Workspace& w = step.workspace;
    const StepReport solve = minimize({step.model, w.terms, pins, h, y, force}, *w.solver, w.newton, x);
    merge(step.report, solve);
    return solve.converged;
}

FilterOfStep::FilterOfStep(Step& step) {
    const Scene& scene = step.model.scene;
    if (scene.simulation.contact != ContactKind::velocity_filter) return;
    contacts_ = find_filter_contacts(scene.colliders, touched_colliders(step.model, step.state),
                                     step.state.positions);
    step.report.contacts = std::max(step.report.contacts, static_cast<int>(contacts_.size()));
}

void FilterOfStep::apply(VecX& v) const {
    filter_velocities(contacts_, v);
}

void FilterOfStep::apply(double h, VecX& x, VecX& v) const {
    if (contacts_.empty()) return;
    VecX filtered = v;
    filter_velocities(contacts_, filtered);
    x += h * (filtered - v);
    v = filtered;
}

void set_pinned_velocities(const std::vector<Pin>& pins, const VecX& start, double dt, VecX& v) {
    for (const Pin& pin : pins) {
        v.segment<3>(3 * pin.vertex) = (pin.position - start.segment<3>(3 * pin.vertex)) / dt;
    }
}

}  // namespace cloth
