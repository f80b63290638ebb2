#pragma once
// What solves, steps and frames report, and how the reports of parts become that of the whole.
//
// A report's describe() names each of its counters once: visit(name, member, unit, rule), where rule(a, b)
// makes one value of those of two successive parts. merge() walks it, and so does the file of a run's report
// (pipeline/run/report.h): a new counter is its member, its line in describe(), and the place that counts it.

#include <algorithm>
#include <cstdint>
#include <limits>
#include <optional>
#include <type_traits>

#include "sim/stepping/obstacle.h"

namespace cloth {

namespace merging {
struct Sum {
    template <class T>
    T operator()(T a, T b) const {
        return a + b;
    }
};
inline constexpr Sum sum;
inline constexpr auto greatest = [](auto a, auto b) { return std::max(a, b); };
inline constexpr auto least = [](auto a, auto b) { return std::min(a, b); };
inline constexpr auto first = [](auto a, auto) { return a; };
inline constexpr auto last = [](auto, auto b) { return b; };
inline constexpr auto all = [](bool a, bool b) { return a && b; };
}  // namespace merging

/// Where the time of a step's solves goes: wall time [s].
struct ContactTimes {
    double detection = 0.0;  ///< what may touch, and what is free
    double assembly = 0.0;   ///< Hessians
    double factorization = 0.0;
    double solution = 0.0;    ///< conjugate gradients
    double evaluation = 0.0;  ///< objective and gradient, most of it in the line search

    template <class Visit>
    static void describe(Visit&& visit) {
        using namespace merging;
        visit("detection", &ContactTimes::detection, "s", sum);
        visit("assembly", &ContactTimes::assembly, "s", sum);
        visit("factorization", &ContactTimes::factorization, "s", sum);
        visit("conjugate_gradients", &ContactTimes::solution, "s", sum);
        visit("line_search", &ContactTimes::evaluation, "s", sum);
    }
};

/// What one step did, or one solve of it. All begin at what changes nothing when merged.
struct StepReport {
    bool converged = true;         ///< false: not even in halved steps; the state is that of the step's start
    bool stopped = false;          ///< it did not converge because it was asked to stop
    int iterations = 0;            ///< Newton's; of the linearly implicit rule: one a step
    double residual = 0.0;         ///< |∇Φ| / |∇Φ at the step's start| reached (newton.h)
    int retries = 0;               ///< steps that did not converge and were halved
    double energy_before = 0.0;    ///< kinetic + potential at the step's start [J]
    double energy_after = 0.0;     ///< the same at its end [J]
    double largest_stretch = 1.0;  ///< greatest principal stretch of any triangle at its end
    /// Of contact = "barrier": what is left between the nearest pair's surfaces [m]; infinite: none near.
    double smallest_gap = std::numeric_limits<double>::infinity();
    int contacts = 0;       ///< vertices in contact with colliders; of `barrier`: pairs repelled
    bool placed = true;     ///< pins and colliders got to where they go
    int placements = 0;     ///< solves that took pins and colliders along
    int cg_iterations = 0;  ///< of `barrier`: within the linear solves
    int factorizations = 0;

    ContactTimes contact_times;
    std::optional<int> worst_vertex;       ///< where a step that did not converge is farthest from balance
    std::optional<int> non_finite_vertex;  ///< the state is no longer usable
    std::optional<Obstacle> obstacle;      ///< what kept a step that did not converge from its end, if known

    template <class Visit>
    static void describe(Visit&& visit) {
        using namespace merging;
        visit("converged", &StepReport::converged, "", all);
        visit("iterations", &StepReport::iterations, "", sum);
        visit("residual", &StepReport::residual, "", greatest);
        visit("retries", &StepReport::retries, "", sum);
        visit("energy_before", &StepReport::energy_before, "J", first);
        visit("energy_after", &StepReport::energy_after, "J", last);
        visit("largest_stretch", &StepReport::largest_stretch, "", greatest);
        visit("smallest_gap", &StepReport::smallest_gap, "m", least);
        visit("contacts", &StepReport::contacts, "", greatest);
        visit("placed", &StepReport::placed, "", all);
        visit("placements", &StepReport::placements, "", sum);
        visit("cg_iterations", &StepReport::cg_iterations, "", sum);
        visit("factorizations", &StepReport::factorizations, "", sum);
    }
};

/// What the steps of one frame did.
struct FrameReport : StepReport {
    std::int64_t frame = 0;  ///< the frame that was reached
    int steps = 0;
};

/// Takes the report of the next part into that of the whole.
inline void merge(ContactTimes& whole, const ContactTimes& part) {
    ContactTimes::describe([&](const char*, auto member, const char*, auto rule) {
        whole.*member = rule(whole.*member, part.*member);
    });
}
inline void merge(StepReport& whole, const StepReport& part) {
    StepReport::describe([&](const char*, auto member, const char*, auto rule) {
        whole.*member = rule(whole.*member, part.*member);
    });
    merge(whole.contact_times, part.contact_times);
    whole.stopped = whole.stopped || part.stopped;
    if (part.worst_vertex) whole.worst_vertex = part.worst_vertex;
    if (part.obstacle) whole.obstacle = part.obstacle;
    if (part.non_finite_vertex) whole.non_finite_vertex = part.non_finite_vertex;
}

/// Takes the next step into the report of its frame. A frame begins with its first step's values, which may
/// be less than those of a report in which nothing has happened.
inline void merge(FrameReport& frame, const StepReport& step) {
    StepReport& whole = frame;
    if (frame.steps++ == 0) {
        whole = step;
    } else {
        merge(whole, step);
    }
}

/// Of a part that is undone and made anew only the work counts: what is summed up.
inline void merge_work(StepReport& whole, const StepReport& undone) {
    StepReport::describe([&](const char*, auto member, const char*, auto rule) {
        if constexpr (std::is_same_v<decltype(rule), merging::Sum>)
            whole.*member = rule(whole.*member, undone.*member);
    });
    merge(whole.contact_times, undone.contact_times);
}

}  // namespace cloth
