#pragma once
// Which squares of a picture triangles may touch. What lies in none of them need not be shaded.

#include <cstdint>
#include <vector>

#include "render/vector_math.h"

namespace cloth::render {

class TileMask {
  public:
    /// Squares of `tile` pixels; nothing is marked.
    TileMask(int width, int height, int tile);

    /// Marks the squares under the box around each triangle, which `to_clip` takes to -1 … 1; all of them
    /// where a vertex lies behind the eye.
    void mark(const Surface& surface, const Matrix& to_clip);

    int columns() const { return columns_; }
    int rows() const { return rows_; }
    void mark(int column, int row) { marks_[static_cast<std::size_t>(row) * columns_ + column] = 1; }
    bool marked(int column, int row) const {
        return marks_[static_cast<std::size_t>(row) * columns_ + column] != 0;
    }
    /// Whether a square is marked that a box, in shares of the picture, touches.
    bool any(float low_x, float low_y, float high_x, float high_y) const;

    /// Two triangles for each run of marked squares in a row: x y z per vertex, in clip coordinates.
    void append_triangles(std::vector<float>& positions, float z) const;

  private:
    struct Range {
        int first, last;  ///< last: one beyond
    };
    static Range range(float low, float high, int count);

    int width_, height_, tile_, columns_, rows_;
    std::vector<std::uint8_t> marks_;  // by rows from the bottom
};

}  // namespace cloth::render
