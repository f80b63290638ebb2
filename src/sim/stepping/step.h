#pragma once
// What the integrators share. Each makes one step of any length: `bool step_…(Step&)` takes the state's
// positions and velocities, but not its time, to the step's end; false where it does not converge: the state
// is then as it was.

#include <vector>

#include "sim/contact/velocity_filter.h"
#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/scene/state.h"
#include "sim/stepping/step_report.h"
#include "sim/stepping/workspace.h"

namespace cloth {

struct Step {
    const Model& model;
    State& state;
    double dt;                     ///< [s]
    const std::vector<Pin>& pins;  ///< where they are held at the step's end; the solver leaves them out
    Workspace& workspace;
    StepReport& report;
};

/// Minimises the stage that the workspace's terms were told of (newton.h), from x.
/// `pins`: where they are held at its end; `force`: f, shape (3n) or empty [N].
bool minimize(Step& step, const std::vector<Pin>& pins, double h, const VecX& y, VecX& x,
              const VecX& force = VecX());

/// Detection at the old positions and the filter at the new velocities, as the assignment's.
class FilterOfStep {
  public:
    explicit FilterOfStep(Step& step);
    void apply(VecX& v) const;
    /// Positions follow the filtered velocities.
    void apply(double h, VecX& x, VecX& v) const;

  private:
    std::vector<FilterContact> contacts_;
};

/// The velocities that take pins from `start` to their places within dt.
void set_pinned_velocities(const std::vector<Pin>& pins, const VecX& start, double dt, VecX& v);

}  // namespace cloth
