#pragma once
// All that contact sees of a scene.

#include "sim/contact/barrier_contact.h"
#include "sim/model.h"

namespace cloth {

/// Cloths and the primitives of colliders (shapes.h).
ContactSystem make_contact_system(const Model& model);

}  // namespace cloth
