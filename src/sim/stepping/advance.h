#pragma once
// One time step.

#include "sim/model.h"
#include "sim/scene/state.h"
#include "sim/stepping/step_report.h"
#include "sim/stepping/workspace.h"

namespace cloth {

/// A step starts with events, picking and detection at the old positions; then the state's integrator makes
/// it (linearly_implicit_euler.h, implicit_euler.h, implicit_midpoint.h, tr_bdf2.h).
///
/// A step that does not converge is undone and made in two halves, each of which may be halved in turn; past
/// `retries` halvings the state is left as it was and the report says converged = false. So is one that the
/// workspace's stop request ends; its report says stopped = true as well.
///
/// With contact = "barrier" a step that starts with an overlap (the first, or one before which a collider was
/// switched) throws OverlapError.
StepReport advance(const Model& model, State& state, Workspace& workspace);

}  // namespace cloth
