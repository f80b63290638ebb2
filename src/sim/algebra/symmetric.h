#pragma once
// Functions of symmetric 2x2 matrices, in closed form. Internal.

#include <algorithm>
#include <cmath>

#include "sim/algebra/types.h"

namespace cloth {

/// The matrix with S's eigenvectors and the eigenvalues f(s): the mean of the two, and their half difference
/// along S's deviator.
template <class F>
Mat2 of_eigenvalues(const Mat2& S, const F& f) {
    const double mean = 0.5 * (S(0, 0) + S(1, 1));
    const double half = 0.5 * (S(0, 0) - S(1, 1)), shear = 0.5 * (S(0, 1) + S(1, 0));
    const double radius = std::sqrt(half * half + shear * shear);
    const double f0 = f(mean + radius), f1 = f(mean - radius);
    Mat2 result = 0.5 * (f0 + f1) * Mat2::Identity();
    if (radius > 0.0) {
        Mat2 deviator;
        deviator << half, shear, shear, -half;
        result += 0.5 * (f0 - f1) / radius * deviator;
    }
    return result;
}

/// Negative eigenvalues clamped at 0.
inline Mat2 positive_part(const Mat2& S) {
    return of_eigenvalues(S, [](double s) { return std::max(s, 0.0); });
}

}  // namespace cloth
