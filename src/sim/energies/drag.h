#pragma once
// Recorded mouse drags: picking, and the springs that pull what was picked.

#include <vector>

#include "sim/energies/energy.h"
#include "sim/scene/state.h"

namespace cloth {

/// Presses and releases the drags for a step that starts at `time`; picking looks at `positions`.
/// A drag is down from the first key's time until (not including) the last one's.
void update_drags(const std::vector<DragDesc>& drags, double time, const VecX& positions,
                  const Triangles& triangles, std::vector<DragState>& states);

/// Springs of rest length 0 from each picked vertex to its target at `time`: the place where it was picked,
/// plus the way that the pointer has gone, seen at the depth of the grabbed point.
class DragEnergy final : public Energy {
  public:
    DragEnergy(const std::vector<DragDesc>& drags, const std::vector<DragState>& states, double time);

    bool empty() const { return springs_.empty(); }
    std::string_view name() const override { return "drag"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>&) const override {}
    void bind(const BlockPattern& pattern) override;

  private:
    struct Spring {
        int vertex;
        Vec3 target;
        double stiffness;
    };
    std::vector<Spring> springs_;
    std::vector<int> slots_;  ///< diagonal block of each spring's vertex
};

}  // namespace cloth
