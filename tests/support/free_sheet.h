#pragma once
// A sheet that nothing holds, and how far apart two states are.

#include "sim/scene/scene.h"
#include "support/assignment_settings.h"

namespace cloth::testing {

inline Scene free_sheet() {
    Scene scene{.simulation = assignment_settings()};
    ClothDesc cloth;
    cloth.grid.resolution = {6, 5};
    cloth.fabric = {.density = 0.2, .thickness = 1e-3, .young_modulus = 5e5, .poisson_ratio = 0.3};
    scene.cloths.push_back(cloth);
    return scene;
}

inline double largest_distance(const VecX& a, const VecX& b) {
    return (a - b).reshaped(3, a.size() / 3).colwise().norm().maxCoeff();
}

}  // namespace cloth::testing
