#include "render/raster/backdrop.h"

#include <cmath>
#include <cstring>
#include <utility>

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

/// By value, so that loops over it become vector instructions.
float limited(float x, float low, float high) {
    const float y = x < low ? low : x;
    return y < high ? y : high;
}

/// Linear interpolation at `place` ≥ 0, in steps.
float look_up(const float* table, float place) {
    const int i = static_cast<int>(place);
    return table[i] + (place - static_cast<float>(i)) * (table[i + 1] - table[i]);
}
float srgb_place(float c) {
    return limited(c, 0, 1) * srgb_steps;
}
float encoded(float c) {
    return look_up(tables.encoded.data(), srgb_place(c));
}

/// An ordered pattern (Bayer 1973) in -½ … ½: the floor's colour varies too slowly for 8 bits.
float dither(int x, int y) {
    const int diagonal = x ^ y;
    const int order = (diagonal & 1) << 3 | (y & 1) << 2 | (diagonal & 2) | (y & 2) >> 1;
    return (static_cast<float>(order) - 7.5f) / 16;
}

/// A channel of the floor where not all light reaches it, linear.
struct Shadowed {
    float lit, ambient, background;
    /// In the table of tones.
    float place(float key, float sky) const {
        const float radiance = lit * (key / 255) + ambient * (sky / 255);
        return limited(radiance, 0, brightest) * (tone_steps / brightest);
    }
    float color(float share, float place) const {
        return background + share * (look_up(tables.tone.data(), place) - background);
    }
};

std::uint32_t rounded(float shown) {
    return static_cast<std::uint32_t>(static_cast<std::int32_t>(limited(shown + 0.5f, 0, 255)));
}

}  // namespace

float tone_curve(float radiance) {
    constexpr float knee = 0.6f;
    return radiance <= knee ? radiance : knee + (1 - knee) * (1 - std::exp(-(radiance - knee) / (1 - knee)));
}

Backdrop::Backdrop(const View& view, const Ground* ground, const Float3& lit, const Float3& ambient)
    : view_(view), lit_(lit), ambient_(ambient) {
    if (ground) ground_ = *ground;
    const Camera camera = make_camera(view);
    step_x_ = (2 * camera.half_width / static_cast<float>(view.width)) * camera.right;
    step_y_ = (2 * camera.half_height / static_cast<float>(view.height)) * camera.up;
    corner_ = camera.forward - camera.half_width * camera.right - camera.half_height * camera.up;
    if (ground_) {
        depth_below_ = view.eye[1] - ground_->height;
        const float radius = ground_radius * length(view.target - view.eye);
        fade_ = 1 / (radius * radius);
        center_ = {view.target[0] - view.eye[0], view.target[2] - view.eye[2]};
    }
    for (int k = 0; k < 3; ++k) {
        const float floor = tone_curve(lit[k] + ambient[k]);
        for (int i = 0; i < open_steps + 2; ++i) {
            const float c =
                view.background[k] + static_cast<float>(i) / open_steps * (floor - view.background[k]);
            open_[k].push_back(c);
            open_shown_[k].push_back(encode(std::clamp(c, 0.0f, 1.0f)));
        }
    }
    open_picture_.resize(std::size_t{4} * view.width * view.height);
}

bool Backdrop::is_of(const View& view, const Ground* ground, const Float3& lit, const Float3& ambient) const {
    return view == view_ && ground_ == (ground ? std::optional(*ground) : std::nullopt) && lit == lit_ &&
           ambient == ambient_;
}

/// How much of the floor is seen along a ray, against the background: 1 at the disc's middle.
float Backdrop::floor_share(const Float3& ray) const {
    const float t = depth_below_ / limited(-ray[1], 1e-6f, infinity);
    const float x = t * ray[0] - center_[0], z = t * ray[2] - center_[1];
    const float share = 1 / (1 + (x * x + z * z) * fade_);
    return ray[1] < -1e-6f ? share * share : 0;
}

/// Of the pixels from `x` on, `y` from the bottom.
Backdrop::Run<float> Backdrop::floor_shares(int x, int y) const {
    Run<float> shares{};
    const Float3 start = corner_ + (static_cast<float>(y) + 0.5f) * step_y_;
    for (int i = 0; i < run; ++i)
        shares[i] = floor_share(start + (static_cast<float>(x + i) + 0.5f) * step_x_);
    return shares;
}

void Backdrop::draw_open(int first, int last) {
    Float3 background{};
    for (int k = 0; k < 3; ++k) background[k] = encoded(view_.background[k]);
    for (int row = first; row < last; ++row)
        for (int x = 0; x < view_.width; x += run) {
            const int y = view_.height - 1 - row;
            Run<float> shares{};
            if (ground_) shares = floor_shares(x, y);
            Run<std::uint32_t> colors;
            colors.fill(0xff000000);
            for (int k = 0; k < 3; ++k) {
                const float* table = open_shown_[k].data();
                const float flat = background[k];
                Run<float> floor{};
                for (int i = 0; i < run; ++i)
                    floor[i] = look_up(table, open_steps * shares[i]) + dither(i, y);
                for (int i = 0; i < run; ++i) colors[i] |= rounded(shares[i] > 0 ? floor[i] : flat) << 8 * k;
            }
            std::memcpy(open_picture_.data() + std::size_t{4} * (std::size_t{1} * row * view_.width + x),
                        colors.data(), std::size_t{4} * std::min(run, view_.width - x));
        }
}

