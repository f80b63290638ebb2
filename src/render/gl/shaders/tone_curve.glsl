// Linear radiance → display-linear 0 … 1: unchanged below the knee, so that mid-tones keep their colour,
// then an exponential shoulder of equal slope that ends at white.
const float knee = 0.6;
vec3 tone_curve(vec3 radiance) {
    vec3 over = max(radiance - knee, 0.0);
    return min(radiance, knee) + (1.0 - knee) * (1.0 - exp(-over / (1.0 - knee)));
}
