#pragma once
// Membrane with a warp and a weft: St. Venant-Kirchhoff, quadratic in the Green strain, and its viscosity.
//
// In the rest frame whose first axis is the warp's, with G = [x1-x0, x2-x0] Dm⁻¹ of shape (3, 2),
//
//   e = (E_11, E_22, 2 E_12), E = ½ (GᵀG - 1)         ψ = ½ eᵀ C e
//   C = 1/(1 - ν²r) [E_w, ν r E_w; ν r E_w, r E_w] and shear G_s;   r = E_weft / E_warp, ν = ν_warp→weft
//
// gradient_i = V G S b_i with the second Piola stress S = C e; H_ij/V = (b_iᵀ S b_j) 1 + B_iᵀ C B_j, B_i the
// derivative of e by x_i. The second part is positive semi-definite; the projection clamps S's eigenvalues at
// 0.
//
// Viscosity (Kelvin-Voigt): the same with e - e_base, divided by h and times a relaxation time τ, is a
// potential of the stress τ C ė: stiffness-proportional damping that leaves rigid motion alone.

#include <vector>

#include "sim/algebra/types.h"
#include "sim/energies/elements.h"
#include "sim/energies/energy.h"

namespace cloth {

/// Constants of one triangle at rest.
struct WovenRest {
    Mat32 b;        ///< row i: gradient of shape function i; columns: warp, weft [1/m]
    double volume;  ///< area times thickness [m³]
    Mat3 C;         ///< [Pa]
};

/// Stiffness of a sheet; `poisson` is the weft's shortening over the warp's stretch, ν² < E_warp/E_weft [Pa].
Mat3 woven_stiffness(double young_warp, double young_weft, double poisson, double shear);

/// `warp`: see make_rest_frame().
WovenRest make_woven_rest(const Vec3& X0, const Vec3& X1, const Vec3& X2, const Vec3& warp, double thickness,
                          const Mat3& C);

/// (E_11, E_22, 2 E_12)
Vec3 green_strain(const WovenRest& rest, const Vec9& q9);

/// The energy where the strain `from` counts as rest.
double woven_energy(const WovenRest& rest, const Vec3& from, const Vec9& q9);
Vec9 woven_gradient(const WovenRest& rest, const Vec3& from, const Vec9& q9);
Mat9 woven_hessian(const WovenRest& rest, const Vec3& from, const Vec9& q9, bool project);

class WovenEnergy final : public Energy {
  public:
    WovenEnergy(std::vector<std::array<int, 3>> triangles, std::vector<WovenRest> rest);

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
    std::vector<WovenRest> rest_;
};

class MembraneViscosity final : public StageEnergy {
  public:
    /// C in `rest` times τ: [Pa s].
    MembraneViscosity(std::vector<std::array<int, 3>> triangles, std::vector<WovenRest> rest);

    void begin(const Stage& stage) override;
    std::string_view name() const override { return "membrane viscosity"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override {
        elements_.append_pairs(pairs);
    }
    void bind(const BlockPattern& pattern) override { elements_.bind(pattern); }

  private:
    Elements<3> elements_;
    std::vector<WovenRest> rest_;
    std::vector<Vec3> base_;  ///< strains at the stage's base
    double h_ = 1.0;
};

}  // namespace cloth
