#pragma once
// The assignment's Hessian of a triangle after its eigenvalue fix (below 1e-6: set to 1e-3) without an
// eigenproblem of size nine: equal to d2V_membrane_corotational_dq2() (assignment.h) but for rounding.
//
// In the notation of membrane.h the Hessian before the fix is
//
//   H_ij = V R [2μ (b_i·b_j) 1 + λ b_i b_jᵀ + t (Q b_i)(Q b_j)ᵀ] Rᵀ + V b_iᵀ K b_j nnᵀ,   t = c/I,
//   K = 2μ 1 + c S⁻¹ + ψ_2 S⁻²,   ψ_2 = λ (I-2)
//
// so that its eigenvectors fall into three families:
//   translations   eigenvalue 0, fixed to 1e-3: 10⁻³/3 · 1 in every block
//   along n        a 2x2 matrix in an orthonormal basis B of what sums to zero over the corners
//   in the plane   a 4x4 matrix in B ⊗ (R's columns), constant but for t: A + (t + μ) z zᵀ. A (t = -μ: the
//                  triangle at rest) is positive but for its turn, which costs nothing; so at most the lowest
//                  eigenvalue x of the sum needs the fix. In A's eigenvectors, A = diag(0, d₁, d₂, d₃):
//                  x (1 + δ Σ_k z_k²/(d_k - x)) = δ z₀², δ = t + μ (Golub 1973, Some modified matrix
//                  eigenvalue problems), and the eigenvector is (z₀, -x z_k/(d_k - x)).

#include "sim/algebra/types.h"

namespace cloth {

struct TriangleRest;

/// What of it is constant for a triangle.
struct AssignmentRest {
    Eigen::Vector3d d;  ///< eigenvalues of A but the turn's 0, ascending [N/m]
    Eigen::Vector4d z;  ///< in A's eigenvectors [m⁻¹ · m^{3/2}], so that δ z zᵀ is in N/m
    Eigen::Matrix<double, 6, 4> basis;  ///< A's eigenvectors over the corners' in-plane coordinates
};

AssignmentRest make_assignment_rest(const TriangleRest& rest);

/// Shape (9, 9) [N/m].
Mat9 fixed_assignment_hessian(const TriangleRest& rest, const AssignmentRest& plane, const Vec9& q9);

}  // namespace cloth
