#pragma once
// How far the drawn surface may leave the simulated triangles. Nothing passes through those; what is drawn
// smoother or thicker than they are must not either.

#include <optional>
#include <vector>

#include "sim/contact/broad_phase.h"
#include "sim/model.h"
#include "sim/scene/state.h"
#include "sim/shapes/shapes.h"

namespace cloth::pipeline {

class Clearance {
  public:
    /// `model` must outlive this; `ground`: height of a floor that is drawn and is no collider [m].
    Clearance(const Model& model, std::optional<double> ground);

    /// Per simulated triangle, over all cloths [m]; infinite where nothing is within reach.
    struct Room {
        std::vector<double> all;     ///< to colliders and to other layers
        std::vector<double> layers;  ///< to other layers of cloth alone
    };
    /// `reach`: how far a point drawn for each triangle would leave it [m]. Where all of them go no farther
    /// than their triangle's room, no two surfaces meet: two layers share what is between them as they asked.
    Room find(const State& state, const std::vector<double>& reach) const;

  private:
    struct Plane {
        int collider;  ///< -1: the ground
        Vec3 point, normal;
    };
    const Model& model_;
    ContactMesh mesh_;               ///< cloths, and colliders as they are drawn
    VecX at_start_;                  ///< of all vertices; those of cloth at rest
    std::vector<int> first_vertex_;  ///< of each collider that has some here, else -1
    std::vector<Plane> planes_;      ///< at the start
    std::optional<BroadPhase> broad_phase_;
};

}  // namespace cloth::pipeline
