// Writes the colour of what is seen as sRGB, and its share of the pixel.

uniform usampler2D numbers;      // of the triangles, 2x2 samples a pixel
uniform sampler2D depths;        // 1 - near / distance
uniform usamplerBuffer corners;  // three vertices and the surface
uniform usamplerBuffer vertices; // bits of x y z and of the normal
uniform usamplerBuffer ambients; // four bytes each
#if defined(PATTERNS) || defined(WEAVE) || defined(IMAGES)
uniform samplerBuffer coordinates;
#endif
uniform samplerBuffer materials;
#ifdef COLORS
uniform samplerBuffer colors;
#endif
#ifdef IMAGES
uniform sampler2D images[IMAGES];
#endif
uniform vec3 eye;
uniform vec3 ray_corner;         // ray of pixel p: ray_corner + p.x ray_x + p.y ray_y, of distance 1
uniform vec3 ray_x;
uniform vec3 ray_y;
uniform vec2 texel;              // a pixel's width and height in the samples' texture
uniform float near;              // [m]
uniform vec3 light_direction;
uniform vec3 light_radiance;     // reflected by a white, facing, diffuse plane
uniform vec3 sky;
uniform vec3 bounce;             // light from below
uniform float exposure;
uniform vec3 shadow_x;           // axes of the map, times depth's scale over theirs
uniform vec3 shadow_y;
uniform int search_taps;
uniform int shadow_taps;         // 0: no shadow
uniform int settled_taps;
uniform float normal_offset;     // [m]
out vec4 fragment;

/// A unit vector from the two halves of its octahedral image.
vec3 unpack_normal(uint bits) {
    vec2 o = vec2(ivec2(int(bits << 16) >> 16, int(bits) >> 16)) / 32767.0;
    vec3 n = vec3(o, 1.0 - abs(o.x) - abs(o.y));
    float fold = max(-n.z, 0.0);
    n.xy += vec2(n.x >= 0.0 ? -fold : fold, n.y >= 0.0 ? -fold : fold);
    return n;
}

/// A triangle that a pixel sees.
struct Seen {
    ivec3 vertices;
    int surface;
    bool counter_clockwise;
    vec3 p0, e1, e2;     // a corner, and the edges from there
    uvec3 normals;
};

