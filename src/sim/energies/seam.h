#pragma once
// Seams: springs between pairs of vertices, ½ k (|x_a - x_b| - l(t))². Their rest length l shrinks linearly
// from the distance at the start to zero.

#include <vector>

#include "sim/energies/energy.h"

namespace cloth {

struct SeamSpring {
    int a, b;
    double stiffness;          ///< k [N/m]
    double length;             ///< distance at the start [m]
    double begin, close_time;  ///< [s]
};

class SeamEnergy final : public StageEnergy {
  public:
    explicit SeamEnergy(std::vector<SeamSpring> springs);

    void begin(const Stage& stage) override { time_ = stage.time; }
    bool conservative() const override { return true; }
    std::string_view name() const override { return "seam"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override;
    void bind(const BlockPattern& pattern) override;

  private:
    double rest_length(const SeamSpring& spring) const;

    std::vector<SeamSpring> springs_;
    std::vector<int> slots_;  ///< of block (min(a, b), max(a, b))
    const BlockPattern* pattern_ = nullptr;
    double time_ = 0.0;
};

}  // namespace cloth
