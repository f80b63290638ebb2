#pragma once
// Points that a collider carries with it: a waistband on hips, a button, a sleeve in a hand.

#include <array>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Of a rigid collider they keep their places against it. Of a mesh that bends each keeps its place against
/// the triangle that it is nearest to at time 0: the same point of it, and the same way off its plane.
class Carrier {
  public:
    /// `start`: where the points stand at time 0 [m].
    Carrier(const ColliderDesc& collider, const std::vector<Vec3>& start);

    /// Where the points are at `time` [s], one each [m].
    std::vector<Vec3> places(double time) const;

  private:
    struct Hold {
        std::array<int, 3> corners{};  ///< of the triangle; rigid: not used
        std::array<double, 3> weights{};
        Vec3 off = Vec3::Zero();  ///< from the point of the triangle, in its frame; rigid: in the collider's
    };
    ColliderDesc collider_;
    std::vector<Hold> holds_;
};

}  // namespace cloth
