#pragma once
// Vertices that are held, and where they are held at a time.

#include <optional>
#include <vector>

#include "sim/scene.h"
#include "sim/types.h"

namespace cloth {

/// One [[pin]], its vertices numbered over all cloths.
struct PinGroup {
    std::vector<int> vertices;
    std::vector<Vec3> start;  ///< where each stands at the start [m]
    Vec3 center;              ///< of the turns [m]
    std::vector<MotionKey> path;
    std::optional<double> until;  ///< [s]
};

/// A vertex and the place where it is held [m].
struct Pin {
    int vertex;
    Vec3 position;
};

/// Translation and turn of a path at `time`: linear between keys, constant outside of them.
MotionKey motion_at(const std::vector<MotionKey>& path, double time);

/// Pins of a step that starts at `start` and ends at `end` [s], sorted by vertex; where two groups hold the
/// same vertex, the first does.
std::vector<Pin> pins_of_step(const std::vector<PinGroup>& groups, double start, double end);

}  // namespace cloth
