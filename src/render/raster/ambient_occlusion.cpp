#include "render/raster/ambient_occlusion.h"

#include <algorithm>
#include <cmath>

namespace cloth::render {
namespace {

constexpr int finest_cells = 64;
// Optical depth of a sheet looked through along its normal: all but 5 % is stopped.
constexpr float sheet_depth = 3.0f;
// A ray starts this many cells off its surface, where the surface's own density has nearly ended.
constexpr float start_cells = 1.5f;
// Rays bend towards the normal by this much, or the coarse cells that those at low elevation pass through
// would hold the surface that they start from.
constexpr float lift = 0.6f;

// Vertices of an icosahedron and of its dual, turned off the axes so that no ray runs along a box's sides.
constexpr int direction_count = 32;
std::array<Float3, direction_count> make_directions() {
    const float golden = 0.5f * (1.0f + std::sqrt(5.0f));
    std::array<Float3, direction_count> directions{};
    int n = 0;
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-golden, golden}) {
            for (const Float3& d : {Float3{0, a, b}, Float3{0, b, a / golden}}) {
                directions[n++] = d;
                directions[n++] = {d[1], d[2], d[0]};
                directions[n++] = {d[2], d[0], d[1]};
            }
        }
    for (const float a : {-1.0f, 1.0f})
        for (const float b : {-1.0f, 1.0f})
            for (const float c : {-1.0f, 1.0f}) directions[n++] = {a, b, c};
    const float c1 = 0.921f, s1 = std::sqrt(1 - c1 * c1), c2 = 0.878f, s2 = std::sqrt(1 - c2 * c2);
    for (Float3& d : directions) {
        const float length = std::sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
        const float x = d[0] / length, y = d[1] / length, z = d[2] / length;
        const float x1 = c1 * x + s1 * y, y1 = c1 * y - s1 * x;
        d = {x1, c2 * y1 + s2 * z, c2 * z - s2 * y1};
    }
    return directions;
}
const std::array<Float3, direction_count> directions = make_directions();

}  // namespace

/// Between the middles of eight cells, at coordinates of 0 … side - 1.
inline float AmbientOcclusion::sample(const float* density, int side, float x, float y, float z) {
    const int i = static_cast<int>(x), j = static_cast<int>(y), k = static_cast<int>(z);
    const float u = x - static_cast<float>(i), v = y - static_cast<float>(j), w = z - static_cast<float>(k);
    const int row = side, slice = side * side, first = k * slice + j * row + i;
    const auto along_x = [density, u](int at) { return density[at] + u * (density[at + 1] - density[at]); };
    const float a = along_x(first) + v * (along_x(first + row) - along_x(first));
    const float b = along_x(first + slice) + v * (along_x(first + slice + row) - along_x(first + slice));
    return a + w * (b - a);
}

void AmbientOcclusion::splat(const Float3& position, float area) {
    Level& level = levels_[0];
    std::array<int, 3> cell{};
    std::array<float, 3> part{};
    for (int axis = 0; axis < 3; ++axis) {
        const float x = (position[axis] - origin_[axis]) / cell_ + 0.5f;
        if (!(x >= 0.0f && x < static_cast<float>(finest_cells + 1))) return;
        cell[axis] = static_cast<int>(x);
        part[axis] = x - static_cast<float>(cell[axis]);
    }
    const int side = level.cells + 2;
    const float depth = sheet_depth * area / (cell_ * cell_);
    for (int corner = 0; corner < 8; ++corner) {
        const int dx = corner & 1, dy = corner >> 1 & 1, dz = corner >> 2;
        const int i = cell[0] + dx, j = cell[1] + dy, k = cell[2] + dz;
        if (std::min({i, j, k}) < 1 || std::max({i, j, k}) > level.cells) continue;
        const float weight =
            (dx ? part[0] : 1 - part[0]) * (dy ? part[1] : 1 - part[1]) * (dz ? part[2] : 1 - part[2]);
        level.density[(static_cast<std::size_t>(k) * side + j) * side + i] += weight * depth;
    }
}

