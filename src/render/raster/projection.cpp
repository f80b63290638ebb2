#include "render/raster/projection.h"

#include <numbers>

namespace cloth::render {
namespace {

// The least soft edge is this many texels of the map to each side, within these sizes of map: fewer would
// show steps. The widest is so many texels: more could not be filled by the taps.
constexpr float softness_texels = 2.5f, largest_texels = 18;
constexpr int smallest_shadow_map = 256, largest_shadow_map = 2048;

/// Rows: three axes and their offsets, then w = 1.
Matrix affine(const Float3& x, float ox, const Float3& y, float oy, const Float3& z, float oz) {
    return {x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ox, oy, oz, 1};
}

}  // namespace

Camera make_camera(const View& view) {
    Camera c;
    const Float3 sight = view.target - view.eye;
    c.forward = normalized(sight);
    c.right = normalized(cross(c.forward, view.up));
    c.up = cross(c.right, c.forward);
    c.half_height = std::tan(0.5f * view.field_of_view * std::numbers::pi_v<float> / 180);
    c.half_width = c.half_height * static_cast<float>(view.width) / static_cast<float>(view.height);
    c.near = 0.01f * length(sight);
    const Float3 x = (1 / c.half_width) * c.right, y = (1 / c.half_height) * c.up;
    c.world_to_clip =
        affine(x, -dot(x, view.eye), y, -dot(y, view.eye), c.forward, -dot(c.forward, view.eye) - 2 * c.near);
    for (int i = 0; i < 3; ++i) c.world_to_clip[4 * i + 3] = c.forward[i];
    c.world_to_clip[15] = -dot(c.forward, view.eye);
    return c;
}

PixelBox pixels_of(const Bounds& bounds, const Camera& camera, const View& view) {
    const PixelBox all{0, 0, view.width, view.height};
    float low_x = infinity, low_y = infinity, high_x = -infinity, high_y = -infinity;
    for (const Float3& corner : box_corners(bounds)) {
        const Float3 p = corner - view.eye;
        const float distance = dot(p, camera.forward);
        if (!(distance > camera.near)) return all;
        const float x = (0.5f + 0.5f * dot(p, camera.right) / (distance * camera.half_width)) *
                        static_cast<float>(view.width);
        const float y = (0.5f + 0.5f * dot(p, camera.up) / (distance * camera.half_height)) *
                        static_cast<float>(view.height);
        low_x = std::min(low_x, x);
        low_y = std::min(low_y, y);
        high_x = std::max(high_x, x);
        high_y = std::max(high_y, y);
    }
    const auto inside = [](float x, int side) {
        return static_cast<int>(std::clamp(x, 0.0f, static_cast<float>(side)));
    };
    const int x0 = inside(std::floor(low_x) - 1, view.width), y0 = inside(std::floor(low_y) - 1, view.height);
    const int x1 = inside(std::ceil(high_x) + 1, view.width), y1 = inside(std::ceil(high_y) + 1, view.height);
    return {x0, y0, x1 - x0, y1 - y0};
}

ShadowView make_shadow_view(const Light& light, const Bounds& bounds) {
    ShadowView s;
    // Of the turns about the light's direction, take the one with a horizontal side: boxes fit well.
    const Float3 z = -1.0f * normalized(light.direction);
    s.x = normalized(std::abs(z[1]) < 0.999f ? cross({0, 1, 0}, z) : cross({0, 0, 1}, z));
    s.y = cross(z, s.x);
    Bounds b = nothing;
    for (const Float3& corner : box_corners(bounds)) {
        const Float3 p{dot(s.x, corner), dot(s.y, corner), dot(z, corner)};
        b = merged(b, {p, p});
    }
    const float widest = std::max({b.high[0] - b.low[0], b.high[1] - b.low[1], 1e-5f});
    const float deep = std::max(b.high[2] - b.low[2], 1e-5f);
    // The border holds the filter's disc.
    const float spread = std::tan(0.5f * light.angle * std::numbers::pi_v<float> / 180);
    const float border = std::max(light.softness, std::min(2 * deep * spread, 0.05f * widest));
    const float half = 0.5f * widest * (1 + 8.0f / smallest_shadow_map) + 1.5f * border;
    const Float3 center = 0.5f * (b.low + b.high);
    const float wanted = 2 * half * softness_texels / std::max(light.softness, 1e-6f);
    s.size = std::clamp(64 * static_cast<int>(std::min(wanted / 64, 1e6f)), smallest_shadow_map,
                        largest_shadow_map);
    s.width = 2 * half;
    s.texel = s.width / static_cast<float>(s.size);
    s.radius = std::max(light.softness, s.texel);
    s.largest_radius = std::max(s.radius, std::min(border, largest_texels * s.texel));
    const float depth_scale = 0.98f / deep, depth_offset = 0.01f - depth_scale * b.low[2];
    s.depth = 1 / depth_scale;
    s.world_to_clip = affine((1 / half) * s.x, -center[0] / half, (1 / half) * s.y, -center[1] / half,
                             (2 * depth_scale) * z, 2 * depth_offset - 1);
    s.world_to_texture = affine((0.5f / half) * s.x, 0.5f - 0.5f * center[0] / half, (0.5f / half) * s.y,
                                0.5f - 0.5f * center[1] / half, depth_scale * z, depth_offset);
    for (int i = 0; i < 2; ++i) {
        const float reach = 0.5f * (b.high[i] - b.low[i]) + 1.5f * border + 2 * s.texel;
        s.place[i] = 0.5f - 0.5f * reach / half;
        s.place[i + 2] = 0.5f + 0.5f * reach / half;
    }
    return s;
}

Bounds widened(Bounds b) {
    float longest = 1e-3f;
    for (int i = 0; i < 3; ++i) longest = std::max(longest, b.high[i] - b.low[i]);
    const float step = std::exp2(std::ceil(std::log2(longest))) / 16;
    for (int i = 0; i < 3; ++i) {
        b.low[i] = step * std::floor(b.low[i] / step);
        b.high[i] = step * std::ceil(b.high[i] / step);
    }
    return b;
}

GroundPatch ground_patch(const Bounds& b, float height) {
    // Occlusion ends about as far out as the objects reach up.
    const float margin = std::max({b.high[1] - height, b.high[1] - b.low[1],
                                   0.25f * std::max(b.high[0] - b.low[0], b.high[2] - b.low[2])});
    return {{b.low[0] - margin, b.low[2] - margin}, {b.high[0] + margin, b.high[2] + margin}, height};
}

}  // namespace cloth::render
