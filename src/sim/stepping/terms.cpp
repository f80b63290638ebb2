#include "sim/stepping/terms.h"

#include "sim/contact/contact_system.h"
#include "sim/motion/placement.h"

namespace cloth {

Terms::Terms(const Model& model) : model_(model), stage_energies_(make_stage_energies(model)) {
    for (const auto& energy : stage_energies_) energy->bind(model.pattern);
    if (model.scene.simulation.contact == ContactKind::barrier) {
        contact_.emplace(make_contact_system(model));
        barrier_.emplace(*contact_);
        barrier_->bind(model.pattern);
    }
}

void Terms::begin(const Stage& stage, double dissipation) {
    list(stage, dissipation);
    constant_.reset(model_.pattern);
    for (const Term& term : terms_) {
        if (term.energy->constant_hessian()) add_hessian(term, stage.start, HessianKind::exact, constant_);
    }
    if (!contact_) return;
    const auto& colliders = model_.scene.colliders;
    contact_->begin(stage.start, stage.past.front().positions, stage.h,
                    placements_at(colliders, stage.start_time), placements_at(colliders, stage.time),
                    touched_colliders(model_, stage.state));
}

void Terms::list(const Stage& stage, double dissipation) {
    terms_.clear();
    for (const auto& energy : model_.energies) terms_.push_back({energy.get()});
    drags_.emplace(model_.scene.drags, stage.state.drags, stage.time);
    drags_->bind(model_.pattern);
    terms_.push_back({&*drags_});
    const SimulationDesc& options = model_.scene.simulation;
    if (options.contact == ContactKind::penalty) {
        penalty_.emplace(model_.scene.colliders, touched_colliders(model_, stage.state),
                         stage.past.front().positions, options.contact_stiffness, stage.h,
                         options.sliding_speed.value_or(1e-3));
        penalty_->bind(model_.pattern);
        terms_.push_back({&*penalty_});
    }
    for (const auto& energy : stage_energies_) {
        const double weight = energy->conservative() ? 1.0 : dissipation;
        if (weight == 0.0) continue;
        energy->begin(stage);
        terms_.push_back({energy.get(), weight});
    }
}

void Terms::finish(State& state) const {
    for (const auto& energy : stage_energies_) energy->finish(state);
}

double Terms::value(const VecX& x) const {
    double sum = 0.0;
    for (const Term& term : terms_) sum += term.weight * term.energy->value(x);
    return sum;
}

void Terms::gradient(const VecX& x, VecX& g) const {
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

void Terms::hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    H.blocks = constant_.blocks;
    for (const Term& term : terms_) {
        if (!term.energy->constant_hessian()) add_hessian(term, x, kind, H);
    }
}

void Terms::add_hessian(const Term& term, const VecX& x, HessianKind kind, BlockMatrix& H) const {
    if (term.weight == 1.0) {
        term.energy->add_hessian(x, kind, H);
        return;
    }
    BlockMatrix part;
    part.reset(model_.pattern);
    term.energy->add_hessian(x, kind, part);
    for (std::size_t s = 0; s < H.blocks.size(); ++s) H.blocks[s] += term.weight * part.blocks[s];
}

double Terms::stored(const State& state) {
    list({{{1.0, state.positions}}, model_.time_step, state.time, state}, 0.0);
    return value(state.positions);
}

std::vector<std::uint8_t> touched_colliders(const Model& model, const State& state) {
    std::vector<std::uint8_t> touched = state.collider_on;
    for (std::size_t c = 0; c < touched.size(); ++c) {
        if (!model.scene.colliders[c].touchable) touched[c] = 0;
    }
    return touched;
}

}  // namespace cloth
