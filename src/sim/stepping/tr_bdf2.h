#pragma once
// TR-BDF2, two stages (newton.h) of h = (1 - 1/√2) dt, which is γ dt/2 with γ = 2 - √2 (Bank et al. 1985,
// Transient simulation of silicon devices and circuits).
//
// To t + γ dt by the trapezoidal rule: y = q + 2h v, f = -∇V(q); q_γ = x and v_γ = (x - q)/h - v. Dissipation
// (viscosity, air) is left out of f, and taken twice in V instead, at the mean velocity (x - q)/(2h).
//
// To t + dt by BDF2: base = c₁ q_γ - c₀ q, y = base + h (c₁ v_γ - c₀ v), f = 0, with c₁ = 1/(γ(2-γ)),
// c₀ = (1-γ)²/(γ(2-γ)); q' = x, v' = (x - base)/h, and the velocity filter.

#include "sim/stepping/step.h"

namespace cloth {

bool step_tr_bdf2(Step& step);

}  // namespace cloth
