#pragma once
// Newton's method for a stage: from allowed positions to the minimum of its incremental potential
//
//     Φ(x) = ½ (x-y)ᵀM(x-y)/h² - f·x + V(x)
//
// where V holds every energy, barrier contact included where there is any.
//
// 1. Placing: pins and colliders go to where they are at the stage's end, by the first guess where the way
//    there is free, else together with what the cloth's stiffness and the contacts make of their way, as far
//    as is free at a time.
// 2. First guess: y; among barriers y and gravity's fall, else y alone, each vertex stopped where it would
//    meet something.
// 3. Newton steps. Near the minimum by as large a share of the exact Hessian as leaves M + h² H positive
//    definite: near a bifurcation (a sheet about to buckle) a full projection hides the soft direction, and
//    always projecting costs the quadratic convergence. Each step is shortened to what continuous collision
//    detection says is free, then by Armijo's rule, until the StoppingRule holds.

#include <algorithm>
#include <atomic>
#include <vector>

#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/stepping/linear_solvers.h"
#include "sim/stepping/step_report.h"
#include "sim/stepping/terms.h"

namespace cloth {

struct NewtonProblem {
    const Model& model;
    Terms& terms;                  ///< told of the stage
    const std::vector<Pin>& pins;  ///< where they are held at the stage's end
    double h;                      ///< [s]
    const VecX& y;                 ///< shape (3n) [m]
    const VecX& force;             ///< f, shape (3n) or empty [N]
};

/// When a minimisation ends. |∇Φ| is that of the free vertices.
struct StoppingRule {
    StoppingLimits limits{};
    double scale = 0.0;  ///< |∇Φ| where it started, at least a hundredth of the cloth's weight [N]
    double own = 0.0;    ///< the cloth's speed in this stage, root of the mean square [m/s]

    bool converged(double gradient) const { return gradient <= limits.tolerance * scale; }
    /// Near enough for the exact Hessian.
    bool near(double gradient) const { return gradient < 1e-2 * scale; }
    double speed() const { return std::max(limits.speed, limits.share * own); }
    /// `way`: the greatest of any vertex in a step of length h.
    bool slow(double way, double h) const { return way < speed() * h; }
    /// No cloth as a whole is left with a force that matters: inner forces cancel in it, so what is left is
    /// missing impact, weight or friction, which a stiff contact would hide from the size of the step.
    /// `net`: greatest change of any cloth's mean velocity by the forces left [m/s].
    bool at_rest(double net) const { return net < 0.01 * speed(); }
    /// Of positions as large as `extent`, rounding alone is worth this much gradient (`stiffness`: norm of
    /// the Hessian's diagonal [N/m]) or this long a step: nothing smaller can be asked for.
    bool lost_in_rounding(double gradient, double stiffness, double way, double extent) const {
        return gradient <= 4e-16 * extent * stiffness || way < 1e-14 * extent;
    }
};

/// Memory of the solves, sized by the first.
struct NewtonWorkspace {
    SystemMatrix system;
    BlockMatrix exact, projected;  ///< what `system` is mixed of where the exact one is indefinite
    bool indefinite = false;       ///< it was, when last looked at
    VecX gradient, rhs, direction, product, residual, momentum, trial, start, before;
    const std::atomic<bool>* stop = nullptr;  ///< looked at before every iteration; null: nobody stops

    bool stopping() const { return stop != nullptr && stop->load(std::memory_order_relaxed); }
};

/// Takes x from allowed positions to the minimum. Where the report says that it did not converge, x is of no
/// use.
StepReport minimize(const NewtonProblem& problem, LinearSolver& solver, NewtonWorkspace& workspace, VecX& x);

/// Makes A, which holds a Hessian H, M + h² H.
void add_inertia(const Model& model, double h, BlockMatrix& A);

}  // namespace cloth
