#pragma once
// One term of the sum that a step minimises. A new energy is a class of its own and a line in build_model().

#include <array>
#include <string_view>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/types.h"
#include "sim/scene/scene.h"
#include "sim/scene/state.h"

namespace cloth {

/// Which Hessian an energy gives.
enum class HessianKind {
    assignment,  ///< the membrane's as the assignment has it (LinearHessian), projected for all others
    projected,   ///< exact, projected to positive semi-definite in closed form
    exact,       ///< second derivative; may be indefinite
};

class Energy {
  public:
    virtual ~Energy() = default;
    virtual std::string_view name() const = 0;

    /// Energy at positions x, shape (3n) [J]; infinite where x is not allowed (a strain limit).
    virtual double value(const VecX& x) const = 0;
    /// Adds the gradient [N] to g, shape (3n).
    virtual void add_gradient(const VecX& x, VecX& g) const = 0;
    /// Adds the Hessian [N/m] of the kind asked for.
    virtual void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const = 0;
    /// Whether that is the same, of any kind, at all x of a stage: then it is asked for once a stage.
    virtual bool constant_hessian() const { return false; }

    /// Lists the pairs of vertices that a Hessian block couples; diagonal blocks need no mention.
    virtual void append_pairs(std::vector<std::array<int, 2>>& pairs) const = 0;
    /// Looks up where its blocks lie; called once, before the first add_hessian.
    virtual void bind(const BlockPattern& pattern) = 0;
};

/// What a solve knows of its step. Velocities within it are (x - base) / h, with x the positions solved for
/// and base = Σ share · positions. The rate of a quantity that is not linear in the positions, such as a
/// strain, is (e(x) - Σ share · e(positions)) / h: the extrapolated base itself may be no sane shape.
struct Stage {
    struct Past {
        double share;
        const VecX& positions;
    };
    std::vector<Past> past;  ///< shares add up to 1
    double h;                ///< [s]
    double time;             ///< at the solve's end [s]
    const State& state;      ///< at the step's start

    // Where the solve itself starts.
    double start_time = state.time;       ///< [s]
    const VecX& start = state.positions;  ///< shape (3n) [m]

    VecX base() const {
        VecX sum = VecX::Zero(state.positions.size());
        for (const Past& p : past) sum += p.share * p.positions;
        return sum;
    }
};

/// A term that depends on the step: dissipation (a potential whose gradient is minus the force at the
/// velocities (x - base)/h), moving springs. One for a run; told about each stage before it is asked.
class StageEnergy : public Energy {
  public:
    virtual void begin(const Stage& stage) = 0;
    /// After the step that reached `state`: what it changes for good.
    virtual void finish(State& /*state*/) const {}
    /// Whether its value belongs to the stored energy.
    virtual bool conservative() const { return false; }
};

}  // namespace cloth
