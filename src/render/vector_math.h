#pragma once
// Small vectors of the renderer.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "render/frame.h"

namespace cloth::render {

inline Float3 operator+(const Float3& a, const Float3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
inline Float3 operator-(const Float3& a, const Float3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
inline Float3 operator*(float s, const Float3& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
inline Float3 operator*(const Float3& a, const Float3& b) {
    return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}
inline float dot(const Float3& a, const Float3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
inline Float3 cross(const Float3& a, const Float3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline float length(const Float3& a) {
    return std::sqrt(dot(a, a));
}
inline Float3 normalized(const Float3& a) {
    return (1 / length(a)) * a;
}
inline bool finite(const Float3& a) {
    return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

using Matrix = std::array<float, 16>;  // by columns, as OpenGL takes it
/// Of a point, without the division by w.
inline Float3 transformed(const Matrix& m, const Float3& p) {
    return {m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12], m[1] * p[0] + m[5] * p[1] + m[9] * p[2] + m[13],
            m[2] * p[0] + m[6] * p[1] + m[10] * p[2] + m[14]};
}

/// Axis-aligned, in metres.
struct Bounds {
    Float3 low, high;
};
inline constexpr float infinity = std::numeric_limits<float>::infinity();
inline constexpr Bounds nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

inline Bounds merged(const Bounds& a, const Bounds& b) {
    Bounds r;
    for (int i = 0; i < 3; ++i) {
        r.low[i] = std::min(a.low[i], b.low[i]);
        r.high[i] = std::max(a.high[i], b.high[i]);
    }
    return r;
}
inline std::array<Float3, 8> box_corners(const Bounds& b) {
    std::array<Float3, 8> c{};
    for (int i = 0; i < 8; ++i)
        c[i] = {i & 1 ? b.high[0] : b.low[0], i & 2 ? b.high[1] : b.low[1], i & 4 ? b.high[2] : b.low[2]};
    return c;
}

}  // namespace cloth::render
