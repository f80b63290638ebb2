#pragma once
// Block matrices in the form that Eigen's and CHOLMOD's solvers take.

#include <Eigen/SparseCore>

#include "sim/algebra/block_matrix.h"

namespace cloth::testing {

/// The lower triangle of A, shape (3n, 3n).
inline Eigen::SparseMatrix<double> lower_triangle(const BlockPattern& pattern, const BlockMatrix& A) {
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < pattern.vertex_count(); ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            for (int a = 0; a < 3; ++a) {
                for (int b = 0; b < 3; ++b) {
                    // The block stands at (i, j), i ≤ j: its transpose is below the diagonal.
                    const int row = 3 * pattern.column[s] + b, column = 3 * i + a;
                    if (row >= column) entries.emplace_back(row, column, A.blocks[s](a, b));
                }
            }
        }
    }
    const int n = 3 * pattern.vertex_count();
    Eigen::SparseMatrix<double> L(n, n);
    L.setFromTriplets(entries.begin(), entries.end());
    return L;
}

}  // namespace cloth::testing