void AmbientOcclusion::build(std::span<const Surface> surfaces, const Bounds& bounds) {
    float longest = 0;
    for (int axis = 0; axis < 3; ++axis) longest = std::max(longest, bounds.high[axis] - bounds.low[axis]);
    cell_ = std::max(longest, 1e-6f) / (finest_cells - 4);
    for (int axis = 0; axis < 3; ++axis)
        origin_[axis] = 0.5f * (bounds.low[axis] + bounds.high[axis] - finest_cells * cell_);
    int cells = finest_cells;
    for (Level& level : levels_) {
        level.cells = cells;
        level.density.assign(static_cast<std::size_t>(cells + 2) * (cells + 2) * (cells + 2), 0.0f);
        cells /= 2;
    }

    for (const Surface& surface : surfaces) {
        if (!surface.casts_shadow) continue;
        const auto corner = [&surface](std::size_t index) {
            const float* p = surface.positions.data() + std::size_t{3} * surface.triangles[index];
            return Float3{p[0], p[1], p[2]};
        };
        for (std::size_t t = 0; t + 2 < surface.triangles.size(); t += 3) {
            const Float3 a = corner(t), b = corner(t + 1), c = corner(t + 2);
            Float3 e{}, f{};
            float longest_edge = 0;
            for (int axis = 0; axis < 3; ++axis) {
                e[axis] = b[axis] - a[axis];
                f[axis] = c[axis] - a[axis];
                longest_edge = std::max({longest_edge, std::abs(e[axis]), std::abs(f[axis])});
            }
            const float nx = e[1] * f[2] - e[2] * f[1], ny = e[2] * f[0] - e[0] * f[2],
                        nz = e[0] * f[1] - e[1] * f[0];
            const float area = 0.5f * std::sqrt(nx * nx + ny * ny + nz * nz);
            // A triangle wider than a cell is splatted as n² smaller ones, at their centroids.
            const int n = static_cast<int>(std::clamp(std::ceil(longest_edge / cell_), 1.0f, 128.0f));
            const auto parts = static_cast<float>(n);
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < 2 * (n - i) - 1; ++j) {
                    const float third = j % 2 == 0 ? 1.0f / 3 : 2.0f / 3;
                    const float u = (static_cast<float>(i) + third) / parts;
                    const float v = (static_cast<float>(j / 2) + third) / parts;
                    splat(
                        {a[0] + u * e[0] + v * f[0], a[1] + u * e[1] + v * f[1], a[2] + u * e[2] + v * f[2]},
                        area / (parts * parts));
                }
        }
    }

    for (std::size_t l = 1; l < levels_.size(); ++l) {
        const Level& fine = levels_[l - 1];
        Level& coarse = levels_[l];
        const int side = fine.cells + 2;
        for (int k = 0; k < coarse.cells; ++k)
            for (int j = 0; j < coarse.cells; ++j)
                for (int i = 0; i < coarse.cells; ++i) {
                    float sum = 0;
                    for (int corner = 0; corner < 8; ++corner) {
                        const int x = 2 * i + (corner & 1) + 1, y = 2 * j + (corner >> 1 & 1) + 1,
                                  z = 2 * k + (corner >> 2) + 1;
                        sum += fine.density[(static_cast<std::size_t>(z) * side + y) * side + x];
                    }
                    const int coarse_side = coarse.cells + 2;
                    coarse.density[(static_cast<std::size_t>(k + 1) * coarse_side + j + 1) * coarse_side + i +
                                   1] = sum / 8;
                }
    }
}

AmbientLight AmbientOcclusion::at(const Float3& position, const Float3& normal, bool on_surface) const {
    const float rise = on_surface ? start_cells : 0.0f, bend = on_surface ? lift : 0.0f;
    Float3 start{};
    for (int axis = 0; axis < 3; ++axis)
        start[axis] = (position[axis] - origin_[axis]) / cell_ + rise * normal[axis];

    // Rays along the surface see mostly the surface itself and weigh little: they are left out. The others go
    // side by side, for vector instructions; what fills the last eight counts for nothing.
    using Rays = std::array<float, direction_count + 7>;
    Rays x{}, y{}, z{}, weight{}, up{}, depth{};
    int count = 0;
    for (const Float3& direction : directions) {
        const float cosine = direction[0] * normal[0] + direction[1] * normal[1] + direction[2] * normal[2];
        if (cosine < 0.17f) continue;
        x[count] = direction[0] + bend * normal[0];
        y[count] = direction[1] + bend * normal[1];
        z[count] = direction[2] + bend * normal[2];
        weight[count] = cosine - 0.17f;
        up[count] = std::clamp(0.5f + 1.5f * direction[1], 0.0f, 1.0f);
        ++count;
    }
    // Each step is twice the last, as is its cell: 1 to 2, 2 to 4 … cells away.
    const int filled = (count + 7) / 8 * 8;
    float step = 1;
    for (const Level& level : levels_) {
        const float distance = 1.5f * step;
        const int side = level.cells + 2;
        const float last = static_cast<float>(side) - 1.001f;
        const auto coordinates = [&](float from, const Rays& ray) {
            Rays at{};
            for (int i = 0; i < filled; ++i) {
                const float to = (from + distance * ray[i]) / step + 0.5f, positive = to < 0 ? 0 : to;
                at[i] = positive < last ? positive : last;
            }
            return at;
        };
        const Rays at_x = coordinates(start[0], x), at_y = coordinates(start[1], y),
                   at_z = coordinates(start[2], z);
        const float* density = level.density.data();
        for (int i = 0; i < filled; ++i) depth[i] += step * sample(density, side, at_x[i], at_y[i], at_z[i]);
        step *= 2;
    }
    float above = 0, below = 0, open_above = 1e-6f, open_below = 1e-6f;
    for (int i = 0; i < count; ++i) {
        // Like exp(-depth), but the same in every standard library
        const float open = weight[i] / (1 + depth[i] * (1 + 0.5f * depth[i]));
        above += open * up[i];
        below += open * (1 - up[i]);
        open_above += weight[i] * up[i];
        open_below += weight[i] * (1 - up[i]);
    }
    return {0.5f * (1 + normal[1]) * above / open_above, 0.5f * (1 - normal[1]) * below / open_below};
}

}  // namespace cloth::render
