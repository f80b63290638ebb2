#pragma once
// Numbers as colours.

#include <array>
#include <cstdint>

namespace cloth::render {

/// sRGB of viridis (Smith and van der Walt 2015): its lightness grows evenly with the number, for readers
/// with a colour-vision deficiency and in grey print too. `share` is clamped to 0 … 1; NaN gives grey.
std::array<std::uint8_t, 3> viridis(double share);

}  // namespace cloth::render
