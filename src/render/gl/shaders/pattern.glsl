// Patterns on rest coordinates, averaged over a pixel's footprint: over a box of its extent in u and v, for
// which stripes and checks have exact means, so that they settle to their mean colour in the distance.

/// Mean over [x - w/2, x + w/2] of 1 where fract(x) lies in [0, duty].
float band(float x, float w, float duty) {
    x = fract(x);
    float a = x - 0.5 * w, b = x + 0.5 * w;
    float low = duty * floor(a) + min(fract(a), duty), high = duty * floor(b) + min(fract(b), duty);
    return clamp((high - low) / w, 0.0, 1.0);
}

#ifdef PATTERNS
/// Shares of the three pattern colours at `at` (in repeats), of a footprint `extent`.
vec3 pattern_shares(int kind, vec2 at, vec2 extent) {
    float across = band(at.x, extent.x, 0.5), along = band(at.y, extent.y, 0.5);
    vec3 stripes = vec3(across, 0.0, 0.0);
    vec3 checks = vec3(across + along - 2.0 * across * along, 0.0, 0.0);
    vec3 bands_u, bands_v;
    bands_u.y = band(at.x - 0.16, extent.x, 0.05);
    bands_u.x = band(at.x, extent.x, 0.37) - bands_u.y;
    bands_u.z = band(at.x - 0.60, extent.x, 0.03) + band(at.x - 0.74, extent.x, 0.03);
    bands_v.y = band(at.y - 0.16, extent.y, 0.05);
    bands_v.x = band(at.y, extent.y, 0.37) - bands_v.y;
    bands_v.z = band(at.y - 0.60, extent.y, 0.03) + band(at.y - 0.74, extent.y, 0.03);
    // Twill: warp and weft by turns on diagonals, 48 of them a repeat
    // averaged over twice the footprint: lines this fine would shimmer before they vanish
    float warp = band(24.0 * (at.x + at.y), 48.0 * (extent.x + extent.y), 0.5);
    vec3 tartan = mix(bands_v, bands_u, warp);
    // Dots on a square lattice and in its middles
    const float dot_radius = 0.25, dot_share = 0.3926991;  // 2 π r²
    vec2 near = fract(at) - 0.5, middle = fract(at + 0.5) - 0.5;
    float from_center = min(length(near), length(middle));
    float width = max(0.5 * (extent.x + extent.y), 1e-4);
    float dots = mix(clamp(0.5 + (dot_radius - from_center) / width, 0.0, 1.0), dot_share,
                     clamp(2.0 * width - 0.5, 0.0, 1.0));
    return kind == 1 ? stripes : kind == 2 ? checks : kind == 3 ? tartan : kind == 4 ? vec3(dots, 0.0, 0.0) : vec3(0.0);
}
#endif

#ifdef WEAVE
/// Slopes in u and v of plain-woven threads at `at` (in threads), and a mean-free share of light and dark; .w is the
/// variance of slope that the footprint has averaged away. All are sums of sines, each damped by its frequency.
vec4 weave_relief(vec2 at, vec2 extent) {
    const float pi = 3.14159265;
    vec2 square = extent * extent;
    vec2 slow = exp(-3.0 * square), mid = exp(-12.0 * square), fast = exp(-27.0 * square);
    at = fract(0.5 * at) * 2.0;
    vec2 s1 = sin(pi * at), c1 = cos(pi * at);
    vec2 s2 = 2.0 * s1 * c1;
    vec2 c3 = c1 * (4.0 * c1 * c1 - 3.0);
    // sin 2πu (1 + sin πu sin πv)/2, and with u and v exchanged and the sign of the turn
    float slope_u = 0.5 * mid.x * s2.x + 0.25 * slow.y * s1.y * (slow.x * c1.x - fast.x * c3.x);
    float slope_v = 0.5 * mid.y * s2.y - 0.25 * slow.x * s1.x * (slow.y * c1.y - fast.y * c3.y);
    float shade = slow.x * slow.y * s1.x * s1.y;
    float kept = 0.5 * (mid.x * mid.x + mid.y * mid.y);
    return vec4(slope_u, slope_v, shade, 0.16 * (1.0 - kept));
}
#endif
