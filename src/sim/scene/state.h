#pragma once
// All that changes while a simulation runs; restoring a State resumes the run exactly.

#include <cstdint>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// One [[drag]] while its button is down.
struct DragState {
    bool pressed = false;
    std::vector<int> vertices;    ///< picked vertices, over all cloths
    std::vector<Vec3> anchors;    ///< where each was picked [m]
    Vec3 grabbed = Vec3::Zero();  ///< the point under the pointer when it was pressed [m]
};

struct State {
    std::int64_t step = 0;   ///< steps made since the start
    std::int64_t frame = 0;  ///< frames finished since the start
    double time = 0.0;       ///< [s]
    VecX positions;          ///< shape (3n) [m]
    VecX velocities;         ///< shape (3n) [m/s]
    IntegratorKind integrator = IntegratorKind::linearly_implicit_euler;
    std::vector<std::uint8_t> collider_on;  ///< one per collider
    std::vector<DragState> drags;           ///< one per drag
    VecX rest_folds;  ///< of creased hinges (bending.h), shape (3 patches); empty where none can crease
    std::uint32_t events_done = 0;  ///< events applied so far, in order of time
    /// Without barriers: Newton's method last met an indefinite Hessian, and begins the next solve without
    /// looking at the exact one again.
    bool indefinite = false;
};

/// Index of the first vertex with a NaN or infinite position or velocity, or -1.
int first_non_finite_vertex(const State& state);

}  // namespace cloth
