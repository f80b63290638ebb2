#pragma once
// Symmetric sparse matrices of 3x3 blocks, one block row per vertex. Only blocks (i, j) with i ≤ j are
// stored.

#include <array>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth {

/// Which blocks there are; fixed for a run.
class BlockPattern {
  public:
    BlockPattern() = default;
    /// All diagonal blocks and the given pairs (any order, repeats allowed).
    BlockPattern(int vertex_count, std::vector<std::array<int, 2>> pairs);

    int vertex_count() const { return static_cast<int>(row_begin.size()) - 1; }
    int slot_count() const { return static_cast<int>(column.size()); }
    /// Slot of block (i, j), i ≤ j; throws std::out_of_range where there is none.
    int slot(int i, int j) const;
    /// The same, in any order; -1 where there is none.
    int find(int i, int j) const;
    int diagonal(int i) const { return row_begin[i]; }

    std::vector<int> row_begin{0};  ///< row i holds slots row_begin[i] … row_begin[i+1]-1, its diagonal first
    std::vector<int> column;        ///< ascending within a row
};

/// Values over a BlockPattern.
struct BlockMatrix {
    std::vector<Mat3> blocks;  ///< one per slot

    void reset(const BlockPattern& pattern) { blocks.assign(pattern.slot_count(), Mat3::Zero()); }
};

/// y = A x for the whole symmetric matrix.
void multiply(const BlockPattern& pattern, const BlockMatrix& A, const VecX& x, VecX& y);

/// Matrices whose blocks are multiples of the identity (mass). One number per slot.
struct ScalarBlockMatrix {
    std::vector<double> values;
};
void multiply(const BlockPattern& pattern, const ScalarBlockMatrix& A, const VecX& x, VecX& y);

}  // namespace cloth
