#pragma once
// Frame + View → Image, offscreen, by OpenGL core profile. All GL stays behind this header.
//
// Radiance of a surface towards the eye, with E = intensity · color of the light and l its direction:
//   E/π (n·l) shadow (albedo (1 - F) + GGX + sheen)   key light: Walter et al. 2007, Schlick's F and G terms;
//                                                     sheen: Estevez and Kulla 2017
//   + (albedo + sheen) (sky · above + bounce · below)  fill; above, below = (1 ± n.y)/2 less what is occluded
//   + mirror (sky or bounce)                           where a mirror would show it, by a fit (Karis 2014)
// bounce is what the floor returns, or half the background where there is none; the surfaces around
// return a part of what they hide. Times exposure, it goes
// through a tone curve, x up to 0.6, then 0.6 + 0.4 (1 - exp(-(x - 0.6)/0.4)), and becomes sRGB. The
// background is shown as it is. Four samples of a pixel tell which triangles it sees; those that lie in one
// surface are shaded once, at their middle, and a pixel is the mean of its samples in linear light. Nothing
// depends on earlier draws or on threads.

#include <memory>
#include <string>

#include "render/frame.h"
#include "render/gl/gl_library.h"
#include "render/image/image.h"

namespace cloth::render {

class Rasterizer {
  public:
    /// `threads` ≤ 0: all cores; fixed by the first Rasterizer of a process. Throws std::runtime_error where
    /// no suitable context can be made, naming the driver and what it lacks.
    explicit Rasterizer(int threads = 0, GlLibrary library = GlLibrary::automatic);
    ~Rasterizer();
    Rasterizer(Rasterizer&&) noexcept;

    /// Throws std::invalid_argument for a size outside 16 … 8192, a degenerate camera or indices out of
    /// range.
    /// std::runtime_error where the driver has not the memory for a very large picture.
    Image draw(const Frame& frame, const View& view);

    /// Renderer and version strings of the driver.
    std::string description() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth::render
