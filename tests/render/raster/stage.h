#pragma once
// Shapes, materials and views whose pictures are known without a renderer.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <vector>

#include "render/raster/rasterizer.h"

namespace cloth::render::testing {

inline constexpr float pi = std::numbers::pi_v<float>;

/// Linear 0 … 1 → 8-bit sRGB, by the standard's formula.
inline int srgb(double c) {
    return static_cast<int>(
        std::lround(255 * (c <= 0.0031308 ? 12.92 * c : 1.055 * std::pow(c, 1 / 2.4) - 0.055)));
}

struct Mesh {
    std::vector<float> positions, normals, coordinates;
    std::vector<std::uint32_t> triangles;

    Surface surface(const Material& material = {}, bool two_sided = false) const {
        Surface result{positions, normals, triangles, material, two_sided};
        result.coordinates = coordinates;
        return result;
    }
};

/// n x n squares over the parallelogram centre ± u ± v; the normal is u × v. Rest coordinates run from 0
/// along u and v [m].
inline Mesh sheet(const Float3& center, const Float3& u, const Float3& v, int n = 1) {
    Mesh mesh;
    Float3 normal{u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]};
    const float length = std::hypot(normal[0], normal[1], normal[2]);
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                const float s = 2 * static_cast<float>(i) / static_cast<float>(n) - 1;
                const float t = 2 * static_cast<float>(j) / static_cast<float>(n) - 1;
                mesh.positions.push_back(center[axis] + s * u[axis] + t * v[axis]);
                mesh.normals.push_back(normal[axis] / length);
            }
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= n; ++i) {
            mesh.coordinates.push_back(2 * static_cast<float>(i) / static_cast<float>(n) *
                                       std::hypot(u[0], u[1], u[2]));
            mesh.coordinates.push_back(2 * static_cast<float>(j) / static_cast<float>(n) *
                                       std::hypot(v[0], v[1], v[2]));
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (n + 1) + i),
                       b = a + static_cast<std::uint32_t>(n) + 1;
            mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return mesh;
}

inline Mesh sphere(const Float3& center, float radius, int n = 32) {
    Mesh mesh;
    for (int j = 0; j <= n; ++j)
        for (int i = 0; i <= 2 * n; ++i) {
            const float polar = pi * static_cast<float>(j) / static_cast<float>(n);
            const float azimuth = pi * static_cast<float>(i) / static_cast<float>(n);
            const Float3 normal{std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                std::sin(polar) * std::sin(azimuth)};
            for (int axis = 0; axis < 3; ++axis) {
                mesh.positions.push_back(center[axis] + radius * normal[axis]);
                mesh.normals.push_back(normal[axis]);
            }
        }
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < 2 * n; ++i) {
            const auto a = static_cast<std::uint32_t>(j * (2 * n + 1) + i);
            const std::uint32_t b = a + 2 * static_cast<std::uint32_t>(n) + 1;
            mesh.triangles.insert(mesh.triangles.end(), {a, a + 1, b, b, a + 1, b + 1});
        }
    return mesh;
}

inline Material matte(const Float3& front, const Float3& back) {
    return {.front = front, .back = back, .roughness = 0.7f, .specular = 0, .sheen = 0};
}
inline Material matte(const Float3& color) {
    return matte(color, color);
}

/// From (0, 0, 3): at the plane z = 0 the picture is 2 m high, so a pixel of 240 is 1/120 m.
inline View plain_view(int width = 240, int height = 240) {
    View view;
    view.width = width;
    view.height = height;
    view.field_of_view = 2 * std::atan(1.0f / 3) * 180 / pi;
    view.light = {.direction = {0, 0, 1}, .color = {1, 1, 1}, .intensity = pi, .shadow = false, .angle = 0};
    view.sky = view.background = {0, 0, 0};
    view.ambient_occlusion = false;
    return view;
}

/// From (0, 6, 0) straight down, x to the right: at the floor y = 0 the picture is 4 m high.
inline View view_from_above() {
    View view = plain_view(300, 300);
    view.eye = {0, 6, 0};
    view.up = {0, 0, -1};
    view.light.direction = {1, 1, 0};
    view.light.shadow = true;
    return view;
}
/// The column of the picture from above where x lies on the floor.
inline int column_at(double x) {
    return static_cast<int>(std::floor(150 + x * 75));
}

inline Frame frame_of(std::initializer_list<Surface> surfaces, std::optional<Ground> ground = {}) {
    return {std::vector<Surface>(surfaces), ground};
}

inline Rasterizer& rasterizer() {
    static Rasterizer one(2);
    return one;
}
inline Image draw(const Frame& frame, const View& view) {
    return rasterizer().draw(frame, view);
}

using Rgb = std::array<int, 3>;
inline Rgb rgb(const Image& image, int x, int y) {
    const std::uint8_t* p = image.pixel(x, y);
    return {p[0], p[1], p[2]};
}
inline Rgb center(const Image& image) {
    return rgb(image, image.width / 2, image.height / 2);
}
/// By at most one step: where a surface ends inside a pixel, its colour and the mix are both rounded.
inline bool close(const Rgb& a, const Rgb& b) {
    return std::abs(a[0] - b[0]) <= 1 && std::abs(a[1] - b[1]) <= 1 && std::abs(a[2] - b[2]) <= 1;
}
inline Rgb grey(int value) {
    return {value, value, value};
}

/// Everything at once: cloth-like sheet over a sphere and a floor, all effects on.
struct Still {
    Mesh ball = sphere({0, 0, 0}, 0.25f), cloth = sheet({0, 0.3f, 0}, {0.5f, 0, 0}, {0, 0, -0.5f}, 40);
    Frame frame;
    View view;
    Still() {
        for (std::size_t i = 1; i < cloth.positions.size(); i += 3)
            cloth.positions[i] -=
                0.6f * std::pow(std::hypot(cloth.positions[i - 1], cloth.positions[i + 1]), 2.0f);
        const Material silk{.front = {0.5f, 0.1f, 0.1f}, .back = {0.2f, 0.2f, 0.5f}, .sheen = 0.5f};
        frame = frame_of({cloth.surface(silk, true), ball.surface()}, Ground{-0.4f, {0.6f, 0.6f, 0.6f}});
        view.width = 320;
        view.height = 180;
        view.eye = {0.9f, 0.6f, 1.6f};
    }
};

inline Material patterned(Pattern pattern, float scale) {
    Material m = matte({0.1f, 0.1f, 0.1f}, {0.3f, 0, 0});
    m.pattern = pattern;
    m.pattern_scale = scale;
    m.pattern_colors = {{{0.5f, 0.5f, 0.5f}, {0.5f, 0, 0}, {0, 0.5f, 0}}};
    return m;
}

/// Mean of the linear red over a square of pixels.
inline double mean_red(const Image& image, int x0, int y0, int side) {
    double sum = 0;
    for (int y = y0; y < y0 + side; ++y)
        for (int x = x0; x < x0 + side; ++x) {
            const double c = rgb(image, x, y)[0] / 255.0;
            sum += c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
        }
    return sum / (side * side);
}

}  // namespace cloth::render::testing
