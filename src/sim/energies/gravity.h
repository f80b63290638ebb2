#pragma once
// Weight: V = -Σ m_i g·x_i, with m_i the row sums of the mass matrix.

#include "sim/energies/energy.h"

namespace cloth {

class GravityEnergy final : public Energy {
  public:
    /// `masses` shape (n) [kg]; `gravity` [m/s²].
    GravityEnergy(const VecX& masses, const Vec3& gravity);

    std::string_view name() const override { return "gravity"; }
    double value(const VecX& x) const override { return weight_.dot(x); }
    void add_gradient(const VecX&, VecX& g) const override { g += weight_; }
    void add_hessian(const VecX&, HessianKind, BlockMatrix&) const override {}
    bool constant_hessian() const override { return true; }
    void append_pairs(std::vector<std::array<int, 2>>&) const override {}
    void bind(const BlockPattern&) override {}

  private:
    VecX weight_;  ///< gradient, -m_i g [N]
};

}  // namespace cloth