vec3 shade(Seen s, vec2 place) {
    ivec3 v = s.vertices;
    vec3 n0 = unpack_normal(s.normals.x), n1 = unpack_normal(s.normals.y), n2 = unpack_normal(s.normals.z);
    vec4 a0 = unpackUnorm4x8(texelFetch(ambients, v.x).r), a1 = unpackUnorm4x8(texelFetch(ambients, v.y).r),
         a2 = unpackUnorm4x8(texelFetch(ambients, v.z).r);
    vec3 p0 = s.p0, e1 = s.e1, e2 = s.e2;
    int entry = 7 * s.surface;
    vec4 front_color = texelFetch(materials, entry), back_color = texelFetch(materials, entry + 1);
    vec4 kind = texelFetch(materials, entry + 2);  // reflectance at normal incidence, sheen, two-sided, winding

    // Where the ray meets the triangle's plane, as shares of the corners
    vec3 across = cross(e1, e2);
    vec3 ray = ray_corner + place.x * ray_x + place.y * ray_y;
    float towards = dot(across, ray);
    float distance = dot(across, p0 - eye) / towards;
    vec3 hit = eye + distance * ray - p0;
    float scale = 1.0 / dot(across, across);
    vec2 share = scale * vec2(dot(cross(hit, e2), across), dot(cross(e1, hit), across));
    // Beside a tiny triangle, not far from it
    vec3 shares = clamp(vec3(1.0 - share.x - share.y, share), -0.5, 1.5);
    shares /= shares.x + shares.y + shares.z;
    vec3 position = p0 + shares.y * e1 + shares.z * e2;
    vec3 to_eye = normalize(eye - position);

    bool two_sided = kind.z > 0.0;
    bool front = !two_sided || s.counter_clockwise == (kind.w > 0.0);
    vec3 normal = normalize(shares.x * normalize(n0) + shares.y * normalize(n1) + shares.z * normalize(n2)) * (front ? 1.0 : -1.0);
    vec4 ambients_here = shares.x * a0 + shares.y * a1 + shares.z * a2;
    vec2 ambient = front ? ambients_here.xy : ambients_here.zw;
    vec3 albedo = front ? front_color.rgb : back_color.rgb;
    vec2 lobe = vec2(front_color.a, back_color.a);  // fourth power of roughness, k of the Smith term
#ifdef COLORS
    vec4 own = shares.x * texelFetch(colors, v.x) + shares.y * texelFetch(colors, v.y) + shares.z * texelFetch(colors, v.z);
    albedo = own.a > 0.5 ? own.rgb : albedo;
#endif
    // Interpolated normals may point away from the viewer near an outline; bend them back into view.
    float facing = dot(normal, to_eye);
    if (facing < 0.02) normal = normalize(normal + (0.02 - facing) * to_eye);
    vec3 receiver_normal = normal;

#if defined(PATTERNS) || defined(WEAVE) || defined(IMAGES)
    // Rest coordinates, and how they change from this pixel to the next ones
    vec2 uv0 = texelFetch(coordinates, v.x).rg, uv1 = texelFetch(coordinates, v.y).rg - uv0,
         uv2 = texelFetch(coordinates, v.z).rg - uv0;
    vec2 uv = uv0 + shares.y * uv1 + shares.z * uv2;
    vec3 step_x = distance * (ray_x - ray * (dot(across, ray_x) / towards));
    vec3 step_y = distance * (ray_y - ray * (dot(across, ray_y) / towards));
    vec2 uv_x = scale * (uv1 * dot(cross(step_x, e2), across) + uv2 * dot(cross(e1, step_x), across));
    vec2 uv_y = scale * (uv1 * dot(cross(step_y, e2), across) + uv2 * dot(cross(e1, step_y), across));
    vec2 extent = max(abs(uv_x) + abs(uv_y), 1e-6);
    vec4 cloth = texelFetch(materials, entry + 3);  // pattern, repeats and threads per metre, slope of the threads
    vec4 color1 = texelFetch(materials, entry + 4), color2 = texelFetch(materials, entry + 5);
    vec3 color3 = texelFetch(materials, entry + 6).rgb;
    bool patterned = front || color1.a > 0.0;
#ifdef PATTERNS
    vec3 colored = pattern_shares(int(cloth.x), uv * cloth.y, extent * cloth.y);
    colored = patterned ? colored : vec3(0.0);
    albedo = albedo * (1.0 - colored.x - colored.y - colored.z) + colored.x * color1.rgb + colored.y * color2.rgb +
             colored.z * color3;
#endif
#ifdef IMAGES
    // Four taps along the footprint's longer side, at the level of its shorter one
    vec2 image_x = uv_x * cloth.y, image_y = uv_y * cloth.y;
    bool wide = dot(image_x, image_x) > dot(image_y, image_y);
    vec2 long_side = wide ? image_x : image_y, short_side = wide ? image_y : image_x;
    float least = 0.25 * length(long_side);
    short_side *= max(1.0, least / max(length(short_side), 1e-9));
    for (int i = 0; i < IMAGES; ++i) {
        vec2 at = vec2(uv.x * cloth.y, uv.y * cloth.y);
        vec2 size = vec2(textureSize(images[i], 0));
        at.y *= size.x / size.y;
        vec2 stretch = vec2(1.0, size.x / size.y);
        vec3 sum = vec3(0.0);
        for (int tap = 0; tap < 4; ++tap)
            sum += textureGrad(images[i], at + (float(tap) - 1.5) * 0.25 * long_side * stretch,
                               0.25 * long_side * stretch, short_side * stretch).rgb;
        albedo = patterned && int(color2.a) == i + 1 ? 0.25 * sum : albedo;
    }
#endif
#ifdef WEAVE
    vec4 relief = weave_relief(uv * cloth.z, extent * cloth.z) * (cloth.z > 0.0 ? 1.0 : 0.0);
    float area = uv1.x * uv2.y - uv1.y * uv2.x;
    vec3 tangent_u = (e1 * uv2.y - e2 * uv1.y) / area, tangent_v = (e2 * uv1.x - e1 * uv2.x) / area;
    float side = front ? 1.0 : -1.0;  // a thread that lies on top here lies below on the other side
    vec3 bent = normalize(normal - cloth.w * (relief.x * tangent_u + side * relief.y * tangent_v));
    normal = abs(area) > 0.0 && dot(bent, to_eye) > 0.02 ? bent : normal;
    albedo *= 1.0 + 0.3 * cloth.w * relief.z;
    lobe.x = min(lobe.x + 2.0 * cloth.w * cloth.w * relief.w, 1.0);
    lobe.y = 0.5 * sqrt(lobe.x);
#endif
#endif

    float cos_eye = max(dot(normal, to_eye), 0.02);
    float cos_light = dot(normal, light_direction);
    // The receiver is moved off its surface, the more the steeper the light grazes it, by the size of a texel.
    float cos_receiver = dot(receiver_normal, light_direction);
    float slope = sqrt(clamp(1.0 - cos_receiver * cos_receiver, 0.0, 1.0));
    vec3 receiver = position + receiver_normal * (normal_offset * (0.25 + slope));
    vec2 depth_slope = vec2(dot(receiver_normal, shadow_x), dot(receiver_normal, shadow_y)) / max(cos_receiver, 0.05);
    bool turned_away = min(cos_light, cos_receiver) <= 0.0;
    float lit = key_light_visibility(receiver, depth_slope, turned_away ? 0 : search_taps,
                                     turned_away ? 0 : shadow_taps, settled_taps);
    lit = turned_away ? 0.0 : lit;
    cos_light = max(cos_light, 0.0);

    vec3 halfway = normalize(to_eye + light_direction);
    float cos_half = clamp(dot(normal, halfway), 0.0, 1.0);
    float cos_difference = clamp(dot(to_eye, halfway), 0.0, 1.0);
    float grazing = 1.0 - cos_difference;
    float fresnel = kind.x + (1.0 - kind.x) * grazing * grazing * grazing * grazing * grazing;
    fresnel = kind.x > 0.0 ? fresnel : 0.0;
    // GGX (Walter et al. 2007) with Schlick's Smith term; times π, as light_radiance holds 1/π
    float d = cos_half * cos_half * (lobe.x - 1.0) + 1.0;
    float specular = fresnel * lobe.x /
                     (4.0 * d * d * (cos_light * (1.0 - lobe.y) + lobe.y) * (cos_eye * (1.0 - lobe.y) + lobe.y));
    // Charlie sheen of roughness 1/2 (Estevez and Kulla 2017) with Neubelt and Pettineo's shadowing
    float charlie = 2.0 * (1.0 - cos_half * cos_half) / (4.0 * (cos_light + cos_eye - cos_light * cos_eye));
    vec3 fiber = mix(albedo, vec3(1.0), 0.2) * kind.y;

    vec3 radiance = light_radiance * (lit * cos_light) * (albedo * (1.0 - fresnel) + specular + fiber * charlie);

    vec3 from_above = sky * ambient.x, from_below = bounce * ambient.y;
    // What neither sky nor floor reaches is lit by the surfaces around it, which are taken to look alike and to have
    // a third of the key light.
    float enclosed = clamp(1.0 - ambient.x - ambient.y, 0.0, 1.0);
    vec3 ambient_light = from_above + from_below + enclosed * albedo * (sky * 0.4 + bounce * 0.3 + light_radiance * 0.3);
    // Of even light from everywhere, what the sheen returns (a fit to its integral) and what is mirrored (Karis 2014,
    // Physically Based Shading on Mobile, after Lazarov)
    float rim = 1.0 - cos_eye;
    float sheen = 0.083 + 0.27 * rim + 0.33 * rim * rim * rim;
    vec4 fit = sqrt(sqrt(lobe.x)) * vec4(-1.0, -0.0275, -0.572, 0.022) + vec4(1.0, 0.0425, 1.04, -0.04);
    float smooth_part = min(fit.x * fit.x, exp2(-9.28 * cos_eye)) * fit.x + fit.y;
    float mirror = kind.x > 0.0 ? kind.x * (fit.z - 1.04 * smooth_part) + fit.w + 1.04 * smooth_part : 0.0;
    float upwards = clamp(0.5 + 2.0 * cos_eye * normal.y - to_eye.y, 0.0, 1.0);
    radiance += ambient_light * (albedo + fiber * sheen) + mix(bounce, sky, upwards) * ((1.0 - enclosed) * mirror);
    return tone_curve(radiance * exposure);
}

