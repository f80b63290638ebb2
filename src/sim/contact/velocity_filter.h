#pragma once
// The assignment's contact: found at the old positions, answered by a filter on the new velocities. It does
// not correct positions.

#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

struct FilterContact {
    int vertex;
    Vec3 normal;      ///< outward
    double friction;  ///< Coulomb coefficient
};

/// Vertices closer to an enabled collider than its contact radius (sphere) or offset (plane); validate() lets
/// it meet no others.
std::vector<FilterContact> find_filter_contacts(const std::vector<ColliderDesc>& colliders,
                                                const std::vector<std::uint8_t>& collider_on, const VecX& q);

/// One-sided: takes the inward normal part v_n out of each velocity, then up to friction · |v_n| of the
/// tangential part. A vertex that leaves is left alone.
void filter_velocities(const std::vector<FilterContact>& contacts, VecX& qdot);

}  // namespace cloth
