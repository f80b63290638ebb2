#pragma once
// The public face of the simulation library.

#include <atomic>
#include <memory>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/model.h"
#include "sim/scene/scene.h"
#include "sim/scene/state.h"
#include "sim/stepping/step_report.h"

namespace cloth {

/// Owns model, state and workspace; advances the state.
class Simulation {
  public:
    /// Throws SceneError where the scene cannot be simulated. `threads` ≤ 0 means all cores. The states do
    /// not depend on `threads`.
    explicit Simulation(const Scene& scene, int threads = 0);
    ~Simulation();
    Simulation(Simulation&&) noexcept;

    const Model& model() const;
    const State& state() const;
    /// Continues from `state`; throws std::invalid_argument where its sizes do not fit the model.
    void restore(const State& state);

    /// From now on holds these vertices (numbered over all cloths), whatever pins the scene has: within the
    /// next frame each goes straight from where it is to its place [m], and stays until it is held elsewhere
    /// or released. No part of the state. Throws std::invalid_argument for a vertex that is not there, a
    /// place that is not finite, or as many places as vertices are not.
    void hold(const std::vector<int>& vertices, const Points& places);
    /// Lets vertices go that were held; all of them where none is named.
    void release(const std::vector<int>& vertices = {});

    /// Looked at before every Newton iteration: where it is true the step is undone, and its report says
    /// `stopped`. States do not depend on it. nullptr: nobody stops.
    void stop_on(const std::atomic<bool>* request);

    /// One time step.
    StepReport step();
    /// Steps to the next frame; stops early where a step did not converge or was stopped.
    FrameReport advance_frame();

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth
