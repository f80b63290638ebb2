#pragma once
// A Cholesky factor of a matrix that is near the system's, and cheap to factorize.

#include <array>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/sparse_solver.h"
#include "sim/algebra/thinning.h"
#include "sim/contact/barrier_contact.h"

namespace cloth {

/// A symmetric matrix: blocks within the model's pattern, and those that contact adds outside of it.
struct SystemMatrix {
    BlockMatrix inside;
    ExtraBlocks outside;
};
/// y = A x
void multiply(const BlockPattern& pattern, const SystemMatrix& A, const VecX& x, VecX& y);

class Preconditioner {
  public:
    /// Of matrices over `system` and what is outside of it, in the blocks of `own` and those that couple
    /// `contacts`. `pinned`: sorted vertices that are left out.
    Preconditioner(const BlockPattern& system, const BlockPattern& own, const std::vector<int>& pinned,
                   SparseSolver::Precision precision, std::vector<std::array<int, 2>> contacts = {});

    /// False where it is not positive definite. The blocks of A that it lacks are left out as Thinning does
    /// it: it is never below A.
    bool factorize(const SystemMatrix& A);
    void solve(const VecX& b, VecX& x) const { solver_.solve(b, x); }

    const SparseSolver::Statistics& statistics() const { return solver_.statistics(); }
    const std::vector<std::array<int, 2>>& contacts() const { return contacts_; }

  private:
    std::vector<std::array<int, 2>> contacts_;
    BlockPattern pattern_;
    Thinning thinning_;
    BlockMatrix matrix_;
    SparseSolver solver_;
};

/// The blocks of `pattern` that a mesh's neighbours couple, and those of vertices that are far from each
/// other: all but the second ring, of two vertices with a common neighbour. Bending alone couples those.
BlockPattern without_second_ring(const BlockPattern& pattern, const Triangles& triangles);

}  // namespace cloth
