#pragma once
// GLSL of the rasterizer's passes. Each program is a list of these pieces; the version line comes first.

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
/// rim inwards. Where the first `settled` taps agree, the rest would too. Their number is a variable so that
/// llvmpipe leaves the loop as soon as no pixel of a block needs more.
inline constexpr const char* shadow = R"(
uniform sampler2DShadow shadow_map;
uniform mat4 world_to_shadow;   // to texture coordinates and depth
uniform float shadow_radius;    // of the disc, in texture coordinates
float key_light_visibility(vec3 world, int taps, int settled, vec2 first_direction) {
    vec3 p = (world_to_shadow * vec4(world, 1.0)).xyz;
    p.z = min(p.z, 1.0);  // beyond the farthest caster: lit where the map is empty
    vec2 direction = first_direction * shadow_radius;
    float lit = 0.0, count = 0.0;
    float inverse = 1.0 / float(max(taps, 1));
    for (int i = 0; i < taps; ++i) {
        float radius = sqrt(1.0 - (count + 0.5) * inverse);
        lit += texture(shadow_map, vec3(p.xy + radius * direction, p.z));
        count += 1.0;
        if (i + 1 == settled && (lit < 0.001 || lit > count - 0.001)) break;
        // the golden angle spreads the taps evenly
        direction = vec2(-0.737369 * direction.x - 0.675490 * direction.y,
                         0.675490 * direction.x - 0.737369 * direction.y);
    }
    return lit / max(count, 1.0);
}
)";

inline constexpr const char* depth_vertex = R"(
layout(location = 0) in vec3 position;
uniform mat4 world_to_clip;
void main() { gl_Position = world_to_clip * vec4(position, 1.0); }
)";

inline constexpr const char* depth_fragment = "void main() {}\n";

inline constexpr const char* surface_vertex = R"(
layout(location = 0) in vec3 position;
layout(location = 1) in vec3 normal;
layout(location = 2) in vec4 ambient;  // from above and below, on the front and on the back
uniform mat4 world_to_clip;
uniform float clip_height;
out vec3 surface_position;
out vec3 surface_normal;
out vec4 surface_ambient;
void main() {
    gl_Position = world_to_clip * vec4(position, 1.0);
    gl_ClipDistance[0] = position.y - clip_height;
    surface_position = position;
    surface_normal = normal;
    surface_ambient = ambient;
}
)";

/// Writes the square root of display-linear colour: 10 bits of it are finer than 8 bits of sRGB.
inline constexpr const char* surface_fragment = R"(
in vec3 surface_position;
in vec3 surface_normal;
in vec4 surface_ambient;
uniform vec3 eye;
uniform vec3 light_direction;
uniform vec3 light_radiance;     // reflected by a white, facing, diffuse plane
uniform vec3 sky;
uniform vec3 bounce;             // light from below
uniform vec3 front_color;
uniform vec3 back_color;
uniform vec3 lobe;               // fourth power of roughness, k of the Smith term, reflectance at normal incidence
uniform float sheen;
uniform float exposure;
uniform float winding;           // +1 where counter-clockwise triangles show the side of their normals
uniform bool two_sided;
uniform int shadow_taps;         // 0: no shadow
uniform float normal_offset;     // [m]
out vec4 fragment;

void main() {
    vec3 to_eye = normalize(eye - surface_position);
    bool front = !two_sided || gl_FrontFacing == (winding > 0.0);
    vec3 normal = normalize(surface_normal) * (front ? 1.0 : -1.0);
    vec2 ambient = front ? surface_ambient.xy : surface_ambient.zw;
    vec3 albedo = front ? front_color : back_color;
    // Interpolated normals may point away from the viewer near an outline; bend them back into view.
    float facing = dot(normal, to_eye);
    if (facing < 0.02) normal = normalize(normal + (0.02 - facing) * to_eye);

    float cos_eye = max(dot(normal, to_eye), 0.02);
    float cos_light = dot(normal, light_direction);

    // Four neighbouring samples become one pixel; each turns the disc by a quarter, so that the pixel sees four
    // times the taps.
    ivec2 corner = ivec2(gl_FragCoord.xy) & 1;
    vec2 turn = corner.x == corner.y ? vec2(1.0, 0.0) : vec2(0.0, 1.0);
    turn = corner.y == 0 ? turn : -turn;
    // The receiver is moved off its surface, the more the steeper the light grazes it, so that no tap on the disc
    // meets the surface itself.
    float slope = sqrt(clamp(1.0 - cos_light * cos_light, 0.0, 1.0));
    vec3 receiver = surface_position + normal * (normal_offset * (0.25 + slope));
    float lit = 1.0;
    if (shadow_taps > 0) lit = key_light_visibility(receiver, cos_light > 0.0 ? shadow_taps : 0, 0, turn);
    cos_light = max(cos_light, 0.0);

    vec3 halfway = normalize(to_eye + light_direction);
    float cos_half = clamp(dot(normal, halfway), 0.0, 1.0);
    float cos_difference = clamp(dot(to_eye, halfway), 0.0, 1.0);
    float grazing = 1.0 - cos_difference;
    float fresnel = lobe.z + (1.0 - lobe.z) * grazing * grazing * grazing * grazing * grazing;
    fresnel = lobe.z > 0.0 ? fresnel : 0.0;
    // GGX (Walter et al. 2007) with Schlick's Smith term; times π, as light_radiance holds 1/π
    float d = cos_half * cos_half * (lobe.x - 1.0) + 1.0;
    float specular = fresnel * lobe.x /
                     (4.0 * d * d * (cos_light * (1.0 - lobe.y) + lobe.y) * (cos_eye * (1.0 - lobe.y) + lobe.y));
    // Charlie sheen of roughness 1/2 (Estevez and Kulla 2017) with Neubelt and Pettineo's shadowing
    float charlie = 2.0 * (1.0 - cos_half * cos_half) / (4.0 * (cos_light + cos_eye - cos_light * cos_eye));
    vec3 fiber = mix(albedo, vec3(1.0), 0.2) * sheen;

    vec3 radiance = light_radiance * (lit * cos_light) * (albedo * (1.0 - fresnel) + specular + fiber * charlie);

    vec3 from_above = sky * ambient.x, from_below = bounce * ambient.y;
    // What neither sky nor floor reaches is lit by the surfaces around it, which here are taken to look alike.
    float enclosed = clamp(1.0 - ambient.x - ambient.y, 0.0, 1.0);
    vec3 ambient_light = from_above + from_below + (0.4 * enclosed) * albedo * (sky * 0.6 + bounce * 0.4);
    float rim = 1.0 - cos_eye;
    radiance += ambient_light * (albedo + fiber * (rim * rim * rim));
    fragment = vec4(sqrt(tone_curve(radiance * exposure)), 1.0);
}
)";

