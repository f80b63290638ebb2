#pragma once
// The barrier that keeps a pair of simplices apart: value, gradient, Hessian of one contact.
//
//   gap           g = d - t; d: distance of the pair's simplices, t: sum of both sides' radii (half of a
//                 cloth's contact thickness, a collider's radius or offset)
//   barrier       E = m κ B(g), B = y³/(1-y), y = 1 - g/ĝ for 0 < g < ĝ; 0 beyond, infinite at g ≤ 0
//                 dE/dg = -m κ/ĝ · y²(3-2y)/(1-y)²; twice differentiable at ĝ; a quotient, so that its last
//                 bit is the same everywhere, where a logarithm's is not
//   mollifier     m, of parallel edges (mollifier.h)
//   curvature     with w the weights of collide.h, u_k the changes of w that shift the nearest points by unit
//                 tangents t_k, n = d/|d|:
//                   ∇²d = 1/d [w wᵀ ⊗ (1 - nnᵀ) - Σ_k (d u_k⊗n + w⊗t_k)(d u_k⊗n + w⊗t_k)ᵀ]
//                 Projection: E'' ∇d ∇dᵀ stays; of -E' [d aaᵀ + acᵀ + caᵀ], a = u_k⊗n, c = w⊗t_k, a rank-two
//                 form for each k, its one positive eigenvalue stays; the rest of ∇²d, times E' < 0, is
//                 negative. Mollified pairs are projected by their eigenvalues.

#include <array>

#include "sim/algebra/types.h"
#include "sim/energies/energy.h"
#include "sim/geometry/collide.h"

namespace cloth {

using Vec12 = Eigen::Matrix<double, 12, 1>;
using Mat12 = Eigen::Matrix<double, 12, 12>;

/// κ B and its derivatives with respect to the gap.
struct BarrierValue {
    double value, first, second;
};
BarrierValue barrier(double gap, double activation, double stiffness);

/// A pair nearer than its activation distance, at the positions it was found at.
struct Contact {
    std::array<int, 4> points;  ///< in ContactMesh numbers, sides as in collide.h; -1: none
    Nearest nearest;
    Vec3 normal;
    double distance, gap;          ///< d, g [m]
    double activation, stiffness;  ///< ĝ [m], κ [J]
    double mollifier;              ///< c₀ (mollifier.h); 0: none
    double friction;               ///< μ
    int collider = -1;             ///< that one side belongs to; -1: none
    int plane = -1;                ///< the other side is this half-space, d is linear; -1: it is not
    bool edges = false;

    int split() const { return edges ? 2 : 1; }  ///< points before this one are side A's
};

/// E at its points x [J], its gradient and Hessian by them. Points that `c` lacks have no meaning in `x`.
double contact_value(const Contact& c, const FourPoints& x);
Vec12 contact_gradient(const Contact& c, const FourPoints& x);
Mat12 contact_hessian(const Contact& c, const FourPoints& x, HessianKind kind);

}  // namespace cloth
