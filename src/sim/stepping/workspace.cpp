#include "sim/stepping/workspace.h"

namespace cloth {

Workspace::Workspace(const Model& model) : terms(model), pinned(model.pinned) {
    if (terms.barrier()) {
        near = without_second_ring(model.pattern, model.triangles);
        solver = std::make_unique<ConjugateGradients>(model.pattern, near);
    } else {
        solver = std::make_unique<DirectSolver>(model.pattern);
    }
    solver->leave_out(pinned);
}

void Workspace::leave_out(const std::vector<Pin>& pins) {
    std::vector<int> vertices;
    for (const Pin& pin : pins) vertices.push_back(pin.vertex);
    if (vertices == pinned) return;
    pinned = std::move(vertices);
    solver->leave_out(pinned);
}

}  // namespace cloth
