#pragma once
// One time step.

#include <memory>
#include <optional>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/sparse_solver.h"
#include "sim/contact/barrier_contact.h"
#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/scene/state.h"
#include "sim/stepping/contact_solver.h"
#include "sim/stepping/step_report.h"

namespace cloth {

/// Memory of a step, sized once.
struct Workspace {
    explicit Workspace(const Model& model);

    std::vector<int> pinned;  ///< those that `solver` leaves out
    SparseSolver solver;
    BlockMatrix system;  ///< M + h² H
    BlockMatrix exact_system,
        blended_system;       ///< the same with other kinds of H, where the first is indefinite
    bool indefinite = false;  ///< the exact system was, when it was last looked at
    std::vector<std::unique_ptr<StageEnergy>> stage_energies;
    std::optional<BarrierContact> contact;  ///< of contact = "barrier"
    ContactWorkspace contact_work;
    std::optional<std::vector<std::uint8_t>> checked;  ///< colliders that were on when overlap was checked
    VecX gradient, rhs, velocity, momentum, direction, positions, trial, start;
};

/// A step starts with events, picking and detection at the old positions.
///
/// linearly_implicit_euler solves (M + dt² H) v' = M v - dt ∇V once, at the old positions; then the velocity
/// filter; then q += dt v'.
///
/// The others are built from stages. A stage minimises
///
///     Φ(x) = ½ (x-y)ᵀM(x-y)/h² - f·x + V(x)
///
/// over the positions x by Newton's method with a backtracking line search, until |∇Φ| ≤ tolerance · |∇Φ at
/// the step's old positions| (at least a hundredth of the cloth's weight). It takes the exact Hessian where M
/// + h² H is positive definite and one nearer to the projected one where it is not: always projecting costs
/// the quadratic convergence. Its velocities are (x - base)/h.
///
///   implicit_euler     base = q, h = dt, y = q + dt v
///   implicit_midpoint  base = q, h = dt/2, y = q + h v; then q' = 2x - q
///   tr_bdf2            two stages of h = (1 - 1/√2) dt, which is γ dt/2 with γ = 2 - √2 (Bank et al. 1985,
///                      Transient simulation of silicon devices and circuits).
///                      To t + γ dt by the trapezoidal rule: base = q, y = q + 2h v, f = -∇V(q); q_γ = x and
///                      v_γ = (x - q)/h - v. Dissipation (viscosity, air) is left out of f, and taken twice
///                      in V instead, at the mean velocity (x - q)/(2h).
///                      To t + dt by BDF2: base = c₁ q_γ - c₀ q, y = base + h (c₁ v_γ - c₀ v), f = 0, with
///                      c₁ = 1/(γ(2-γ)), c₀ = (1-γ)²/(γ(2-γ)).
///
/// A step that does not converge is undone and made in two halves, each of which may be halved in turn; past
/// `retries` halvings the state is left as it was and the report says converged = false.
///
/// With contact = "barrier" the stages are minimised by contact_solver.h; a step that starts with an overlap
/// (the first, or one before which a collider was switched) throws OverlapError.
StepReport advance(const Model& model, State& state, Workspace& workspace);

/// ½ q̇ᵀMq̇ + V(q), drags and penalty contact included [J].
double total_energy(const Model& model, const State& state);

/// ½ q̇ᵀMq̇ [J]
double kinetic_energy(const Model& model, const State& state);

}  // namespace cloth
