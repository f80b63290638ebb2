#include "sim/algebra/thinning.h"

#include <algorithm>

#include <Eigen/Eigenvalues>

#include "base/parallel.h"

namespace cloth {
namespace {

/// ±1 for a symmetric B that is positive or negative definite, else 0.
double definite(const Mat3& B) {
    if (!((B - B.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * B.cwiseAbs().maxCoeff())) return 0.0;
    const double sign = B(0, 0) > 0.0 ? 1.0 : -1.0;
    const double first = sign * B(0, 0), second = B(0, 0) * B(1, 1) - B(0, 1) * B(0, 1);
    return first > 0.0 && second > 0.0 && sign * B.determinant() > 0.0 ? sign : 0.0;
}

}  // namespace

Thinning::Thinning(const BlockPattern& from, const BlockPattern& to) {
    const int n = from.vertex_count();
    source_.assign(to.slot_count(), -1);
    diagonal_.resize(n);
    share_begin_.assign(n + 1, 0);
    for (int i = 0; i < n; ++i) {
        diagonal_[i] = to.diagonal(i);
        int t = to.row_begin[i];
        for (int s = from.row_begin[i]; s < from.row_begin[i + 1]; ++s) {
            while (t < to.row_begin[i + 1] && to.column[t] < from.column[s]) ++t;
            if (t < to.row_begin[i + 1] && to.column[t] == from.column[s]) {
                source_[t] = s;
            } else {
                far_.push_back({s, i, from.column[s]});
                ++share_begin_[i + 1];
                ++share_begin_[from.column[s] + 1];
            }
        }
    }
    for (int i = 0; i < n; ++i) share_begin_[i + 1] += share_begin_[i];
    shares_.resize(2 * far_.size());
    std::vector<int> next(share_begin_.begin(), share_begin_.end() - 1);
    for (int f = 0; f < left_out(); ++f) {
        shares_[next[far_[f].row]++] = {f, false};
        shares_[next[far_[f].column]++] = {f, true};
    }
    on_row_.resize(far_.size());
    on_column_.resize(far_.size());
}

void Thinning::apply(const BlockMatrix& A, BlockMatrix& P) {
    P.blocks.resize(source_.size());
    parallel_for(static_cast<int>(source_.size()), [&](int t) {
        if (source_[t] >= 0) {
            P.blocks[t] = A.blocks[source_[t]];
        } else {
            P.blocks[t].setZero();
        }
    });
    parallel_for(left_out(), [&](int f) { split_block(A.blocks[far_[f].slot], on_row_[f], on_column_[f]); });
    parallel_for(static_cast<int>(diagonal_.size()), [&](int v) {
        Mat3& block = P.blocks[diagonal_[v]];
        for (int k = share_begin_[v]; k < share_begin_[v + 1]; ++k)
            block += shares_[k].of_column ? on_column_[shares_[k].far] : on_row_[shares_[k].far];
    });
}

void split_block(const Mat3& B, Mat3& on_row, Mat3& on_column) {
    if (const double sign = definite(B); sign != 0.0) {
        on_row = on_column = sign * B;
        return;
    }
    // BᵀB = V S² Vᵀ. What is so small against the rest that its root is only rounding weighs nothing.
    const Eigen::SelfAdjointEigenSolver<Mat3> eigen(B.transpose() * B);
    const double least = 1e-24 * eigen.eigenvalues()[2];
    on_row.setZero();
    on_column.setZero();
    for (int k = 0; k < 3; ++k) {
        const double square = eigen.eigenvalues()[k];
        if (!(square > least)) continue;
        const Vec3 v = eigen.eigenvectors().col(k), image = B * v;  // S u
        const double s = std::sqrt(square);
        on_column += s * v * v.transpose();
        on_row += image * image.transpose() / s;
    }
}

}  // namespace cloth
