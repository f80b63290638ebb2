#include "sim/algebra/block_matrix.h"

#include <algorithm>
#include <stdexcept>

namespace cloth {
namespace {

template <class Block>
void symmetric_multiply(const BlockPattern& pattern, const std::vector<Block>& blocks, const VecX& x,
                        VecX& y) {
    y.setZero(x.size());
    for (int i = 0; i < pattern.vertex_count(); ++i) {
        const Vec3 xi = x.segment<3>(3 * i);
        Vec3 yi = y.segment<3>(3 * i) + blocks[pattern.row_begin[i]] * xi;
        for (int s = pattern.row_begin[i] + 1; s < pattern.row_begin[i + 1]; ++s) {
            const int j = pattern.column[s];
            yi += blocks[s] * x.segment<3>(3 * j);
            if constexpr (std::is_same_v<Block, double>) {
                y.segment<3>(3 * j) += blocks[s] * xi;
            } else {
                y.segment<3>(3 * j) += blocks[s].transpose() * xi;
            }
        }
        y.segment<3>(3 * i) = yi;
    }
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
