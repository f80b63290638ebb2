#pragma once
// Direct solution of (block matrix) x = b on the free vertices: a multifrontal Cholesky factorisation.
//
// Why not a library's: CHOLMOD's fast path runs in a BLAS that picks its kernels by processor, so states
// would differ between machines, and Eigen's own sparse factorisation works one scalar at a time. Here the
// order, the elimination tree and all index lists are found once on the graph of vertices (3x3 blocks), and
// the numbers are dense work by Eigen, compiled into this library. Fronts of disjoint subtrees run on
// different threads; each sum keeps its order, so the result does not depend on how many there are. (Duff and
// Reid 1983; Liu 1992, The Multifrontal Method.)

#include <memory>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/types.h"

namespace cloth {

class SparseSolver {
  public:
    /// Of the factor: `single` takes half the time and memory, for preconditioners.
    enum class Precision { full, single };

    /// `pinned`: sorted vertices whose rows and columns are left out.
    SparseSolver(const BlockPattern& pattern, const std::vector<int>& pinned,
                 Precision precision = Precision::full);
    ~SparseSolver();
    SparseSolver(SparseSolver&&) noexcept;
    SparseSolver& operator=(SparseSolver&&) noexcept;

    /// False where the matrix is not positive definite (or not finite).
    bool factorize(const BlockMatrix& A);
    /// What a factorization takes: known from the pattern, counted in scalars, padding with zeros included.
    struct Statistics {
        int fronts = 0;
        int parallel_fronts = 0;  ///< those so large that several threads share one
        int greatest_front = 0;   ///< rows
        double entries = 0.0;     ///< of the factor L
        double flops = 0.0;       ///< multiplications and additions: Σ (entries of a column)²
    };
    const Statistics& statistics() const;

    /// x = A⁻¹ b on the free vertices; 0 on the pinned ones. Requires a successful factorize(). One call at a
    /// time.
    void solve(const VecX& b, VecX& x) const;

    struct Impl;

  private:
    std::unique_ptr<Impl> impl_;
};

}  // namespace cloth
