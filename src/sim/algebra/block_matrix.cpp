#include "sim/algebra/block_matrix.h"

#include <algorithm>
#include <stdexcept>

#include "base/parallel.h"

namespace cloth {
namespace {

/// y += A x of rows [first, last), all of whose columns are there or behind. What belongs to rows behind
/// `last` is left in `behind`, from row `last` on.
template <class Block>
void multiply_rows(const BlockPattern& pattern, const std::vector<Block>& blocks, int first, int last,
                   const VecX& x, VecX& y, VecX& behind) {
    for (int i = first; i < last; ++i) {
        const Vec3 xi = x.segment<3>(3 * i);
        Vec3 yi = y.segment<3>(3 * i) + blocks[pattern.row_begin[i]] * xi;
        for (int s = pattern.row_begin[i] + 1; s < pattern.row_begin[i + 1]; ++s) {
            const int j = pattern.column[s];
            yi += blocks[s] * x.segment<3>(3 * j);
            auto yj = j < last ? y.segment<3>(3 * j) : behind.segment<3>(3 * (j - last));
            if constexpr (std::is_same_v<Block, double>) {
                yj += blocks[s] * xi;
            } else {
                yj += blocks[s].transpose() * xi;
            }
        }
        y.segment<3>(3 * i) = yi;
    }
}

/// In pieces of rows whose number depends on the matrix alone, so that the sums are the same on any number of
/// threads.
template <class Block>
void symmetric_multiply(const BlockPattern& pattern, const std::vector<Block>& blocks, const VecX& x,
                        VecX& y) {
    constexpr int worth_a_piece = 1000, most_pieces = 16;
    const int n = pattern.vertex_count();
    const int pieces = std::clamp(n / worth_a_piece, 1, most_pieces);
    auto begin = [&](int p) { return static_cast<int>(static_cast<long>(n) * p / pieces); };
    y.setZero(x.size());
    std::vector<VecX> behind(pieces);
    parallel_tasks(pieces, [&](int p) {
        const int first = begin(p), last = begin(p + 1);
        int end = last;
        for (int i = first; i < last; ++i)
            end = std::max(end, pattern.column[pattern.row_begin[i + 1] - 1] + 1);
        behind[p].setZero(3 * (end - last));
        multiply_rows(pattern, blocks, first, last, x, y, behind[p]);
    });
    for (int p = 0; p < pieces; ++p) y.segment(3 * begin(p + 1), behind[p].size()) += behind[p];
}

}  // namespace

BlockPattern::BlockPattern(int vertex_count, std::vector<std::array<int, 2>> pairs) {
    for (auto& [i, j] : pairs) {
        if (i > j) std::swap(i, j);
    }
    for (int i = 0; i < vertex_count; ++i) pairs.push_back({i, i});
    std::sort(pairs.begin(), pairs.end());
    pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());

    row_begin.assign(vertex_count + 1, 0);
    column.reserve(pairs.size());
    for (const auto& [i, j] : pairs) {
        ++row_begin[i + 1];
        column.push_back(j);
    }
    for (int i = 0; i < vertex_count; ++i) row_begin[i + 1] += row_begin[i];
}

int BlockPattern::find(int i, int j) const {
    if (i > j) std::swap(i, j);
    const auto begin = column.begin() + row_begin[i], end = column.begin() + row_begin[i + 1];
    const auto found = std::lower_bound(begin, end, j);
    return found == end || *found != j ? -1 : static_cast<int>(found - column.begin());
}

int BlockPattern::slot(int i, int j) const {
    const int found = i <= j ? find(i, j) : -1;
    if (found < 0) throw std::out_of_range("BlockPattern::slot: no such block");
    return found;
}

void multiply(const BlockPattern& pattern, const BlockMatrix& A, const VecX& x, VecX& y) {
    symmetric_multiply(pattern, A.blocks, x, y);
}

void multiply(const BlockPattern& pattern, const ScalarBlockMatrix& A, const VecX& x, VecX& y) {
    symmetric_multiply(pattern, A.values, x, y);
}

}  // namespace cloth
