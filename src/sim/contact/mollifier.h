#pragma once
// The factor that takes the barrier from nearly parallel edges: between parallel ones the distance has a
// kink, so they leave the work to the vertices at their ends (Li et al. 2020, section 5).
//
//   m = (2 - c/c₀) c/c₀ where c = |e₁ x e₂|² < c₀, else 1;  c₀ = 10⁻³ |ē₁|²|ē₂|² of the rest shape [m⁴]

#include "sim/algebra/types.h"
#include "sim/geometry/collide.h"

namespace cloth {

/// m and its derivatives with respect to c; m = 1 where c₀ = 0.
struct Mollifier {
    double value = 1.0, first = 0.0, second = 0.0;
};
Mollifier mollify(double c, double c0);

/// c₀ of a pair of edges at rest.
double mollifier_threshold(const FourPoints& rest);

/// c of the edges x₀x₁ and x₂x₃, and its gradient and Hessian by the four points.
double cross_squared(const FourPoints& x);
struct CrossSquared {
    double value;
    Eigen::Matrix<double, 12, 1> gradient;
    Eigen::Matrix<double, 12, 12> hessian;
};
CrossSquared cross_squared_derivatives(const FourPoints& x);

}  // namespace cloth
