#pragma once
// What no step could do is refused before the first one: a start beyond a strain limit, pins whose ways alone
// pull a cloth beyond it, pins and colliders that run into each other.

#include <vector>

#include "sim/scene/scene.h"

namespace cloth {

/// Throws SceneError under the key to blame where a cloth starts at or beyond its strain limit, with the
/// stretch and the limit. `rest`: one per cloth.
void require_start_within_limits(const Scene& scene, const std::vector<MeshData>& rest);

/// Throws SceneError under the path to blame where, in a frame up to the time `last` [s], pins hold two
/// vertices of a cloth farther apart than its strain limit lets them be: as far as the limit times the
/// shortest way between them on the rest shape. Of a curved one that is the way along edges, which may be
/// longer; of each pin's vertices a few dozen are looked at: what passes may still be impossible, what is
/// refused is. The same where barrier contact does not let a pin be where it is to be, because of a collider
/// whose distance is known in closed form and that no event switches.
void require_reachable_pins(const Scene& scene, const std::vector<MeshData>& rest, double last);

}  // namespace cloth
