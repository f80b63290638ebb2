#pragma once
// The assignment, function by function: "Cloth simulation using co-rotational linear elasticity" (CSC417,
// assignment 4). Each function keeps the assignment's name and stands beside its formula. The simulator's
// element kernels (membrane.h) are tested against these.
//
// Notation: a triangle has corners X0, X1, X2 at rest and x0, x1, x2 in space; q9 = (x0, x1, x2) stacked,
// shape (9). N, n are the unit normals at rest and in space. V holds rest vertices, shape (n, 3) [m]; F holds
// corner indices, shape (m, 3). `dphi` is what dphi_cloth_triangle_dX returns, shape (3, 3) [1/m].
// mu and lambda are in Pa, `volume` is area times thickness [m³] (the assignment's thickness is 1, so there
// it is the area).

#include <array>
#include <functional>
#include <vector>

#include <Eigen/SparseCore>

#include "sim/algebra/types.h"

namespace cloth {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Row i is the gradient of shape function i [1/m]: rows 1, 2 are (TᵀT)⁻¹Tᵀ with T = [X1-X0, X2-X0], row 0 is
/// minus their sum. Shape (3, 3). Requires a triangle with area.
Mat3 dphi_cloth_triangle_dX(const Vec3& X0, const Vec3& X1, const Vec3& X2);

/// F = (x0 x1 x2 n) (dphi; Nᵀ), shape (3, 3): maps rest directions to space, normal to normal. The rest
/// normal follows from dphi's rows. Requires that neither triangle is degenerate.
Mat3 deformation_gradient(const Mat3& dphi, const Vec9& q9);

/// dF/dq, shape (9, 9): row 3 a + b is dF_ab/dq; holds dn/dq.
Mat9 deformation_gradient_dq(const Mat3& dphi, const Vec9& q9);

/// Consistent mass of one triangle: M_ij = ρ h ∫ φ_i φ_j = ρ h A / 12 (1 + δ_ij), times the identity.
/// `mass` = ρ h A [kg]. Shape (9, 9).
Mat9 mass_matrix_triangle(double mass);

/// Consistent mass of the whole mesh, shape (3n, 3n) [kg]. `density` per area [kg/m²], `areas` shape (m)
/// [m²].
SparseMatrix mass_matrix_mesh(int vertex_count, const Triangles& F, double density, VecRef areas);

/// Kinetic energy T = ½ q̇ᵀ M q̇ [J].
double T_cloth(VecRef qdot, const SparseMatrix& M);

/// Gradient of the potential energy of gravity, V = -(M q)·(g, g, …): -M (g, g, …) [N]. g in m/s².
VecX dV_cloth_gravity_dq(const SparseMatrix& M, const Vec3& g);

/// ψ(s) = mu Σ (s_i - 1)² + lambda/2 (Σ s_i - 3)² over the singular values of F, times volume [J].
double V_membrane_corotational(const Mat3& dphi, const Vec9& q9, double volume, double mu, double lambda);

/// Gradient volume · (dF/dq)ᵀ vec(U diag(∂ψ/∂s) Wᵀ) [N], F = U S Wᵀ. Shape (9).
Vec9 dV_membrane_corotational_dq(const Mat3& dphi, const Vec9& q9, double volume, double mu, double lambda);

/// Hessian volume · (dF/dq)ᵀ (∂²ψ/∂F²) (dF/dq) [N/m] before the eigenvalue fix. Shape (9, 9). The term with
/// d²n/dq² is left out, as in the assignment. ∂²ψ/∂F² uses the singular value derivatives in closed form:
/// (ψ_i - ψ_j)/(s_i - s_j) = 2 mu for this ψ, so equal stretches are no special case.
Mat9 d2V_membrane_corotational_dq2_unfixed(const Mat3& dphi, const Vec9& q9, double volume, double mu,
                                           double lambda);

/// The same after the assignment's eigenvalue fix: eigenvalues below 1e-6 are set to 1e-3.
Mat9 d2V_membrane_corotational_dq2(const Mat3& dphi, const Vec9& q9, double volume, double mu, double lambda);

/// A singular value decomposition F = U diag(S) Vᵀ and its derivatives by every entry of F. As in the
/// assignment the last two indices are those of F's entry: dU[a][b](i, j) = ∂U_ab/∂F_ij, shape (3, 3, 3, 3),
/// dV likewise, and dS[k](i, j) = ∂S_k/∂F_ij, shape (3, 3, 3).
struct SvdDerivatives {
    Mat3 U;
    Vec3 S;
    Mat3 V;
    std::array<std::array<Mat3, 3>, 3> dU;
    std::array<Mat3, 3> dS;
    std::array<std::array<Mat3, 3>, 3> dV;
};

/// With A = Uᵀ E_ij V, E_ij being 1 at (i, j) and 0 elsewhere: ∂S_k = A_kk, ∂U = U X, ∂V = V Y, X and Y
/// antisymmetric, and for each pair k < l (Papadopoulo and Lourakis 2000, Estimating the Jacobian of the
/// singular value decomposition, whose two equations these solve by their sum and their difference)
///     X_kl + Y_kl = (A_kl + A_lk) / (S_l - S_k),     X_kl - Y_kl = (A_kl - A_lk) / (S_k + S_l).
///
/// Signs: S is not negative and falls; U and V are orthogonal, of either determinant, and the derivatives are
/// those of the branch through this U and V. Whoever turns the sign of column k of both U and V, as to make
/// them rotations, has to turn column k of ∂U and ∂V too; S and ∂S stay. Where S_k is 0, ∂S_k is that of the
/// smooth branch, which becomes negative on one side.
///
/// Where S_k = S_l (to 1e-10 of S_0) the two columns of U and V may turn together as they like, and where
/// both are 0 against each other: those turns have no derivative and are taken as 0, the smallest that solves
/// the equations. A function of F that is smooth there needs the limit in their place: for ψ the Hessian's
/// (ψ_k - ψ_l)/(S_k - S_l) → ψ_kk - ψ_kl, which is 2 mu.
SvdDerivatives dsvd(const Mat3& F);

/// Spring energy V = ½ k (|q1 - q0| - l0)² [J]; k in N/m, lengths in m.
double V_spring_particle_particle(const Vec3& q0, const Vec3& q1, double l0, double stiffness);

/// Its gradient with respect to (q0, q1) [N], shape (6). Zero where both ends coincide and l0 is 0.
Eigen::Matrix<double, 6, 1> dV_spring_particle_particle_dq(const Vec3& q0, const Vec3& q1, double l0,
                                                           double stiffness);

/// Force vector of the mesh, minus the sum of the membrane gradients [N]. Shape (3n). `dphi[t]` and
/// `volumes(t)` belong to triangle t.
VecX assemble_forces(VecRef q, const std::vector<Mat3>& dphi, const Triangles& F, VecRef volumes, double mu,
                     double lambda);

/// Stiffness matrix of the mesh, minus the sum of the fixed membrane Hessians [N/m]. Shape (3n, 3n).
SparseMatrix assemble_stiffness(VecRef q, const std::vector<Mat3>& dphi, const Triangles& F, VecRef volumes,
                                double mu, double lambda);

/// Projection P that drops the pinned vertices: shape (3 (n - pinned), 3n); q_free = P q, and
/// q = Pᵀ q_free + x0 with x0 = q_start - Pᵀ P q_start. `pinned` sorted, without repeats.
SparseMatrix fixed_point_constraints(int vertex_count, const std::vector<int>& pinned);

/// One step of linearly implicit Euler: (M - dt² K) v' = M v + dt f, q' = q + dt v', with f = force(q) and
/// K = stiffness(q) = df/dq.
void linearly_implicit_euler(VecX& q, VecX& qdot, double dt, const SparseMatrix& M,
                             const std::function<VecX(VecRef)>& force,
                             const std::function<SparseMatrix(VecRef)>& stiffness);

/// Indices of the vertices nearer than `radius` to `center` and the outward normals there.
struct SphereContacts {
    std::vector<int> vertices;
    std::vector<Vec3> normals;
};
SphereContacts collision_detection_cloth_sphere(VecRef q, const Vec3& center, double radius);

/// One-sided filter: takes the part along n out of a vertex velocity that points inward, v -= n (n·v) where
/// n·v < 0. A vertex that leaves is left alone.
void velocity_filter_cloth_sphere(VecX& qdot, const SphereContacts& contacts);

/// Vertices picked by a pointer: the ray through pixel `win` meets the mesh in its nearest triangle; the
/// corner of it nearest the hit, and all vertices within `radius` [m] of that corner, are picked, the corner
/// first. `win`: x to the right, y down, in pixels of `viewport` (width, height). `view`: world → camera;
/// `projection`: camera → clip (OpenGL). Empty where the ray meets nothing.
struct Pick {
    std::vector<int> vertices;
    Vec3 hit = Vec3::Zero();  ///< [m]
};
Pick pick_nearest_vertices(const Vec2& win, const Mat4& view, const Mat4& projection, const Vec2& viewport,
                           VecRef q, const Triangles& F, double radius);

/// The point at the depth of `reference` that is seen at pixel `win` [m].
Vec3 unproject(const Vec2& win, const Mat4& view, const Mat4& projection, const Vec2& viewport,
               const Vec3& reference);

}  // namespace cloth
