#pragma once
// What all passes of one draw share.

#include "render/frame.h"
#include "render/raster/projection.h"
#include "render/vector_math.h"

namespace cloth::render {

struct Shot {
    const Frame& frame;
    const View& view;
    Camera camera;
    Bounds bounds;      // of what casts shadows and occludes
    PixelBox box{};     // pixels that can show surfaces
    Float3 to_light{};  // unit length
    Float3 key{};       // radiance of a white plane that faces the light
    Float3 bounce{};    // light from below
    ShadowView shadow_view{};
    bool shadow = false, occlusion = false, ground = false;
};

/// Ray of pixel p: corner + p.x x + p.y y, of distance 1.
struct Rays {
    Float3 corner, x, y;
};
/// `step`: pixels of the picture per pixel of what is drawn.
inline Rays make_rays(const Shot& shot, int step) {
    const Camera& c = shot.camera;
    const auto halves = static_cast<float>(2 * step);
    return {c.forward - c.half_width * c.right - c.half_height * c.up,
            (halves * c.half_width / static_cast<float>(shot.view.width)) * c.right,
            (halves * c.half_height / static_cast<float>(shot.view.height)) * c.up};
}

}  // namespace cloth::render
