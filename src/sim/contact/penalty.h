#pragma once
// Contact with exact collider shapes as an energy of the step: a stiff layer around each shape, and Coulomb
// friction whose normal force and direction are those of the step's start.
//
//   E(d) = k/2 (d̂ - d)²  for d < d̂, else 0          d: distance from the drawn surface, d̂: contact offset
//   friction: D(x) = Σ μ f_n φ(|u|), u: tangential way made since the step's start, f_n = k (d̂ - d) at that
//   start; φ(y) = y - ε/2 for y ≥ ε = ε_v dt, y²/(2ε) below: a Huber potential, so the force is μ f_n once
//   the vertex slides faster than ε_v and grows in proportion below (Li et al. 2020 smooth it likewise).

#include <memory>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/energies/energy.h"
#include "sim/scene/scene.h"
#include "sim/shapes/shapes.h"

namespace cloth {

class ColliderContactEnergy final : public Energy {
  public:
    /// Contact of a step that starts at `start`, with shapes of one curvature. `stiffness` per vertex [N/m].
    ColliderContactEnergy(const std::vector<ColliderDesc>& colliders,
                          const std::vector<std::uint8_t>& collider_on, const VecX& start, double stiffness,
                          double time_step, double sliding_speed);

    /// Vertices that were in contact at the step's start.
    int contact_count() const { return static_cast<int>(friction_.size()); }

    std::string_view name() const override { return "contact"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>&) const override {}
    void bind(const BlockPattern& pattern) override { pattern_ = &pattern; }

  private:
    struct Friction {
        int vertex;
        Vec3 normal, start;
        double force;  ///< μ f_n [N]
    };
    struct Collider {
        std::unique_ptr<const ColliderShape> shape;
        double offset, friction;  ///< d̂ [m], μ
    };
    template <class F>
    void for_each_contact(const VecX& x, const F& body) const;

    std::vector<Collider> colliders_;  ///< those that are on
    std::vector<Friction> friction_;
    double stiffness_, sliding_way_;
    const BlockPattern* pattern_ = nullptr;
};

}  // namespace cloth
