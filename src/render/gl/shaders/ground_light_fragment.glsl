// Shares of the key light and of the sky's light that reach the floor. Drawn at half the picture's size: on
// the plane, whatever stands before it, nothing changes faster than that can hold.

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
