#pragma once
// A sparser matrix in place of a symmetric one, never below it: a preconditioner that is cheap to factorize.

#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/types.h"

namespace cloth {

/// Leaves out the blocks of one pattern that another lacks. A block B = U S Vᵀ that is left out is answered
/// on the two diagonals, by U S Uᵀ and V S Vᵀ: [USUᵀ -B; -Bᵀ VSVᵀ] is positive semi-definite, so the result
/// is never below the whole matrix and stays positive definite where that is.
class Thinning {
  public:
    /// `to` may have blocks that `from` lacks; these become 0.
    Thinning(const BlockPattern& from, const BlockPattern& to);

    /// P over `to`, of A over `from`.
    void apply(const BlockMatrix& A, BlockMatrix& P);

    int left_out() const { return static_cast<int>(far_.size()); }

  private:
    struct Far {
        int slot, row, column;
    };
    /// A block left out, as its row's vertex or its column's meets it.
    struct Share {
        int far;
        bool of_column;
    };
    std::vector<int> source_;    ///< for each slot of `to`: that of `from`, or -1
    std::vector<int> diagonal_;  ///< for each vertex: its slot of `to`
    std::vector<Far> far_;
    std::vector<int> share_begin_;  ///< for each vertex: its shares are share_begin_[v] … share_begin_[v+1]-1
    std::vector<Share> shares_;
    std::vector<Mat3> on_row_, on_column_;  ///< for each block left out: what its diagonals get
};

/// U S Uᵀ and V S Vᵀ of B = U S Vᵀ.
void split_block(const Mat3& B, Mat3& on_row, Mat3& on_column);

}  // namespace cloth
