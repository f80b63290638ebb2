#include "render/raster/tile_mask.h"

namespace cloth::render {

TileMask::TileMask(int width, int height, int tile)
    : width_(width),
      height_(height),
      tile_(tile),
      columns_((width + tile - 1) / tile),
      rows_((height + tile - 1) / tile),
      marks_(static_cast<std::size_t>(columns_) * rows_, 0) {}

TileMask::Range TileMask::range(float low, float high, int count) {
    // Room for the rounding of a rasterizer's coordinates
    constexpr float margin = 1.0f / 64;
    const auto last = static_cast<float>(count);
    return {static_cast<int>(std::clamp(low - margin, 0.0f, last)),
            std::min(static_cast<int>(std::clamp(high + margin, -1.0f, last)) + (high + margin >= 0 ? 1 : 0),
                     count)};
}

void TileMask::mark(const Surface& surface, const Matrix& m) {
    const std::size_t vertices = surface.positions.size() / 3;
    std::vector<float> x(vertices), y(vertices);  // in squares
    const float scale_x = 0.5f * static_cast<float>(width_) / static_cast<float>(tile_),
                scale_y = 0.5f * static_cast<float>(height_) / static_cast<float>(tile_);
    for (std::size_t v = 0; v < vertices; ++v) {
        const float* xyz = surface.positions.data() + 3 * v;
        const Float3 p{xyz[0], xyz[1], xyz[2]}, clip = transformed(m, p);
        const float w = m[3] * p[0] + m[7] * p[1] + m[11] * p[2] + m[15];
        if (!(w > 0)) {
            std::fill(marks_.begin(), marks_.end(), std::uint8_t{1});
            return;
        }
        x[v] = scale_x * (1 + clip[0] / w);
        y[v] = scale_y * (1 + clip[1] / w);
    }
    for (std::size_t t = 0; t + 2 < surface.triangles.size(); t += 3) {
        const std::uint32_t a = surface.triangles[t], b = surface.triangles[t + 1],
                            c = surface.triangles[t + 2];
        const Range columns = range(std::min({x[a], x[b], x[c]}), std::max({x[a], x[b], x[c]}), columns_);
        const Range rows = range(std::min({y[a], y[b], y[c]}), std::max({y[a], y[b], y[c]}), rows_);
        for (int row = rows.first; row < rows.last; ++row)
            for (int column = columns.first; column < columns.last; ++column) mark(column, row);
    }
}

bool TileMask::any(float low_x, float low_y, float high_x, float high_y) const {
    const auto across = static_cast<float>(columns_), up = static_cast<float>(rows_);
    const Range columns = range(low_x * across, high_x * across, columns_);
    const Range rows = range(low_y * up, high_y * up, rows_);
    for (int row = rows.first; row < rows.last; ++row)
        for (int column = columns.first; column < columns.last; ++column)
            if (marked(column, row)) return true;
    return false;
}

void TileMask::append_triangles(std::vector<float>& positions, float z) const {
    const float step_x = 2 * static_cast<float>(tile_) / static_cast<float>(width_),
                step_y = 2 * static_cast<float>(tile_) / static_cast<float>(height_);
    for (int row = 0; row < rows_; ++row)
        for (int column = 0; column < columns_; ++column) {
            if (!marked(column, row)) continue;
            const int start = column;
            while (column < columns_ && marked(column, row)) ++column;
            const float x0 = static_cast<float>(start) * step_x - 1,
                        x1 = static_cast<float>(column) * step_x - 1;
            const float y0 = static_cast<float>(row) * step_y - 1, y1 = y0 + step_y;
            positions.insert(positions.end(), {x0, y0, z, x1, y0, z, x1, y1, z});
            positions.insert(positions.end(), {x0, y0, z, x1, y1, z, x0, y1, z});
        }
}

}  // namespace cloth::render
