#pragma once
// Which triangle each part of a picture shows, found on the CPU: for what is drawn over a finished picture
// and has to know what is in front. The camera is the Rasterizer's, and so is the grid of 2x2 samples a
// pixel.

#include <span>
#include <vector>

#include "render/frame.h"

namespace cloth::render {

/// The camera of a View.
class Pinhole {
  public:
    explicit Pinhole(const View& view);
    /// Picture coordinates [pixel], from the top left corner, and the depth along the line of sight [m].
    /// Where the depth is not positive, the point lies behind the eye and the first two mean nothing.
    Float3 project(const Float3& point) const;
    const Float3& eye() const { return eye_; }

  private:
    Float3 eye_, right_, up_, forward_;
    float center_x_, center_y_, scale_;  // of a length over its depth [pixel]
};

/// Columns x0 … x1 - 1 and rows y0 … y1 - 1 of a picture.
struct Window {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};

/// What one sample shows.
struct SurfaceSample {
    float depth = 0;                ///< [m]; 0: no surface
    int surface = -1;               ///< index into Frame::surfaces
    int triangle = -1;              ///< of that surface
    std::array<float, 3> shares{};  ///< of the triangle's corners; they add up to 1
};

constexpr int samples_per_side = 2;

/// Samples of a window, row by row: (x, y) of 2 (x1 - x0) by 2 (y1 - y0).
struct SurfaceMap {
    Window window;
    int width = 0;  ///< samples a row
    std::vector<SurfaceSample> samples;

    const SurfaceSample& at(int x, int y) const {
        return samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(width) +
                       static_cast<std::size_t>(x)];
    }
};

/// Nearest surfaces in `window`, which is cut to the picture. What lies below the frame's ground is not seen.
SurfaceMap map_surfaces(const Frame& frame, const View& view, const Window& window);

}  // namespace cloth::render
