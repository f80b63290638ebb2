#pragma once
// The public face of the simulation library.

#include <atomic>
#include <memory>

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
