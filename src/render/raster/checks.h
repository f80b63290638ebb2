#pragma once
// What draw() refuses, by std::invalid_argument with one line that names the fault.

#include "render/vector_math.h"

namespace cloth::render {

void require_view(const View& view);
void require_ground(const Ground& ground);

/// Checks a surface and returns its bounds.
Bounds checked_bounds(const Surface& surface, std::size_t number);

/// Those that shadows and occlusion are laid over: the view's own, or `casting`, widened.
Bounds shadow_bounds(const View& view, const Bounds& casting);

}  // namespace cloth::render
