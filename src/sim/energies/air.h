#pragma once
// Drag and lift of each triangle in still air or wind.
//
// With u the air's velocity relative to the triangle, n its normal and A its area, a plate feels (Ling,
// Damodaran and Gay 1996, Aerodynamic force models for animating cloth motion in an air flow)
//
//   drag  ½ ρ C_D A |n·u| u                     along the relative wind, on the projected area
//   lift  ½ ρ C_L A (n·u) |u| (n - (n·û) û)     across it
//
// Together f = B u with B = ½ ρ A (C_L |u| nnᵀ + (C_D |n·u| - C_L (n·u)²/|u|) 1), which is positive
// semi-definite where C_L ≤ C_D. B is taken at the step's start and u at the velocities solved for: a
// quadratic potential, so the air never feeds a step. Each corner carries a third.

#include <cstdint>
#include <vector>

#include "sim/energies/elements.h"
#include "sim/energies/energy.h"

namespace cloth {

/// Wind: a mean and gusts, smooth in space and time, divergence-free: waves of random direction between a
/// quarter of gust_length and gust_length, each moved along by the mean wind and turning over at the gusts'
/// own speed.
class Wind {
  public:
    explicit Wind(const AirDesc& air);
    /// Velocity of the air [m/s].
    Vec3 at(const Vec3& place, double time) const;

  private:
    struct Wave {
        Vec3 per_metre, direction;  ///< [degree/m], [m/s]
        double per_second, phase;   ///< [degree/s], [degree]
    };
    Vec3 mean_;
    std::vector<Wave> waves_;
};

class AirEnergy final : public StageEnergy {
  public:
    AirEnergy(const Triangles& triangles, const AirDesc& air);

    void begin(const Stage& stage) override;
    std::string_view name() const override { return "air"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    bool constant_hessian() const override { return true; }
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override {
        elements_.append_pairs(pairs);
    }
    void bind(const BlockPattern& pattern) override { elements_.bind(pattern); }

  private:
    Vec3 relative_wind(const VecX& x, int t) const;

    Elements<3> elements_;
    AirDesc air_;
    Wind wind_field_;
    std::vector<Mat3> B_;     ///< [N s/m]
    std::vector<Vec3> wind_;  ///< at each triangle [m/s]
    VecX base_;
    double h_ = 1.0;
};

}  // namespace cloth
