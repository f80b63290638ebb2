#pragma once
// The sum that a stage minimises, contact apart. Internal.

#include <vector>

#include "sim/energies/energy.h"
#include "sim/model.h"

namespace cloth {

/// The sum of the model's energies and of those of a step, each with its weight.
class Potential {
  public:
    struct Term {
        const Energy* energy;
        double weight = 1.0;
    };
    Potential(const Model& model, const std::vector<Term>& of_this_step) {
        for (const auto& energy : model.energies) terms_.push_back({energy.get()});
        terms_.insert(terms_.end(), of_this_step.begin(), of_this_step.end());
    }
    double value(const VecX& x) const {
        double sum = 0.0;
        for (const Term& term : terms_) sum += term.weight * term.energy->value(x);
        return sum;
    }
    void gradient(const VecX& x, VecX& g) const {
        g.setZero(x.size());
        for (const Term& term : terms_) {
            if (term.weight == 1.0) {
                term.energy->add_gradient(x, g);
            } else {
                VecX part = VecX::Zero(x.size());
                term.energy->add_gradient(x, part);
                g += term.weight * part;
            }
        }
    }
    void hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
        for (const Term& term : terms_) {
            if (term.weight == 1.0) {
                term.energy->add_hessian(x, kind, H);
            } else {
                BlockMatrix part;
                part.blocks.assign(H.blocks.size(), Mat3::Zero());
                term.energy->add_hessian(x, kind, part);
                for (std::size_t s = 0; s < H.blocks.size(); ++s) H.blocks[s] += term.weight * part.blocks[s];
            }
        }
    }

  private:
    std::vector<Term> terms_;
};

}  // namespace cloth
