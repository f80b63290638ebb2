#pragma once
// In-plane stretch and shear of a triangle: the assignment's co-rotational energy in closed form.
//
// With an orthonormal rest frame (E, N) the assignment's 3x3 gradient is F = G Eᵀ + n Nᵀ, G = [x1-x0, x2-x0]
// Dm⁻¹ of shape (3, 2), so F's stretches are those of G and exactly 1. With C = GᵀG, J = √det C = s0 s1, I =
// s0 + s1 = √(tr C + 2J), R the rotation of G's polar decomposition G = R S, and c = λ(I-2) - 2μ:
//
//   ψ = μ (tr C - 2I + 2) + λ/2 (I-2)²          ∂ψ/∂G = 2μ G + c R         gradient_i = V (∂ψ/∂G) b_i
//   H_ij/V = 2μ (b_i·b_j)(1 - nnᵀ) + λ (R b_i)(R b_j)ᵀ + (c/I)(R Q b_i)(R Q b_j)ᵀ + (b_iᵀ K b_j) nnᵀ
//
// with b_i the shape functions' gradients in the rest frame, Q the quarter turn, K = 2μ 1 + c S⁻¹, V area
// times thickness. The eigenvalues of the 6x6 Hessian in G are 2μ+2λ, 2μ, 2μ, 2μ + 2c/I and those of K
// (ψ_i/s_i); the projection replaces c/I by max(c/I, -μ) and clamps K's eigenvalues at 0.
//
// The assignment's Hessian differs from this exact one by + V ψ_2 (dn/dq)ᵀ(dn/dq), ψ_2 = λ(I-2).

#include <vector>

#include "sim/algebra/types.h"
#include "sim/energies/assignment_hessian.h"
#include "sim/energies/elements.h"
#include "sim/energies/energy.h"

namespace cloth {

/// Constants of one triangle at rest.
struct TriangleRest {
    Mat32 b;            ///< row i: gradient of shape function i in the rest frame [1/m]
    double volume;      ///< area times thickness [m³]
    double mu, lambda;  ///< [Pa]
    Mat3 dphi;          ///< the same gradients in space, for the assignment's Hessian [1/m]
};

TriangleRest make_triangle_rest(const Vec3& X0, const Vec3& X1, const Vec3& X2, double thickness, double mu,
                                double lambda);

/// What energy and derivatives share: see the file's head.
struct MembraneKinematics {
    Mat32 G;
    Vec3 n;     ///< unit normal; zero where the triangle has no area
    double I;   ///< s0 + s1
    double D2;  ///< (s0 - s1)²
    Mat32 R;    ///< rotation of the polar decomposition G = R S

    MembraneKinematics(const TriangleRest& rest, const Vec9& q9);
};

double membrane_energy(const TriangleRest& rest, const Vec9& q9);
Vec9 membrane_gradient(const TriangleRest& rest, const Vec9& q9);
/// Exact Hessian; `project` makes it positive semi-definite. Requires a triangle of non-zero area.
Mat9 membrane_hessian(const TriangleRest& rest, const Vec9& q9, bool project);
/// Larger principal stretch s0.
double membrane_stretch(const TriangleRest& rest, const Vec9& q9);

/// Greatest principal stretch of any triangle.
double largest_stretch(const Triangles& triangles, const std::vector<TriangleRest>& rest, const VecX& x);

class MembraneEnergy final : public Energy {
  public:
    MembraneEnergy(std::vector<std::array<int, 3>> triangles, std::vector<TriangleRest> rest);

    std::string_view name() const override { return "membrane"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override {
        elements_.append_pairs(pairs);
    }
    void bind(const BlockPattern& pattern) override { elements_.bind(pattern); }

  private:
    Elements<3> elements_;
    std::vector<TriangleRest> rest_;
    std::vector<AssignmentRest> plane_;  ///< of HessianKind::assignment
};

}  // namespace cloth
