#pragma once
// Minimises a stage's incremental potential (integrator.h) among barriers, without ever passing through one.

#include <optional>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/sparse_solver.h"
#include "sim/contact/barrier_contact.h"
#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/stepping/potential.h"
#include "sim/stepping/step_report.h"

namespace cloth {

/// What to minimise over x:  ½ (x-y)ᵀM(x-y)/h² - f·x + V(x) + contact(x).
struct ContactProblem {
    const Model& model;
    const Potential& potential;  ///< all but contact
    BarrierContact& contact;
    const std::vector<Pin>& pins;
    double h;           ///< [s]
    const VecX& y;      ///< shape (3n) [m]
    const VecX& force;  ///< f, shape (3n) or empty [N]
};

/// Memory of the solves.
struct ContactWorkspace {
    std::optional<SparseSolver> single;  ///< of single precision, the same vertices left out as in the other
    BlockMatrix system, exact, projected;
    ExtraBlocks extra;
    VecX gradient, rhs, direction, product, residual, preconditioned, conjugate, trial, momentum, start;
};

/// From the allowed positions x to the minimum.
///
/// 1. Pins and colliders go to where they are at the stage's end, together with what the cloth's stiffness
///    and the contacts make of their way, as far as is free at a time.
/// 2. First guess: inertia's and gravity's, each vertex stopped where it would meet something.
/// 3. Newton's method. Each step is shortened to what continuous collision detection says is free, then by
///    Armijo's rule. The linear system is solved by conjugate gradients on the whole matrix, preconditioned
///    by a Cholesky factor of its part within the fixed pattern (all but the blocks that couple the two sides
///    of a contact), in single precision where that serves.
///    It ends at the residual asked for, or after a step slower than the scene's newton_speed once no cloth
///    as a whole is left with a force that matters: inner forces cancel in it, so what is left is missing
///    impact, weight or friction, which a stiff contact would hide from the size of the step.
StepReport minimize_with_contact(const ContactProblem& problem, SparseSolver& solver, VecX& x,
                                 ContactWorkspace& w);

}  // namespace cloth
