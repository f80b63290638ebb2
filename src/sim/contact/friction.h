#pragma once
// Coulomb friction during a stage, with normal forces and directions of its start (Li et al. 2020, section
// 4).
//
//   D = Σ f φ(|u|), f = μ · normal force;  u = (1 - nnᵀ)(Σ w x - s): tangential way of the two sides against
//   each other since the start, w and n those of the contact at the start φ(u) = u²/ε - u³/(3ε²) below the
//   way ε, u - ε/3 above: static below, full force above

#include <array>
#include <vector>

#include "sim/algebra/types.h"

namespace cloth {

/// Friction of one contact.
struct Friction {
    std::array<int, 4>
        points;  ///< vertices of cloth; -1: none, or a collider's, whose way is part of `start`
    std::array<double, 4> weights;
    Vec3 normal, start;  ///< n, s
    double force;        ///< f [N]
    int split;           ///< points before this one are side A's
};

struct FrictionList {
    std::vector<Friction> items;
    double sliding_way = 0.0;  ///< ε [m]

    void add_value(const VecX& x, double& sum) const;
    void add_gradient(const VecX& x, VecX& g) const;
    /// Of item k by u; block (i, j) over its points is w_i w_j times this. `curvature`: share of what turns
    /// with u, which takes away all stiffness along the slide at 1.
    Mat3 hessian(int k, const VecX& x, double curvature) const;
};

}  // namespace cloth
