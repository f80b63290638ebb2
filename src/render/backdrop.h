#pragma once
// The last step of a picture: shaded surfaces over floor and background, encoded as sRGB.
//
// Done by the processor, in tables: as a shader it took half the time of a draw, for what is the same few
// colours nearly everywhere.

#include <cstdint>
#include <span>
#include <vector>

#include "render/image.h"
#include "render/projection.h"

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
    Backdrop(const View& view, const Camera& camera, const Ground* ground, const Float3& lit,
             const Float3& ambient);

    /// `shaded`: sRGB colour of the surfaces and their share of the pixel, rows from the bottom. Rows `first`
    /// … `last` - 1 of the image, from its top.
    void compose(std::span<const std::uint8_t> shaded, const GroundLight& light, Image& image, int first,
                 int last) const;

  private:
    using Float4 = std::array<float, 4>;
    float floor_share(const Float3& ray) const;
    static Float4 behind(const std::vector<Float4>& colors, float share);
    Float4 shadowed(float share, float key, float sky) const;

    const View& view_;
    const Camera& camera_;
    bool has_ground_;
    float depth_below_ = 0, fade_ = 0;  // the floor under the eye [m]; 1 / radius² of its disc
    std::array<float, 2> center_{};     // of the disc from the eye, x z [m]
    Float3 lit_, ambient_;
    std::vector<Float4> open_, open_shown_;  // linear, and sRGB, over the floor's share in the open
};

}  // namespace cloth::render
