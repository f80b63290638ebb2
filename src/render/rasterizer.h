#pragma once
// Frame + View → Image, offscreen, by OpenGL core profile. All GL stays behind this header.

#include <memory>
#include <string>

#include "render/frame.h"
#include "render/image.h"

namespace cloth::render {

class Rasterizer {
  public:
    /// `threads` ≤ 0: all cores; fixed by the first Rasterizer of a process. Throws std::runtime_error where
    /// no suitable context can be made, naming the driver and what it lacks.
    explicit Rasterizer(int threads = 0);
    ~Rasterizer();
    Rasterizer(Rasterizer&&) noexcept;

    /// Throws std::invalid_argument for a size outside 16 … 8192, a degenerate camera or indices out of
    /// range.
    Image draw(const Frame& frame, const View& view);

    /// Renderer and version strings of the driver.
    std::string description() const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth::render
