#pragma once
// What pictures have to know of a whole run, so that colours, curves and the camera mean the same in all of
// them.

#include <array>
#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <vector>

#include "pipeline/picture/annotation.h"
#include "pipeline/picture/camera.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"
#include "sim/scene/state.h"
#include "sim/stepping/step_report.h"

namespace cloth::pipeline {

/// Range of the colours of a shaded picture.
struct ShadeRange {
    double low = 0, high = 1;
    bool below = false, above = false;  ///< whether there are values beyond
};

/// All but half a percent of the values at each end, rounded outwards to a step of 1, 2 or 5 times a power of
/// ten; from 0 for what cannot be negative. NaN does not count. `diagonal` of all that is shown [m]: of gaps,
/// those beyond a twentieth of it share the last colour, as nothing touches there.
ShadeRange shade_range(VertexField field, std::vector<double> values, double diagonal);

struct RunFacts {
    std::optional<ShadeRange> shade;  ///< where the scene asks for colours
    std::optional<Extent> extent;     ///< where it asks for automatic framing
    std::vector<double> times;        ///< of the kept frames, where it asks for curves [s]
    std::vector<CurveLine> curves;
};

/// Whether the pictures that `file` asks for need survey(), or other states than their own.
bool needs_whole_run(const SceneFile& file);

/// Without a run: what `file` itself says.
RunFacts facts_of(const SceneFile& file);

/// The state of a frame, if it is kept.
using StateReader = std::function<std::optional<State>(std::int64_t)>;
/// By frame.
using FrameReports = std::map<std::int64_t, FrameReport>;

/// A simulated run: frames in order with their states, and what is reported of them.
struct SimulatedRun {
    std::vector<std::int64_t> frames;
    StateReader read;
    FrameReports reports;
};

/// Reads the states, and the reports for curves of what states do not tell. `stop` as in RunOptions.
RunFacts survey(const SimulatedRun& run, const SceneFile& file, const Model& model,
                const std::atomic<bool>* stop = nullptr);

/// The facts of two runs that are shown beside each other: ranges and extents that hold both.
void share(RunFacts& a, RunFacts& b);

}  // namespace cloth::pipeline
