#pragma once
// Colliders on their way through a stage. They stand at its start until place() has moved them: each vertex
// straight towards where it is at the stage's end.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/contact/contact_system.h"
#include "sim/geometry/collide.h"
#include "sim/motion/placement.h"

namespace cloth {

class MovingColliders {
  public:
    struct Plane {
        Vec3 point, normal;
    };
    /// All on, and at rest where the system has them. `system` must outlive this.
    explicit MovingColliders(const ContactSystem& system);

    /// Starts a stage: colliders go from `from` to `to` (one per scene collider), `on` says which are there.
    void begin(const std::vector<Placement>& from, const std::vector<Placement>& to,
               const std::vector<std::uint8_t>& on);
    /// Whether they have reached the stage's end.
    bool placed() const { return placed_; }
    /// Moves them by `share` of what is left of their way.
    void place(double share);

    bool on(int collider) const { return on_[collider]; }
    const std::vector<std::uint8_t>& on() const { return on_; }
    const std::vector<std::uint8_t>& body_on() const { return body_on_; }  ///< one per ContactMesh body

    /// Where their vertices are, and the way left to where they go, shape (3 (N-n)) [m].
    const VecX& positions() const { return positions_; }
    VecX way() const { return targets_ - positions_; }
    /// Of one vertex, in ContactMesh numbers, v ≥ n [m].
    Vec3 way_of(int v) const {
        const int at = 3 * (v - system_.cloth_vertices);
        return targets_.segment<3>(at) - positions_.segment<3>(at);
    }
    /// A vertex of cloth, which is at x, or of a collider; of none (-1) the origin [m].
    Vec3 point(const VecX& x, int v) const {
        if (v < 0) return Vec3::Zero();
        return system_.is_cloth(v) ? Vec3(x.segment<3>(3 * v))
                                   : Vec3(positions_.segment<3>(3 * (v - system_.cloth_vertices)));
    }
    FourPoints points(const VecX& x, const std::array<int, 4>& v) const {
        return {point(x, v[0]), point(x, v[1]), point(x, v[2]), point(x, v[3])};
    }
    /// Plane p of the system, as it is and as it will be at the stage's end.
    const Plane& plane(std::size_t p) const { return planes_[p]; }
    const Plane& plane_target(std::size_t p) const { return plane_targets_[p]; }

    /// Where a collider of the scene is at the stage's end.
    const Placement& target(int collider) const { return to_[collider]; }
    /// Whether a collider bends in this stage: its vertices have ways of their own.
    bool bends(int collider) const { return to_[collider].bent != nullptr; }
    /// The way in the whole stage of what is at `p` at its start and moves with a collider that does not bend
    /// [m].
    Vec3 way_in_stage(int collider, const Vec3& p) const;

  private:
    const ContactSystem& system_;
    std::vector<Placement> from_, to_;
    std::vector<std::uint8_t> on_, body_on_;
    std::vector<int> first_vertex_;  ///< of each body
    VecX positions_, targets_;
    std::vector<Plane> planes_, plane_targets_;
    bool placed_ = true;
};

}  // namespace cloth
