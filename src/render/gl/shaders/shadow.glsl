// Share of the key light that reaches a point: the mean of bilinear depth comparisons on a disc, from its
// rim inwards. Where the first `settled` taps agree, the rest would too. The disc is as wide as the blockers
// in reach are far (Fernando 2005, Percentage-Closer Soft Shadows); its depth follows the receiver's plane,
// so that no tap meets the surface itself. The numbers of taps are variables so that llvmpipe leaves the
// loops as soon as no pixel of a block needs more.

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
