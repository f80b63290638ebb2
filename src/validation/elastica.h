#pragma once
// References computed without the simulator.

namespace cloth::validation {

/// Heavy elastica: an inextensible strip clamped level at one end, free at the other, under its own weight:
/// θ'' = -Γ (1-σ) cos θ, θ(0) = 0, θ'(1) = 0; θ below the horizontal, Γ = ρ_A g L³ / D. Solved by shooting
/// from the free end (Runge-Kutta of 4th order; the tip's angle to the vertical by bisection of its
/// logarithm).
struct Elastica {
    double drop, span;  ///< H/L and W/L of the tip
};
Elastica heavy_elastica(double gamma);

/// Load w L³/√(B C) at which a strip of width b, clamped at one end with its width upright, buckles sideways
/// under its own weight w per length; B = D b and C = 2 D b, Poisson's ratio 0. As b/L → 0 it tends to 12.85
/// (Prandtl 1899; Timoshenko and Gere, Theory of Elastic Stability, 6.3). By the Ritz method: Kirchhoff's
/// plate energy against the work of the plane-stress field of a heavy cantilever, in polynomials x^{2+i} y^j.
double lateral_buckling_load(double width_over_length);

}  // namespace cloth::validation