inline constexpr const char* screen_vertex = R"(
void main() {
    vec2 corner = vec2((gl_VertexID << 1) & 2, gl_VertexID & 2);  // one triangle that covers the picture
    gl_Position = vec4(2.0 * corner - 1.0, 1.0, 1.0);             // behind all else
}
)";

/// Four samples → one pixel, over the floor and the background, which need no supersampling: the floor is
/// found along the pixel's ray and has no edge of its own.
inline constexpr const char* resolve_fragment = R"(
uniform sampler2D samples;
uniform vec3 background;
uniform bool has_ground;
uniform vec3 eye;
uniform vec3 ray_corner;         // ray of pixel p: ray_corner + p.x ray_x + p.y ray_y
uniform vec3 ray_x;
uniform vec3 ray_y;
uniform float ground_height;
uniform vec2 ground_center;
uniform float ground_fade;       // 1 / radius²
uniform vec3 ground_open;        // display-linear colour far from all objects
#ifdef NEAR_OBJECTS
uniform vec3 ground_lit;         // exposed radiance due to the key light
uniform vec3 ground_ambient;     // and to the sky
uniform sampler2D ground_occlusion;
uniform vec4 ground_occlusion_place;  // scale and offset of x and z
uniform vec4 shadow_place;       // low and high x z of where shadow can fall, in texture coordinates
uniform int shadow_taps;
uniform int settled_taps;
#endif
out vec4 fragment;

vec3 srgb(vec3 c) {
    return mix(12.92 * c, 1.055 * pow(max(c, 1e-5), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c));
}

void main() {
    ivec2 place = 2 * ivec2(gl_FragCoord.xy);
    vec4 a = texelFetch(samples, place, 0), b = texelFetch(samples, place + ivec2(1, 0), 0);
    vec4 c = texelFetch(samples, place + ivec2(0, 1), 0), d = texelFetch(samples, place + ivec2(1, 1), 0);
    vec3 covered = 0.25 * (a.rgb * a.rgb + b.rgb * b.rgb + c.rgb * c.rgb + d.rgb * d.rgb);
    float coverage = 0.25 * (a.a + b.a + c.a + d.a);

    vec3 behind = background;
    float dither = 0.0;
    if (has_ground) {
        vec3 ray = ray_corner + gl_FragCoord.x * ray_x + gl_FragCoord.y * ray_y;
        vec3 point = eye + ray * ((ground_height - eye.y) / min(ray.y, -1e-6));
        vec2 off = point.xz - ground_center;
        float visible = 1.0 / (1.0 + dot(off, off) * ground_fade);
        visible = ray.y < -1e-6 ? visible * visible : 0.0;
        vec3 ground = ground_open;
#ifdef NEAR_OBJECTS
        float lit = 1.0;
        float open = texture(ground_occlusion, point.xz * ground_occlusion_place.xy + ground_occlusion_place.zw).r;
        if (shadow_taps > 0) {
            vec2 p = (world_to_shadow * vec4(point, 1.0)).xy;
            bool inside = all(greaterThan(p, shadow_place.xy)) && all(lessThan(p, shadow_place.zw));
            int taps = inside && coverage < 1.0 ? shadow_taps : 0;
            float visibility = key_light_visibility(point, taps, settled_taps, vec2(1.0, 0.0));
            lit = taps > 0 ? visibility : 1.0;
        }
        ground = tone_curve(ground_lit * lit + ground_ambient * open);
#endif
        behind = mix(background, ground, visible);
        // The floor's colour varies too slowly for 8 bits: an ordered pattern (Bayer 1973) hides the steps.
        ivec2 cell = ivec2(gl_FragCoord.xy), diagonal = cell ^ cell.yx;
        int order = (diagonal.x & 1) << 3 | (cell.y & 1) << 2 | (diagonal.x & 2) | (cell.y & 2) >> 1;
        dither = ray.y < -1e-6 ? (float(order) - 7.5) / (16.0 * 255.0) : 0.0;
    }
    fragment = vec4(srgb(covered + (1.0 - coverage) * behind) + (1.0 - coverage) * dither, 1.0);
}
)";

}  // namespace cloth::render::shaders
