#pragma once
// A sheet under barrier contact.

#include "sim/scene/scene.h"

namespace cloth::testing {

inline Scene barrier_scene(int resolution) {
    Scene scene;
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.contact = ContactKind::barrier;
    scene.simulation.sliding_speed = 1e-3;
    ClothDesc cloth;
    cloth.grid.size = {0.4, 0.4};
    cloth.grid.resolution = {resolution, resolution};
    cloth.fabric = {.bending = 1e-5, .friction = 0.3};
    scene.cloths.push_back(cloth);
    return scene;
}

}  // namespace cloth::testing
