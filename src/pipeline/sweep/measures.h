#pragma once
// What a sweep measures of each cell.

#include <string>
#include <vector>

#include "pipeline/formats/state_store.h"
#include "pipeline/run/report.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

/// A finished run, as far as measures look at it.
struct MeasuredRun {
    const Topology& topology;
    const State& last;                        ///< the state of the last frame
    const std::vector<FrameRecord>& records;  ///< of all frames
    double pedestal_radius = 0;               ///< of what carries the cloth; 0: nothing does [m]
};

struct Measure {
    const char *name, *unit, *meaning;  ///< unit: SI, or "" for none
    double (*of)(const MeasuredRun&);   ///< NaN where it has none
};

/// The one list of them, in the order of the results.
const std::vector<Measure>& measures();

}  // namespace cloth::pipeline
