#pragma once
// Where things fall: the camera's picture, the light's map, the part of the floor near the objects.

#include <vector>

#include "render/vector_math.h"

namespace cloth::render {

struct Camera {
    Float3 right, up, forward;
    float half_width, half_height;  ///< of the picture, at distance 1
    float near;  ///< clip depth is distance - 2 near, over distance: the far plane is at infinity [m]
    Matrix world_to_clip;
};
Camera make_camera(const View& view);

/// Rectangle of pixels.
struct PixelBox {
    int x, y, width, height;  ///< y from the bottom
};
/// Pixels that can show something inside `bounds`; all of them where a part of it lies behind the eye.
PixelBox pixels_of(const Bounds& bounds, const Camera& camera, const View& view);

/// An orthographic view from the light that holds some bounds.
struct ShadowView {
    Matrix world_to_clip, world_to_texture;
    Float3 x{}, y{};               ///< axes of the map, unit length
    int size = 0;                  ///< of the map [texel]
    float texel = 0;               ///< [m]
    float radius = 0;              ///< of the filter's disc where a blocker is near [m]
    float largest_radius = 0;      ///< and at most [m]
    float width = 1, depth = 1;    ///< of the map [m]
    std::array<float, 4> place{};  ///< of the bounds in the texture: low x, low y, high x, high y
};
ShadowView make_shadow_view(const Light& light, const Bounds& bounds);

/// Outwards to multiples of a sixteenth of the longest side, itself rounded up to a power of two. The grids
/// laid over the bounds then stay in place from frame to frame, and so do the last bits of soft edges.
Bounds widened(Bounds b);

/// The part of a floor that objects in some bounds can occlude.
struct GroundPatch {
    std::array<float, 2> low, high;  ///< x z [m]
    float height;                    ///< y [m]
};
GroundPatch ground_patch(const Bounds& bounds, float height);

}  // namespace cloth::render