void main() {
    // The four samples of a pixel, as a gather orders them
    const vec4 left_right = vec4(-0.25, 0.25, 0.25, -0.25), down_up = vec4(0.25, 0.25, -0.25, -0.25);
    vec2 gathered = gl_FragCoord.xy * texel;
    vec4 inverse = 1.0 - textureGather(depths, gathered);
    uvec4 number = textureGather(numbers, gathered);
    number = uvec4(inverse.x > 0.0 ? number.x : 0u, inverse.y > 0.0 ? number.y : 0u, inverse.z > 0.0 ? number.z : 0u,
                   inverse.w > 0.0 ? number.w : 0u);
    vec4 waiting = vec4(notEqual(number, uvec4(0u)));
    float coverage = 0.25 * dot(waiting, vec4(1.0));
    vec3 sum = vec3(0.0);
    vec3 ray = ray_corner + gl_FragCoord.x * ray_x + gl_FragCoord.y * ray_y;
    // Samples that lie in the plane of the first one's triangle are shaded with it, at their middle; then those
    // that are left. Inside a surface that is once a pixel.
    for (int pass = 0; pass < 4; ++pass) {
        if (dot(waiting, vec4(1.0)) < 0.5) break;
        vec4 first = waiting.x > 0.0   ? vec4(1.0, 0.0, 0.0, 0.0)
                     : waiting.y > 0.0 ? vec4(0.0, 1.0, 0.0, 0.0)
                     : waiting.z > 0.0 ? vec4(0.0, 0.0, 1.0, 0.0)
                                       : vec4(0.0, 0.0, 0.0, 1.0);
        uint chosen = first.x > 0.0 ? number.x : first.y > 0.0 ? number.y : first.z > 0.0 ? number.z : number.w;
        uvec4 triangle = texelFetch(corners, int(chosen & 0x0fffffffu) - 1);
        ivec3 v = ivec3(triangle.xyz);
        uvec4 c0 = texelFetch(vertices, v.x), c1 = texelFetch(vertices, v.y), c2 = texelFetch(vertices, v.z);
        vec3 p0 = uintBitsToFloat(c0.xyz);
        Seen seen = Seen(v, int(triangle.w), chosen >= 0x80000000u, p0, uintBitsToFloat(c1.xyz) - p0,
                         uintBitsToFloat(c2.xyz) - p0, uvec3(c0.w, c1.w, c2.w));
        vec3 across = cross(seen.e1, seen.e2);
        // near / distance is linear over the picture
        vec3 gradient = (near / dot(across, p0 - eye)) * vec3(dot(across, ray), dot(across, ray_x), dot(across, ray_y));
        vec4 expected = gradient.x + gradient.y * left_right + gradient.z * down_up;
        float tolerance = gradient.x * 0.5 * length(ray_x) + 0.5 * (abs(gradient.y) + abs(gradient.z));
        vec4 alike = vec4(lessThan(abs(expected - inverse), vec4(tolerance))) *
                     vec4(equal(number >> 28, uvec4(chosen >> 28)));
        vec4 mine = max(waiting * alike, first);
        float samples = dot(mine, vec4(1.0));
        vec2 middle = gl_FragCoord.xy + vec2(dot(mine, left_right), dot(mine, down_up)) / samples;
        sum += (0.25 * samples) * shade(seen, middle);
        waiting -= mine;
    }
    vec3 c = sum / max(coverage, 0.25);
    fragment = vec4(mix(12.92 * c, 1.055 * pow(max(c, 1e-5), vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)), coverage);
}
