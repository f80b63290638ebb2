#pragma once
// The terms of the sum that a stage minimises, in one list: the model's energies, those that are made anew
// for each stage, and barrier contact.

#include <memory>
#include <optional>
#include <vector>

#include "sim/contact/barrier_contact.h"
#include "sim/contact/penalty.h"
#include "sim/energies/drag.h"
#include "sim/energies/energy.h"
#include "sim/model.h"

namespace cloth {

class Terms {
  public:
    /// `model` must outlive this.
    explicit Terms(const Model& model);

    /// Tells the terms of a stage. `dissipation`: weight of those that store nothing.
    void begin(const Stage& stage, double dissipation = 1.0);
    /// After the step that reached `state`: what they change for good.
    void finish(State& state) const;

    // Of the stage last begun, barrier contact apart.
    double value(const VecX& x) const;
    void gradient(const VecX& x, VecX& g) const;
    /// Leaves it in H.
    void hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const;

    /// Barrier contact: the one term that says how far a step may go, and whose Hessian couples more than the
    /// model's pattern. Null where there is none.
    const BarrierContact* barrier() const { return barrier_ ? &*barrier_ : nullptr; }
    /// What it is of; to be asked to find() where the energy is to be quick.
    ContactSet* contact() { return contact_ ? &*contact_ : nullptr; }
    /// Vertices that penalty contact met as the stage began.
    int penalty_contacts() const { return penalty_ ? penalty_->contact_count() : 0; }

    /// V of the terms that store energy, barrier contact apart, where `state` stands [J]. What was begun is
    /// then over.
    double stored(const State& state);

  private:
    struct Term {
        const Energy* energy;
        double weight = 1.0;
    };
    void list(const Stage& stage, double dissipation);
    void add_hessian(const Term& term, const VecX& x, HessianKind kind, BlockMatrix& H) const;

    const Model& model_;
    std::vector<std::unique_ptr<StageEnergy>> stage_energies_;
    std::optional<DragEnergy> drags_;
    std::optional<ColliderContactEnergy> penalty_;
    std::optional<ContactSet> contact_;
    std::optional<BarrierContact> barrier_;
    std::vector<Term> terms_;
    BlockMatrix constant_;  ///< Hessian of those whose it is constant, in this stage
};

/// Colliders that are on and that cloth feels.
std::vector<std::uint8_t> touched_colliders(const Model& model, const State& state);

}  // namespace cloth
