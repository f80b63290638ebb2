#pragma once
// One time step.

#include <vector>

#include "sim/block_matrix.h"
#include "sim/model.h"
#include "sim/sparse_solver.h"
#include "sim/state.h"

namespace cloth {

struct StepReport;

/// Memory of a step, sized once.
struct Workspace {
    explicit Workspace(const Model& model);

    SparseSolver solver;
    BlockMatrix system;  ///< M + dt² H
    BlockMatrix exact_system,
        blended_system;  ///< the same with other kinds of H, where the first is indefinite
    VecX gradient, rhs, velocity, momentum, direction, positions, trial;
};

/// Steps start with detection at the old positions and end with the velocity filter and q += dt v'.
///
/// linearly_implicit_euler solves (M + dt² H) v' = M v - dt ∇V once, at the old positions.
///
/// implicit_euler minimises ½ (v'-v)ᵀM(v'-v) + V(q + dt v') over v' by Newton's method with a backtracking
/// line search, until |gradient| ≤ tolerance · |gradient at v|. It takes the exact Hessian where M + dt² H is
/// positive definite and the projected one where it is not: always projecting costs the quadratic
/// convergence.
StepReport advance(const Model& model, State& state, Workspace& workspace);

/// ½ q̇ᵀMq̇ + V(q), drags included [J].
double total_energy(const Model& model, const State& state);

}  // namespace cloth
