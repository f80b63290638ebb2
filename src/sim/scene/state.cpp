#include "sim/scene/state.h"

#include <cmath>

namespace cloth {

int first_non_finite_vertex(const State& state) {
    for (int i = 0; i < state.positions.size(); ++i) {
        if (!std::isfinite(state.positions(i)) || !std::isfinite(state.velocities(i))) return i / 3;
    }
    return -1;
}

}  // namespace cloth
