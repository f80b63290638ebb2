#pragma once
// How much of the sky, and of the floor below, reaches a point past the surfaces of a frame.
//
// The surfaces are splatted as optical density into a grid; rays in fixed directions gather density from ever
// coarser levels of it (Crassin et al. 2011, Interactive Indirect Illumination Using Voxel Cone Tracing,
// without the light). Splatting and sampling are trilinear and the directions fixed, so the result moves
// smoothly with the surfaces: nothing flickers from frame to frame, and no pixel depends on the driver's
// rounding.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "render/vector_math.h"

namespace cloth::render {

/// Shares of the light that arrives at a point from above and from below the horizon, cosine-weighted:
/// (1 ± normal.y) / 2 where nothing is in the way.
struct AmbientLight {
    float from_above = 0, from_below = 0;
};

class AmbientOcclusion {
  public:
    /// Surfaces outside `bounds` occlude nothing. Requires valid triangle indices.
    void build(std::span<const Surface> surfaces, const Bounds& bounds);

    /// `on_surface`: the point lies on one of the surfaces, which is not to occlude itself.
    AmbientLight at(const Float3& position, const Float3& normal, bool on_surface = true) const;

    /// Side of a cell of the finest level [m].
    float cell() const { return cell_; }

  private:
    // Cells of a level have a border of empty ones, so that sampling beyond the grid finds nothing.
    struct Level {
        int cells = 0;
        std::vector<float> density;  ///< optical depth per finest cell
    };
    static float sample(const float* density, int side, float x, float y, float z);
    void splat(const Float3& position, float area);

    std::array<Level, 5> levels_;
    Float3 origin_{};
    float cell_ = 1;
};

}  // namespace cloth::render
