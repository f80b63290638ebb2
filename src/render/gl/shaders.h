#pragma once
// GLSL of the rasterizer's passes, but for the shading of surfaces (fabric_shader.h). Each program is a list
// of these pieces; the version line comes first.

namespace cloth::render::shaders {

inline constexpr const char* version = "#version 400 core\n";

/// Linear radiance → display-linear 0 … 1: unchanged below the knee, so that mid-tones keep their colour,
/// then an exponential shoulder of equal slope that ends at white.
inline constexpr const char* tone_curve = R"(
const float knee = 0.6;
vec3 tone_curve(vec3 radiance) {
    vec3 over = max(radiance - knee, 0.0);
    return min(radiance, knee) + (1.0 - knee) * (1.0 - exp(-over / (1.0 - knee)));
}
)";

/// Share of the key light that reaches a point: the mean of bilinear depth comparisons on a disc, from its
/// rim inwards. Where the first `settled` taps agree, the rest would too. The disc is as wide as the blockers
/// in reach are far (Fernando 2005, Percentage-Closer Soft Shadows); its depth follows the receiver's plane,
/// so that no tap meets the surface itself. The numbers of taps are variables so that llvmpipe leaves the
/// loops as soon as no pixel of a block needs more.
inline constexpr const char* shadow = R"(
uniform sampler2DShadow shadow_map;
uniform sampler2D shadow_depth;  // the same, as it is
uniform mat4 world_to_shadow;    // to texture coordinates and depth
uniform vec2 shadow_radius;      // of the disc: least and greatest, in texture coordinates
uniform float shadow_spread;     // radius over the depth between blocker and receiver
const mat2 golden_turn = mat2(-0.737369, 0.675490, -0.675490, -0.737369);  // spreads the taps evenly

float key_light_visibility(vec3 world, vec2 slope, int search_taps, int taps, int settled) {
    vec3 p = (world_to_shadow * vec4(world, 1.0)).xyz;
    float gaps = 0.0, blockers = 0.0, count = 0.0;
    vec2 direction = vec2(1.0, 0.0);
    float inverse = 1.0 / float(max(search_taps, 1));
    for (int i = 0; i < search_taps; ++i) {
        vec2 off = (sqrt(1.0 - (count + 0.5) * inverse) * shadow_radius.y) * direction;
        float z = textureLod(shadow_depth, p.xy + off, 0.0).r;
        float gap = p.z + dot(slope, off) - z;
        // Counted in by degrees, or the disc's width would jump.
        float weight = z < 1.0 ? clamp(gap * shadow_spread / shadow_radius.x, 0.0, 1.0) : 0.0;
        gaps += weight * gap;
        blockers += weight;
        count += 1.0;
        direction = golden_turn * direction;
    }
    // Where the search met nothing, or nothing else, the rest would too.
    bool open = search_taps > 0 && blockers < 0.001, closed = search_taps > 0 && blockers > count - 0.001;
    taps = open || closed ? 0 : taps;
    float disc = clamp(gaps / max(blockers, 0.001) * shadow_spread, shadow_radius.x, shadow_radius.y);
    direction = vec2(disc, 0.0);
    slope = slope * disc;
    float lit = 0.0;
    count = 0.0;
    inverse = 1.0 / float(max(taps, 1));
    vec2 turned = vec2(1.0, 0.0);
    for (int i = 0; i < taps; ++i) {
        vec2 off = sqrt(1.0 - (count + 0.5) * inverse) * turned;
        // beyond the farthest caster: lit where the map is empty
        lit += texture(shadow_map, vec3(p.xy + disc * off, min(p.z + dot(slope, off), 1.0)));
        count += 1.0;
        if (i + 1 == settled && (lit < 0.001 || lit > count - 0.001)) break;
        turned = golden_turn * turned;
    }
    return closed ? 0.0 : taps > 0 ? lit / count : 1.0;
}
)";

inline constexpr const char* depth_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 world_to_clip;
void main() { gl_Position = world_to_clip * vec4(position, 1.0); }
)";

inline constexpr const char* depth_fragment = "void main() {}\n";

/// Number of the triangle (of its last vertex, counted from 1), of its surface modulo 8, and which way it
/// faces.
inline constexpr const char* visibility_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 world_to_clip;
uniform float clip_height;
uniform int surface;
flat out int number;
void main() {
    gl_Position = world_to_clip * vec4(position, 1.0);
    gl_ClipDistance[0] = position.y - clip_height;
    number = gl_VertexID + 1 + (surface << 28);
}
)";

inline constexpr const char* visibility_fragment = R"(
flat in int number;
out uint fragment;
void main() { fragment = uint(number) | (gl_FrontFacing ? 0x80000000u : 0u); }
)";

/// Where the ray through a pixel meets the floor.
inline constexpr const char* ground_point = R"(
uniform vec3 eye;
uniform vec3 ray_corner;         // ray of pixel p: ray_corner + p.x ray_x + p.y ray_y, of distance 1
uniform vec3 ray_x;
uniform vec3 ray_y;
uniform float ground_height;
vec3 ground_point(vec3 ray) { return eye + ray * ((ground_height - eye.y) / min(ray.y, -1e-6)); }
)";

/// Shares of the key light and of the sky's light that reach the floor. Drawn at half the picture's size: on
/// the plane, whatever stands before it, nothing changes faster than that can hold.
inline constexpr const char* ground_light_fragment = R"(
uniform sampler2D ground_occlusion;
uniform vec4 ground_occlusion_place;  // scale and offset of x and z
#ifdef SHADOW
uniform vec4 shadow_place;       // low and high x z of where shadow can fall, in texture coordinates
uniform vec2 ground_slope;       // of the shadow map's depth on the floor
uniform int search_taps;
uniform int shadow_taps;
uniform int settled_taps;
#endif
out vec4 fragment;
void main() {
    vec3 point = ground_point(ray_corner + gl_FragCoord.x * ray_x + gl_FragCoord.y * ray_y);
    float open = texture(ground_occlusion, point.xz * ground_occlusion_place.xy + ground_occlusion_place.zw).r;
    float lit = 1.0;
#ifdef SHADOW
    vec2 p = (world_to_shadow * vec4(point, 1.0)).xy;
    bool inside = all(greaterThan(p, shadow_place.xy)) && all(lessThan(p, shadow_place.zw));
    lit = key_light_visibility(point, ground_slope, inside ? search_taps : 0, inside ? shadow_taps : 0, settled_taps);
#endif
    fragment = vec4(lit, open, 0.0, 1.0);
}
)";

}  // namespace cloth::render::shaders
