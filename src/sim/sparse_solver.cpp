#include "sim/sparse_solver.h"

#include <algorithm>

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCholesky>

namespace cloth {
namespace {

using Sparse = Eigen::SparseMatrix<double>;

}  // namespace

struct SparseSolver::Impl {
    /// Each scalar of the lower triangle comes from entry `entry` (column-major in the 3x3 block) of `slot`.
    struct Source {
        int slot, entry;
    };
    int vertex_count = 0;
    std::vector<int> vertex_at;  ///< permuted free index → vertex
    Sparse lower;
    std::vector<Source> sources;  ///< one per value of `lower`
    Eigen::SimplicialLLT<Sparse, Eigen::Lower, Eigen::NaturalOrdering<int>> llt;
    mutable VecX scratch;
};

SparseSolver::SparseSolver(const BlockPattern& pattern, const std::vector<int>& pinned)
    : impl_(std::make_unique<Impl>()) {
    Impl& d = *impl_;
    d.vertex_count = pattern.vertex_count();

    std::vector<int> free_index(d.vertex_count, -1), free_vertices;
    for (int v = 0; v < d.vertex_count; ++v) {
        if (std::binary_search(pinned.begin(), pinned.end(), v)) continue;
        free_index[v] = static_cast<int>(free_vertices.size());
        free_vertices.push_back(v);
    }
    const int n = static_cast<int>(free_vertices.size());

    // Fill-reducing order of the vertices; all three coordinates of a vertex stay together.
    std::vector<Eigen::Triplet<double>> graph;
    for (int i = 0; i < d.vertex_count; ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            const int a = free_index[i], b = free_index[pattern.column[s]];
            if (a < 0 || b < 0) continue;
            graph.emplace_back(a, b, 1.0);
            if (a != b) graph.emplace_back(b, a, 1.0);
        }
    }
    Sparse adjacency(n, n);
    adjacency.setFromTriplets(graph.begin(), graph.end());
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> order;
    Eigen::AMDOrdering<int>()(adjacency, order);
    std::vector<int> place(n);  // free index → permuted index
    d.vertex_at.resize(n);
    for (int k = 0; k < n; ++k) {
        place[order.indices()(k)] = k;
        d.vertex_at[k] = free_vertices[order.indices()(k)];
    }

    // The scalar lower triangle, with the source slot as its value for now.
    std::vector<Eigen::Triplet<double>> entries;
    std::vector<Impl::Source> unsorted;
    for (int i = 0; i < d.vertex_count; ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            const int a = free_index[i], b = free_index[pattern.column[s]];
            if (a < 0 || b < 0) continue;
            for (int r = 0; r < 3; ++r) {
                for (int c = 0; c < 3; ++c) {
                    const int row = 3 * place[a] + r, col = 3 * place[b] + c;
                    if (a == b && row < col) continue;
                    entries.emplace_back(std::max(row, col), std::min(row, col),
                                         static_cast<double>(unsorted.size()));
                    unsorted.push_back({s, 3 * c + r});
                }
            }
        }
    }
    d.lower.resize(3 * n, 3 * n);
    d.lower.setFromTriplets(entries.begin(), entries.end());
    d.lower.makeCompressed();
    d.sources.resize(d.lower.nonZeros());
    for (Eigen::Index k = 0; k < d.lower.nonZeros(); ++k) {
        d.sources[k] = unsorted[static_cast<std::size_t>(d.lower.valuePtr()[k])];
    }
    d.llt.analyzePattern(d.lower);
    d.scratch.resize(3 * n);
}

SparseSolver::~SparseSolver() = default;

bool SparseSolver::factorize(const BlockMatrix& A) {
    Impl& d = *impl_;
    for (std::size_t k = 0; k < d.sources.size(); ++k) {
        d.lower.valuePtr()[k] = A.blocks[d.sources[k].slot].data()[d.sources[k].entry];
    }
    if (d.vertex_at.empty()) return true;
    d.llt.factorize(d.lower);
    return d.llt.info() == Eigen::Success;
}

void SparseSolver::solve(const VecX& b, VecX& x) const {
    const Impl& d = *impl_;
    const int n = static_cast<int>(d.vertex_at.size());
    for (int k = 0; k < n; ++k) d.scratch.segment<3>(3 * k) = b.segment<3>(3 * d.vertex_at[k]);
    if (n > 0) d.scratch = d.llt.solve(d.scratch).eval();
    x.setZero(3 * d.vertex_count);
    for (int k = 0; k < n; ++k) x.segment<3>(3 * d.vertex_at[k]) = d.scratch.segment<3>(3 * k);
}

}  // namespace cloth
