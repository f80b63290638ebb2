#pragma once
// All that contact sees of a scene.

#include "sim/contact/barrier_contact.h"
#include "sim/model.h"

namespace cloth {

/// Cloths and colliders as contact sees them: a sphere is a point and a capsule an edge with a radius, both
/// exact; a plane is a half-space; the others are their triangles.
ContactSystem make_contact_system(const Model& model);

}  // namespace cloth
