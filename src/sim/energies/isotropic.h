#pragma once
// Membranes whose energy depends on the two principal stretches alone: stable neo-Hookean, and strain limits.
//
// With G = [x1-x0, x2-x0] Dm⁻¹ = Σ s_i u_i v_iᵀ of shape (3, 2) and energy ψ(s0, s1) per volume, ∂ψ/∂G = Σ
// ψ_i u_i v_iᵀ, and the six eigenmatrices of the Hessian in G are known (Smith, de Goes and Kim 2019,
// Analytic Eigensystems for Isotropic Distortion Energies): the two scalings u_i v_iᵀ, coupled by ψ_ij; twist
// (u1 v0ᵀ - u0 v1ᵀ)/√2 with (ψ0 + ψ1)/(s0 + s1); flip (u1 v0ᵀ + u0 v1ᵀ)/√2 with (ψ0 - ψ1)/(s0 - s1); and,
// because a sheet may leave its plane, n v_iᵀ with ψ_i/s_i. Projection clamps each at 0.

#include <vector>

#include "sim/algebra/types.h"
#include "sim/energies/elements.h"
#include "sim/energies/energy.h"
#include "sim/energies/membrane.h"

namespace cloth {

/// ψ and its derivatives at two stretches, per volume [Pa].
struct StretchDerivatives {
    double d0, d1;         ///< ψ_i
    double d00, d01, d11;  ///< ψ_ij
    double twist, flip;    ///< (ψ0 + ψ1)/(s0 + s1), (ψ0 - ψ1)/(s0 - s1)
};

/// ψ = μ/2 (s0² + s1² - 2) - μ (J - 1) + (μ+λ)/2 (J - 1)², J = s0 s1: the stable neo-Hookean energy in two
/// dimensions (Smith, de Goes and Kim 2018, Stable Neo-Hookean Flesh Simulation), with moduli such that small
/// strains meet Hooke's law with μ and λ.
struct NeoHookean {
    double mu, lambda;  ///< [Pa]
    double value(double s0, double s1) const;
    StretchDerivatives derivatives(double s0, double s1) const;
};

/// Barrier that keeps both stretches below `limit`: ψ = k w² Σ b((s_i - ŝ)/w), b(y) = y³/(1-y) for 0 < y < 1,
/// w = limit - ŝ, rising from ŝ = 1 + (limit - 1)/2 on. Twice continuously differentiable; infinite from the
/// limit on.
struct StrainLimit {
    double stiffness;  ///< k [Pa]
    double limit;      ///< greatest stretch, above 1
    double value(double s0, double s1) const;
    StretchDerivatives derivatives(double s0, double s1) const;
    /// Whether ψ and its derivatives are 0 for certain where no stretch's square is above this.
    bool idle(double greatest_squared) const;
};

template <class Law>
class IsotropicEnergy final : public Energy {
  public:
    IsotropicEnergy(std::string_view name, std::vector<std::array<int, 3>> triangles,
                    std::vector<TriangleRest> rest, std::vector<Law> laws);

    std::string_view name() const override { return name_; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override {
        elements_.append_pairs(pairs);
    }
    void bind(const BlockPattern& pattern) override { elements_.bind(pattern); }

  private:
    bool idle(const VecX& x, int t) const;

    std::string_view name_;
    Elements<3> elements_;
    std::vector<TriangleRest> rest_;
    std::vector<Law> laws_;
};

extern template class IsotropicEnergy<NeoHookean>;
extern template class IsotropicEnergy<StrainLimit>;

}  // namespace cloth
