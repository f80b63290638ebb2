#pragma once
// How far cloth and colliders may go: continuous collision detection over the candidates of a stage
// (collide.h).

#include "sim/contact/contact_set.h"

namespace cloth {

/// The share of the way d from x that is free for certain, with the colliders where they are.
double largest_share(ContactSet& set, const VecX& x, const VecX& d);

/// The share of d, and of the colliders' remaining way together with it, that is free for certain.
double largest_share_placing(ContactSet& set, const VecX& x, const VecX& d);

/// The way d with each vertex stopped where its own pairs come near, so that x + result is allowed. For first
/// guesses only: it is no direction of descent.
VecX truncated_way(ContactSet& set, const VecX& x, const VecX& d);

}  // namespace cloth
