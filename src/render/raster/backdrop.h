#pragma once
// The last step of a picture: shaded surfaces over floor and background, encoded as sRGB.
//
// Done by the processor, in tables: as a shader it took half the time of a draw, for what is the same few
// colours nearly everywhere.

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "render/image/image.h"
#include "render/raster/projection.h"

namespace cloth::render {

/// Radiance → display-linear 0 … 1: unchanged below the knee, so that mid-tones keep their colour, then an
/// exponential shoulder of equal slope that ends at white. As in the shader.
float tone_curve(float radiance);

/// Light that reaches the floor where objects are near: shares of the key light and of the sky's, for each
/// 2x2 pixels, rows from the bottom, four bytes each.
struct GroundLight {
    int width = 0, height = 0;  ///< 0: all light reaches it everywhere
    std::span<const std::uint8_t> shares;
};

class Backdrop {
  public:
    /// `lit`, `ambient`: exposed radiance of the floor due to key light and sky, where nothing is in the way.
    Backdrop(const View& view, const Ground* ground, const Float3& lit, const Float3& ambient);

    /// Whether it is what these would make. Kept from frame to frame, it draws the open floor once.
    bool is_of(const View& view, const Ground* ground, const Float3& lit, const Float3& ambient) const;

    /// The open floor: rows `first` … `last` - 1 from the top. Several threads may each draw rows of their
    /// own.
    void draw_open(int first, int last);
    /// Pixels of the picture without surfaces, once all rows are drawn.
    const std::vector<std::uint8_t>& open() const { return open_picture_; }

    /// Draws over the open floor in rows `first` … `last` - 1 of the image. `shaded`: sRGB colour of the
    /// surfaces and their share of the pixel, rows from the bottom.
    void compose(std::span<const std::uint8_t> shaded, const GroundLight& light, Image& image, int first,
                 int last) const;

  private:
    static constexpr int run = 32;  // pixels of a row that are composed together
    template <class T>
    using Run = std::array<T, run>;
    using Float3List = std::array<std::vector<float>, 3>;
    struct LightRun {
        Run<float> key, sky;  // 0 … 255
        bool open = true;     // 255 in all pixels
    };

    float floor_share(const Float3& ray) const;
    Run<float> floor_shares(int x, int y) const;
    static LightRun light_of(const GroundLight& light, int x, int y);
    void compose_run(const std::uint8_t* from, const GroundLight& light, int x, int y, int count,
                     std::uint8_t* to) const;

    View view_;
    std::optional<Ground> ground_;
    Float3 lit_, ambient_;
    Float3 corner_, step_x_, step_y_;   // rays of the picture, as Rasterizer's shaders have them
    float depth_below_ = 0, fade_ = 0;  // the floor under the eye [m]; 1 / radius² of its disc
    std::array<float, 2> center_{};     // of the disc from the eye, x z [m]
    Float3List open_, open_shown_;      // linear, and sRGB, over the floor's share in the open
    std::vector<std::uint8_t> open_picture_;
};

}  // namespace cloth::render