/// Between the middles of four texels, each of 2x2 pixels.
Backdrop::LightRun Backdrop::light_of(const GroundLight& light, int x, int y) {
    LightRun result;
    const int last_x = light.width - 1, last_y = light.height - 1;
    const int y0 = y == 0 ? 0 : (y - 1) / 2, y1 = std::min(y0 + 1, last_y);
    const float part_y = y == 0 ? 0 : y % 2 == 0 ? 0.75f : 0.25f;
    const std::uint8_t* low = light.shares.data() + std::size_t{4} * light.width * y0;
    const std::uint8_t* high = light.shares.data() + std::size_t{4} * light.width * y1;
    // Columns from the one before the first pixel's to the one after the last's
    constexpr int columns = run / 2 + 2;
    std::array<float, columns> key{}, sky{};
    int all = 255;
    for (int i = 0; i < columns; ++i) {
        const int column = 4 * std::clamp(x / 2 - 1 + i, 0, last_x);
        const std::uint8_t *a = low + column, *b = high + column;
        all &= a[0] & a[1] & b[0] & b[1];
        key[i] = static_cast<float>(a[0]) + part_y * static_cast<float>(b[0] - a[0]);
        sky[i] = static_cast<float>(a[1]) + part_y * static_cast<float>(b[1] - a[1]);
    }
    result.open = all == 255;
    if (result.open) return result;
    for (int i = 0; i < run / 2; ++i)
        for (const auto& [from, to] : {std::pair{&key, &result.key}, {&sky, &result.sky}}) {
            const float a = (*from)[i], b = (*from)[i + 1], c = (*from)[i + 2];
            (*to)[2 * i] = a + 0.75f * (b - a);
            (*to)[2 * i + 1] = b + 0.25f * (c - b);
        }
    return result;
}

void Backdrop::compose(std::span<const std::uint8_t> shaded, const GroundLight& light, Image& image,
                       int first, int last) const {
    const int width = view_.width;
    for (int row = first; row < last; ++row) {
        const int y = view_.height - 1 - row;  // OpenGL's rows start at the bottom
        for (int x = 0; x < width; x += run)
            compose_run(shaded.data() + std::size_t{4} * (std::size_t{1} * width * y + x), light, x, y,
                        std::min(run, width - x), image.pixel(x, row));
    }
}

/// `count` pixels, from `x` on, over the open floor in `to`.
void Backdrop::compose_run(const std::uint8_t* from, const GroundLight& light, int x, int y, int count,
                           std::uint8_t* to) const {
    int least = 255, most = 0;
    for (int i = 0; i < count; ++i) {
        least = std::min<int>(least, from[4 * i + 3]);
        most = std::max<int>(most, from[4 * i + 3]);
    }
    if (least == 255) {
        std::memcpy(to, from, std::size_t{4} * count);
        return;
    }
    LightRun reached;
    if (ground_ && light.width > 0) reached = light_of(light, x, y);
    if (reached.open && most == 0) return;
    Run<float> shares{};
    if (ground_) shares = floor_shares(x, y);
    const auto in_light = [&](int i) {
        return reached.open || shares[i] <= 0 || (reached.key[i] == 255 && reached.sky[i] == 255);
    };

    if (!reached.open) {
        Run<std::uint32_t> colors{};
        std::memcpy(colors.data(), to, std::size_t{4} * count);
        Run<std::uint32_t> shown;
        shown.fill(0xff000000);
        const float *key = reached.key.data(), *sky = reached.sky.data(), *srgb_table = tables.encoded.data();
        for (int k = 0; k < 3; ++k) {
            const Shadowed shadowed{lit_[k], ambient_[k], view_.background[k]};
            // In steps, as GCC makes vector instructions of each but not of their sum.
            Run<float> at{}, c{};
            for (int i = 0; i < run; ++i) at[i] = shadowed.place(key[i], sky[i]);
            for (int i = 0; i < run; ++i) c[i] = shadowed.color(shares[i], at[i]);
            for (int i = 0; i < run; ++i) at[i] = srgb_place(c[i]);
            for (int i = 0; i < run; ++i)
                shown[i] |= rounded(look_up(srgb_table, at[i]) + dither(i, y)) << 8 * k;
        }
        for (int i = 0; i < run; ++i) colors[i] = in_light(i) ? colors[i] : shown[i];
        std::memcpy(to, colors.data(), std::size_t{4} * count);
    }
    if (most == 0) return;
    for (int i = 0; i < count; ++i, from += 4, to += 4) {
        if (from[3] == 255) std::copy_n(from, 4, to);
        if (from[3] == 255 || from[3] == 0) continue;
        const float covered = static_cast<float>(from[3]) / 255, open = 1 - covered;
        for (int k = 0; k < 3; ++k) {
            float behind = view_.background[k];
            if (shares[i] > 0 && in_light(i)) behind = look_up(open_[k].data(), open_steps * shares[i]);
            if (shares[i] > 0 && !in_light(i)) {
                const Shadowed shadowed{lit_[k], ambient_[k], view_.background[k]};
                behind = shadowed.color(shares[i], shadowed.place(reached.key[i], reached.sky[i]));
            }
            const float c = covered * tables.decoded[from[k]] + open * behind;
            const float shown = encoded(c);
            to[k] = static_cast<std::uint8_t>(rounded(shown + (shares[i] > 0 ? open * dither(i, y) : 0)));
        }
    }
}

}  // namespace cloth::render
