#pragma once
// Memory of a run that is no part of its state: results do not depend on it.

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/model.h"
#include "sim/stepping/linear_solvers.h"
#include "sim/stepping/newton.h"
#include "sim/stepping/terms.h"

namespace cloth {

struct Workspace {
    /// `model` must outlive this.
    explicit Workspace(const Model& model);

    /// Makes the solver leave out the vertices of `pins` and no others.
    void leave_out(const std::vector<Pin>& pins);

    Terms terms;
    BlockPattern near;  ///< that factors for conjugate gradients begin with
    std::unique_ptr<LinearSolver> solver;
    std::vector<int> pinned;  ///< those that `solver` leaves out
    std::vector<Hold> holds;  ///< from outside, see Simulation::hold()
    NewtonWorkspace newton;
    std::optional<std::vector<std::uint8_t>> checked;  ///< colliders that were on when overlap was checked
};

}  // namespace cloth
