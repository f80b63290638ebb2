#include "sim/stepping/total_energy.h"

#include "sim/stepping/terms.h"

namespace cloth {

double kinetic_energy(const Model& model, const State& state) {
    VecX momentum;
    multiply(model.pattern, model.mass, state.velocities, momentum);
    return 0.5 * state.velocities.dot(momentum);
}

double total_energy(const Model& model, const State& state) {
    return kinetic_energy(model, state) + Terms(model).stored(state);
}

}  // namespace cloth
