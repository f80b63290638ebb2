#include "render/image/colormap.h"

#include <algorithm>
#include <cmath>

namespace cloth::render {
namespace {

/// Every tenth of the map; straight lines between them stay within 3/255 of it.
constexpr std::uint8_t anchors[11][3] = {{68, 1, 84},    {72, 36, 117},  {65, 68, 135},  {53, 95, 141},
                                         {42, 120, 142}, {33, 145, 140}, {34, 168, 132}, {68, 191, 112},
                                         {122, 209, 81}, {189, 223, 38}, {253, 231, 37}};

}  // namespace

std::array<std::uint8_t, 3> viridis(double share) {
    if (std::isnan(share)) return {128, 128, 128};
    const double place = 10.0 * std::clamp(share, 0.0, 1.0);
    const int below = std::min(static_cast<int>(place), 9);
    std::array<std::uint8_t, 3> color{};
    for (int i = 0; i < 3; ++i) {
        const double a = anchors[below][i], b = anchors[below + 1][i];
        color[i] = static_cast<std::uint8_t>(std::lround(a + (b - a) * (place - below)));
    }
    return color;
}

}  // namespace cloth::render
