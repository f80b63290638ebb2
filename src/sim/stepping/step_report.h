#pragma once
// What steps and frames report.

#include <cstdint>
#include <limits>
#include <optional>

#include "sim/stepping/contact_times.h"

namespace cloth {

/// What one step did.
struct StepReport {
    bool converged = true;         ///< false: not even in halved steps; the state is that of the step's start
    int iterations = 0;            ///< linear solves
    int retries = 0;               ///< steps that did not converge and were halved
    double residual = 0.0;         ///< |∇Φ| / |∇Φ at the step's start| reached (integrator.h)
    double energy_before = 0.0;    ///< kinetic + potential at the step's start [J]
    double energy_after = 0.0;     ///< the same at its end [J]
    double largest_stretch = 1.0;  ///< greatest principal stretch of any triangle at its end
    int contacts = 0;              ///< vertices in contact with colliders; of `barrier`: pairs repelled
    /// Of contact = "barrier": what is left between the nearest pair's surfaces [m]; infinite: none near.
    double smallest_gap = std::numeric_limits<double>::infinity();
    bool placed = true;                    ///< of `barrier`: pins and colliders got to where they go
    int placements = 0;                    ///< of `barrier`: solves that took pins and colliders along
    int cg_iterations = 0;                 ///< of `barrier`: within the linear solves
    int factorizations = 0;                ///< of `barrier`
    ContactTimes contact_times;            ///< of `barrier`
    std::optional<int> worst_vertex;       ///< where a step that did not converge is farthest from balance
    std::optional<int> non_finite_vertex;  ///< the state is no longer usable
};

/// What the steps of one frame did: sums, worst values, and the energies at its two ends.
struct FrameReport : StepReport {
    std::int64_t frame = 0;  ///< the frame that was reached
    int steps = 0;
};

}  // namespace cloth
