#pragma once
// What the minimisations of a stage share: the line search, and the report of where balance is missed.
// Internal.

#include "sim/algebra/types.h"

namespace cloth {

/// Backtracks from x = start + length · direction by halves until Armijo's rule holds; where the decrease is
/// lost in `rounding` of the value, a gradient smaller than `norm` is accepted instead. On success x and
/// `value` are those of the step; else x is the start again.
template <class Objective, class GradientNorm>
bool search_line(const VecX& start, const VecX& direction, double length, double slope, double rounding,
                 double norm, const Objective& objective, const GradientNorm& gradient_norm, VecX& x,
                 double& value) {
    constexpr double sufficient = 1e-4;
    for (int halvings = 0; halvings < 40; ++halvings, length *= 0.5) {
        x = start + length * direction;
        const double trial = objective(x);
        if (trial <= value + sufficient * length * slope ||
            (trial <= value + rounding && gradient_norm(x) < norm)) {
            value = trial;
            return true;
        }
    }
    x = start;
    return false;
}

/// Vertex whose part of the residual, shape (3n), is the largest.
inline int worst_vertex(const VecX& residual) {
    Eigen::Index worst = 0;
    residual.reshaped(3, residual.size() / 3).colwise().squaredNorm().maxCoeff(&worst);
    return static_cast<int>(worst);
}

}  // namespace cloth
