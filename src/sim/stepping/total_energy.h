#pragma once
// Energies of a state, for who reads it.

#include "sim/model.h"
#include "sim/scene/state.h"

namespace cloth {

/// ½ q̇ᵀMq̇ [J]
double kinetic_energy(const Model& model, const State& state);

/// ½ q̇ᵀMq̇ + V(q) [J]: all that the model stores, weight, drags, seams and penalty contact included; the
/// barrier's own energy is left out.
double total_energy(const Model& model, const State& state);

}  // namespace cloth
