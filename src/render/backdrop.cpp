#include "render/backdrop.h"

#include <cmath>

namespace cloth::render {
namespace {

constexpr float ground_radius = 1.4f;  // over which the floor fades, in distances from eye to target
constexpr int open_steps = 1024, tone_steps = 2048, srgb_steps = 8192;
constexpr float brightest = 4;  // radiance beyond which the tone curve is taken as flat

/// Linear 0 … 1 → sRGB 0 … 255.
float encode(float c) {
    return 255 * (c <= 0.0031308f ? 12.92f * c : 1.055f * std::pow(c, 1 / 2.4f) - 0.055f);
}

struct Tables {
    std::array<float, 256> decoded{};
    std::array<float, srgb_steps + 2> encoded{};
    std::array<float, tone_steps + 2> tone{};
    Tables() {
        for (std::size_t i = 0; i < decoded.size(); ++i) {
            const float c = static_cast<float>(i) / 255;
            decoded[i] = c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
        }
        for (std::size_t i = 0; i < encoded.size(); ++i)
            encoded[i] = encode(static_cast<float>(i) / srgb_steps);
        for (std::size_t i = 0; i < tone.size(); ++i)
            tone[i] = tone_curve(static_cast<float>(i) * brightest / tone_steps);
    }
};
const Tables tables;

/// Linear interpolation at `place` ≥ 0, in steps.
template <class Table>
float look_up(const Table& table, float place) {
    const int i = static_cast<int>(place);
    return table[i] + (place - static_cast<float>(i)) * (table[i + 1] - table[i]);
}

}  // namespace

float tone_curve(float radiance) {
    constexpr float knee = 0.6f;
    return radiance <= knee ? radiance : knee + (1 - knee) * (1 - std::exp(-(radiance - knee) / (1 - knee)));
}

Backdrop::Backdrop(const View& view, const Camera& camera, const Ground* ground, const Float3& lit,
                   const Float3& ambient)
    : view_(view), camera_(camera), has_ground_(ground != nullptr), lit_(lit), ambient_(ambient) {
    if (has_ground_) {
        depth_below_ = view.eye[1] - ground->height;
        const float radius = ground_radius * length(view.target - view.eye);
        fade_ = 1 / (radius * radius);
        center_ = {view.target[0] - view.eye[0], view.target[2] - view.eye[2]};
    }
    Float3 floor{};
    for (int k = 0; k < 3; ++k) floor[k] = tone_curve(lit[k] + ambient[k]);
    open_.resize(open_steps + 2);
    for (std::size_t i = 0; i < open_.size(); ++i)
        for (int k = 0; k < 3; ++k)
            open_[i][k] =
                view.background[k] + static_cast<float>(i) / open_steps * (floor[k] - view.background[k]);
    for (const Float4& c : open_) {
        Float4& shown = open_shown_.emplace_back();
        for (int k = 0; k < 3; ++k) shown[k] = encode(std::clamp(c[k], 0.0f, 1.0f));
    }
}

/// How much of the floor is seen along a ray, against the background: 1 at the disc's middle.
float Backdrop::floor_share(const Float3& ray) const {
    const float t = depth_below_ / std::max(-ray[1], 1e-6f);
    const float x = t * ray[0] - center_[0], z = t * ray[2] - center_[1];
    const float share = 1 / (1 + (x * x + z * z) * fade_);
    return ray[1] < -1e-6f ? share * share : 0;
}

Backdrop::Float4 Backdrop::behind(const std::vector<Float4>& colors, float share) {
    const float place = open_steps * share;
    const int i = static_cast<int>(place);
    const float part = place - static_cast<float>(i);
    Float4 c{};
    for (int k = 0; k < 4; ++k) c[k] = colors[i][k] + part * (colors[i + 1][k] - colors[i][k]);
    return c;
}

Backdrop::Float4 Backdrop::shadowed(float share, float key, float sky) const {
    Float4 c{};
    for (int k = 0; k < 3; ++k) {
        const float radiance = lit_[k] * key + ambient_[k] * sky;
        const float floor = look_up(tables.tone, std::min(radiance, brightest) * (tone_steps / brightest));
        c[k] = view_.background[k] + share * (floor - view_.background[k]);
    }
    return c;
}

void Backdrop::compose(std::span<const std::uint8_t> shaded, const GroundLight& light, Image& image,
                       int first, int last) const {
    const int width = view_.width, height = view_.height;
    const Float3 step_x = (2 * camera_.half_width / static_cast<float>(width)) * camera_.right;
    const Float3 step_y = (2 * camera_.half_height / static_cast<float>(height)) * camera_.up;
    const Float3 corner =
        camera_.forward - camera_.half_width * camera_.right - camera_.half_height * camera_.up;
    std::vector<float> shares(static_cast<std::size_t>(width), 0.0f);
    Float4 flat{};  // background where the floor ends
    for (int k = 0; k < 3; ++k) flat[k] = view_.background[k];
    for (int row = first; row < last; ++row) {
        const int y = height - 1 - row;  // OpenGL's rows start at the bottom
        const std::uint8_t* from = shaded.data() + std::size_t{4} * width * y;
        std::uint8_t* to = image.pixel(0, row);
        const Float3 start = corner + (static_cast<float>(y) + 0.5f) * step_y;
        if (has_ground_)
            for (int x = 0; x < width; ++x)
                shares[x] = floor_share(start + (static_cast<float>(x) + 0.5f) * step_x);
        // Rows of the light on both sides of this one's middle
        const float light_y = std::clamp(0.5f * (static_cast<float>(y) + 0.5f) - 0.5f, 0.0f,
                                         static_cast<float>(std::max(light.height - 1, 0)));
        const int y0 = static_cast<int>(light_y), y1 = std::min(y0 + 1, std::max(light.height - 1, 0));
        const float part_y = light_y - static_cast<float>(y0);
        const std::uint8_t* low = light.shares.data() + std::size_t{4} * light.width * y0;
        const std::uint8_t* high = light.shares.data() + std::size_t{4} * light.width * y1;
        for (int x = 0; x < width; ++x, from += 4, to += 4) {
            if (from[3] == 255) {
                for (int k = 0; k < 4; ++k) to[k] = from[k];
                continue;
            }
            Float4 color = flat;
            float dither = 0;
            if (shares[x] > 0) {
                // The floor's colour varies too slowly for 8 bits: an ordered pattern (Bayer 1973) hides the
                // steps.
                const int diagonal = x ^ y;
                const int order = (diagonal & 1) << 3 | (y & 1) << 2 | (diagonal & 2) | (y & 2) >> 1;
                dither = (static_cast<float>(order) - 7.5f) / 16;
                float key = 255, sky = 255;
                const int x0 = std::max((x - 1) / 2, 0), x1 = std::min(x0 + 1, std::max(light.width - 1, 0));
                const auto in_light = [](const std::uint8_t* p) { return (p[0] & p[1]) == 255; };
                const bool open_floor =
                    light.width == 0 || (in_light(low + 4 * x0) && in_light(low + 4 * x1) &&
                                         in_light(high + 4 * x0) && in_light(high + 4 * x1));
                if (open_floor && from[3] == 0) {  // most of the picture
                    const Float4 shown = behind(open_shown_, shares[x]);
                    for (int k = 0; k < 3; ++k)
                        to[k] = static_cast<std::uint8_t>(std::clamp(shown[k] + dither + 0.5f, 0.0f, 255.0f));
                    to[3] = 255;
                    continue;
                }
                if (!open_floor) {
                    const float part_x = x == 0 ? 0 : x % 2 == 0 ? 0.75f : 0.25f;
                    const auto at = [&](int channel) {
                        const float a = low[4 * x0 + channel], b = low[4 * x1 + channel];
                        const float c = high[4 * x0 + channel], d = high[4 * x1 + channel];
                        const float e = a + part_x * (b - a), f = c + part_x * (d - c);
                        return e + part_y * (f - e);
                    };
                    key = at(0);
                    sky = at(1);
                }
                color = key == 255 && sky == 255 ? behind(open_, shares[x])
                                                 : shadowed(shares[x], key / 255, sky / 255);
            }
            const float covered = static_cast<float>(from[3]) / 255, open = 1 - covered;
            for (int k = 0; k < 3; ++k) {
                const float c = covered > 0 ? covered * tables.decoded[from[k]] + open * color[k] : color[k];
                const float shown = look_up(tables.encoded, std::clamp(c, 0.0f, 1.0f) * srgb_steps);
                to[k] = static_cast<std::uint8_t>(std::clamp(shown + open * dither + 0.5f, 0.0f, 255.0f));
            }
            to[3] = 255;
        }
    }
}

}  // namespace cloth::render
