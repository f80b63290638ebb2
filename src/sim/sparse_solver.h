#pragma once
// Direct solution of (block matrix) x = b on the free vertices.

#include <memory>
#include <vector>

#include "sim/block_matrix.h"
#include "sim/types.h"

namespace cloth {

/// Cholesky factorisation by Eigen. Ordering and symbolic work are done once, on the graph of vertices.
class SparseSolver {
  public:
    /// `pinned`: sorted vertices whose rows and columns are left out.
    SparseSolver(const BlockPattern& pattern, const std::vector<int>& pinned);
    ~SparseSolver();

    /// False where the matrix is not positive definite (or not finite).
    bool factorize(const BlockMatrix& A);
    /// x = A⁻¹ b on the free vertices; 0 on the pinned ones. Requires a successful factorize().
    void solve(const VecX& b, VecX& x) const;

  private:
    struct Impl;
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth
