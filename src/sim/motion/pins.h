#pragma once
// Vertices that are held, and where they are held at a time.

#include <memory>
#include <optional>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/motion/carrier.h"
#include "sim/scene/scene.h"

namespace cloth {

/// One [[pin]], its vertices numbered over all cloths.
struct PinGroup {
    std::vector<int> vertices;
    std::vector<Vec3> start;  ///< where each stands at the start [m]
    Vec3 center;              ///< of the turns [m]
    std::vector<MotionKey> path;
    std::optional<double> until;               ///< [s]
    std::shared_ptr<const Carrier> carrier{};  ///< of vertices that a collider carries, else null

    bool moves() const { return carrier || !path.empty(); }
    /// Where its vertices are at `time` [s], one each [m].
    std::vector<Vec3> places(double time) const;
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

/// A vertex that is held from outside of the scene, as by a gripper.
struct Hold {
    int vertex;
    Vec3 from, to;              ///< where it is at `begin`, and at `end` and after [m]
    double begin = 0, end = 0;  ///< [s]

    Vec3 place(double time) const;
};

/// `pins` with what is held at `time`, sorted by vertex; of a vertex that both hold, the hold counts.
void add_holds(std::vector<Pin>& pins, const std::vector<Hold>& holds, double time);

/// v = 0 at the pins.
void zero_pinned(const std::vector<Pin>& pins, VecX& v);
/// x = the place of each pin.
void place_pinned(const std::vector<Pin>& pins, VecX& x);
/// way = what each pin has left to go from x.
void set_pinned_way(const std::vector<Pin>& pins, const VecX& x, VecX& way);
bool pins_placed(const std::vector<Pin>& pins, const VecX& x);

}  // namespace cloth
