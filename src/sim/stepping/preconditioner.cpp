#include "sim/stepping/preconditioner.h"

#include <algorithm>

namespace cloth {
namespace {

std::vector<std::array<int, 2>> pairs_of(const BlockPattern& pattern) {
    std::vector<std::array<int, 2>> pairs;
    for (int i = 0; i < pattern.vertex_count(); ++i) {
        for (int s = pattern.row_begin[i] + 1; s < pattern.row_begin[i + 1]; ++s)
            pairs.push_back({i, pattern.column[s]});
    }
    return pairs;
}

BlockPattern extended(const BlockPattern& pattern, const std::vector<std::array<int, 2>>& more) {
    std::vector<std::array<int, 2>> pairs = pairs_of(pattern);
    pairs.insert(pairs.end(), more.begin(), more.end());
    return {pattern.vertex_count(), std::move(pairs)};
}

}  // namespace

void multiply(const BlockPattern& pattern, const SystemMatrix& A, const VecX& x, VecX& y) {
    multiply(pattern, A.inside, x, y);
    A.outside.add_product(x, y);
}

Preconditioner::Preconditioner(const BlockPattern& system, const BlockPattern& own,
                               const std::vector<int>& pinned, SparseSolver::Precision precision,
                               std::vector<std::array<int, 2>> contacts)
    : contacts_(std::move(contacts)),
      pattern_(extended(own, contacts_)),
      thinning_(system, pattern_),
      solver_(pattern_, pinned, precision) {}

bool Preconditioner::factorize(const SystemMatrix& A) {
    thinning_.apply(A.inside, matrix_);
    for (std::size_t b = 0; b < A.outside.where.size(); ++b) {
        const auto [i, j] = A.outside.where[b];
        if (const int slot = pattern_.find(i, j); slot >= 0) {
            matrix_.blocks[slot] += A.outside.blocks[b];
            continue;
        }
        Mat3 on_row, on_column;
        split_block(A.outside.blocks[b], on_row, on_column);
        matrix_.blocks[pattern_.diagonal(i)] += on_row;
        matrix_.blocks[pattern_.diagonal(j)] += on_column;
    }
    return solver_.factorize(matrix_);
}

BlockPattern without_second_ring(const BlockPattern& pattern, const Triangles& triangles) {
    const int n = pattern.vertex_count();
    std::vector<std::array<int, 2>> edges;
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) edges.push_back({triangles(t, i), triangles(t, (i + 1) % 3)});
    }
    const BlockPattern mesh(n, std::move(edges));
    std::vector<std::vector<int>> neighbours(n);
    for (const auto& [i, j] : pairs_of(mesh)) {
        neighbours[i].push_back(j);
        neighbours[j].push_back(i);
    }
    for (auto& each : neighbours) std::sort(each.begin(), each.end());
    std::vector<std::array<int, 2>> kept;
    for (const auto& [i, j] : pairs_of(pattern)) {
        std::vector<int> common;
        std::set_intersection(neighbours[i].begin(), neighbours[i].end(), neighbours[j].begin(),
                              neighbours[j].end(), std::back_inserter(common));
        if (mesh.find(i, j) >= 0 || common.empty()) kept.push_back({i, j});
    }
    return {n, std::move(kept)};
}

}  // namespace cloth
