#pragma once
// Contact that cannot fail, as an energy: a barrier between all vertex-face and edge-edge pairs of cloth with
// itself, with other cloth and with colliders (barrier.h), and Coulomb friction (friction.h). Li et al. 2020,
// Incremental potential contact; Li et al. 2021, Codimensional incremental potential contact.

#include <array>
#include <string_view>
#include <vector>

#include "sim/contact/contact_set.h"
#include "sim/energies/energy.h"

namespace cloth {

/// Blocks outside the fixed pattern, (i, j) with i < j, ascending.
struct ExtraBlocks {
    std::vector<std::array<int, 2>> where;
    std::vector<Mat3> blocks;
    std::vector<Mat12> pairs;  ///< memory of BarrierContact::add_hessian()

    /// y += A x for these blocks and their transposes.
    void add_product(const VecX& x, VecX& y) const;
};

class BarrierContact final : public Energy {
  public:
    /// Of the stage that `set` is in; quick at the positions that it was last asked to find(). `set` must
    /// outlive this.
    explicit BarrierContact(const ContactSet& set) : set_(set) {}

    std::string_view name() const override { return "barrier contact"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    /// What the pattern takes of it: which pairs are in contact changes, their blocks may lie outside. Of a
    /// pair the pattern takes both sides' own blocks, and those that couple the sides all or none; so what is
    /// added of the projected Hessian is positive semi-definite by itself.
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    /// The same with the blocks left out in `extra`, which is overwritten. `slides`: kind of friction's
    /// Hessian, which is nowhere indefinite. Projected, it keeps a fifth of the secant's stiffness along the
    /// slide: with none, as the exact one has it, long Newton steps turn slides around, and again.
    void add_hessian(const VecX& x, HessianKind kind, HessianKind slides, BlockMatrix& H,
                     ExtraBlocks& extra) const;
    /// Adds minus the forces' change, to first order, as the colliders go the rest of their way [N].
    void add_placing_gradient(const VecX& x, VecX& g) const;
    /// Pairs of vertices that the candidates of now couple.
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override;
    void bind(const BlockPattern& pattern) override { pattern_ = &pattern; }

  private:
    const ContactSet& set_;
    const BlockPattern* pattern_ = nullptr;
};

}  // namespace cloth
