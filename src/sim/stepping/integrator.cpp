#include "sim/stepping/integrator.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "sim/contact/contact_system.h"
#include "sim/contact/overlap.h"
#include "sim/contact/penalty.h"
#include "sim/contact/velocity_filter.h"
#include "sim/energies/drag.h"
#include "sim/energies/membrane.h"
#include "sim/motion/placement.h"
#include "sim/stepping/line_search.h"
#include "sim/stepping/potential.h"

namespace cloth {
namespace {

/// Colliders that are on and that cloth feels.
std::vector<std::uint8_t> touched_colliders(const Model& model, const State& state) {
    std::vector<std::uint8_t> touched = state.collider_on;
    for (std::size_t c = 0; c < touched.size(); ++c) {
        if (!model.scene.colliders[c].touchable) touched[c] = 0;
    }
    return touched;
}

/// Terms that are made anew for each stage, and the potential that they are part of.
struct StagePotential {
    DragEnergy drags;
    std::optional<ColliderContactEnergy> penalty;
    Potential potential;

    /// `start`: positions that friction slides from; `dissipation`: weight of the terms that store nothing.
    StagePotential(const Model& model, const State& state, const Stage& stage, const VecX& start,
                   Workspace& w, double dissipation = 1.0)
        : drags(model.scene.drags, state.drags, stage.time),
          penalty(make_penalty(model, state, stage, start)),
          potential(model, bind(model, stage, w, dissipation)) {}
    StagePotential(const StagePotential&) = delete;

  private:
    static std::optional<ColliderContactEnergy> make_penalty(const Model& model, const State& state,
                                                             const Stage& stage, const VecX& start) {
        const SimulationDesc& options = model.scene.simulation;
        if (options.contact != ContactKind::penalty) return std::nullopt;
        return ColliderContactEnergy(model.scene.colliders, touched_colliders(model, state), start,
                                     options.contact_stiffness, stage.h,
                                     options.sliding_speed.value_or(1e-3));
    }
    std::vector<Potential::Term> bind(const Model& model, const Stage& stage, Workspace& w,
                                      double dissipation) {
        drags.bind(model.pattern);
        std::vector<Potential::Term> terms{{&drags}};
        if (penalty) {
            penalty->bind(model.pattern);
            terms.push_back({&*penalty});
        }
        for (const auto& energy : w.stage_energies) {
            const double weight = energy->conservative() ? 1.0 : dissipation;
            if (weight == 0.0) continue;
            energy->begin(stage);
            terms.push_back({energy.get(), weight});
        }
        return terms;
    }
};

double kinetic_energy(const Model& model, const VecX& v, VecX& scratch) {
    multiply(model.pattern, model.mass, v, scratch);
    return 0.5 * v.dot(scratch);
}

/// Makes the solver leave out the vertices of `pins` and no others.
void leave_out(const Model& model, const std::vector<Pin>& pins, Workspace& w) {
    std::vector<int> vertices;
    for (const Pin& pin : pins) vertices.push_back(pin.vertex);
    if (vertices == w.pinned) return;
    w.solver = SparseSolver(model.pattern, vertices);
    if (w.contact) w.contact_work.single.emplace(model.pattern, vertices, SparseSolver::Precision::single);
    w.pinned = std::move(vertices);
}

/// system = M + h² H(x)
void assemble_system(const Model& model, const Potential& potential, const VecX& x, double h,
                     HessianKind kind, BlockMatrix& system) {
    system.reset(model.pattern);
    potential.hessian(x, kind, system);
    for (std::size_t s = 0; s < system.blocks.size(); ++s) {
        system.blocks[s] *= h * h;
        system.blocks[s].diagonal().array() += model.mass.values[s];
    }
}

/// Factorises M + h² H at x with the exact Hessian where that is positive definite, else with as large a
/// share of it as is: near a bifurcation (a sheet about to buckle) a full projection hides the soft
/// direction. `near`: close enough to the solution for that to pay.
bool factorize_newton_system(const Model& model, const Potential& potential, const VecX& x, double h,
                             bool near, Workspace& w) {
    if (!near && w.indefinite) {
        assemble_system(model, potential, x, h, HessianKind::projected, w.system);
        return w.solver.factorize(w.system);
    }
    assemble_system(model, potential, x, h, HessianKind::exact, w.system);
    w.indefinite = !w.solver.factorize(w.system);
    if (!w.indefinite) return true;
    std::swap(w.system, w.exact_system);
    assemble_system(model, potential, x, h, HessianKind::projected, w.system);
    for (double share : {0.9, 0.6}) {
        for (std::size_t s = 0; s < w.system.blocks.size(); ++s) {
            w.blended_system.blocks[s] =
                share * w.exact_system.blocks[s] + (1.0 - share) * w.system.blocks[s];
        }
        if (w.solver.factorize(w.blended_system)) return true;
    }
    return w.solver.factorize(w.system);
}

/// Detection at the old positions and the filter at the new velocities, as the assignment's.
class FilterOfStep {
  public:
    FilterOfStep(const Model& model, const State& state, StepReport& report) {
        if (model.scene.simulation.contact != ContactKind::velocity_filter) return;
        contacts_ =
            find_filter_contacts(model.scene.colliders, touched_colliders(model, state), state.positions);
        report.contacts = std::max(report.contacts, static_cast<int>(contacts_.size()));
    }
    void apply(VecX& v) const { filter_velocities(contacts_, v); }
    /// Positions follow the filtered velocities.
    void apply(double h, VecX& x, VecX& v) const {
        if (contacts_.empty()) return;
        VecX filtered = v;
        filter_velocities(contacts_, filtered);
        x += h * (filtered - v);
        v = filtered;
    }

  private:
    std::vector<FilterContact> contacts_;
};

/// The velocities that take pins from `start` to their places within dt.
void set_pinned_velocities(const std::vector<Pin>& pins, const VecX& start, double dt, VecX& v) {
    for (const Pin& pin : pins) {
        v.segment<3>(3 * pin.vertex) = (pin.position - start.segment<3>(3 * pin.vertex)) / dt;
    }
}

bool step_linearly_implicit(const Model& model, State& state, double dt, const std::vector<Pin>& pins,
                            Workspace& w, StepReport& report) {
    const SimulationDesc& options = model.scene.simulation;
    const VecX start = state.positions;
    const Stage step{{{1.0, start}}, dt, state.time + dt, state};
    const StagePotential stage(model, state, step, start, w);
    const FilterOfStep filter(model, state, report);
    if (stage.penalty) report.contacts = std::max(report.contacts, stage.penalty->contact_count());
    const HessianKind kind =
        options.hessian == LinearHessian::assignment ? HessianKind::assignment : HessianKind::projected;
    assemble_system(model, stage.potential, state.positions, dt, kind, w.system);
    stage.potential.gradient(state.positions, w.gradient);
    multiply(model.pattern, model.mass, state.velocities, w.rhs);
    w.rhs -= dt * w.gradient;
    ++report.iterations;
    if (!w.solver.factorize(w.system)) return false;

    // Pins that move take their neighbours along.
    w.trial.setZero(w.rhs.size());
    set_pinned_velocities(pins, state.positions, dt, w.trial);
    if (!w.trial.isZero(0.0)) {
        multiply(model.pattern, w.system, w.trial, w.momentum);
        w.rhs -= w.momentum;
    }
    w.solver.solve(w.rhs, w.velocity);
    filter.apply(w.velocity);
    set_pinned_velocities(pins, state.positions, dt, w.velocity);

    state.velocities = w.velocity;
    state.positions += dt * w.velocity;
    return true;
}

/// A minimisation: see integrator.h.
struct StageProblem {
    const Potential& potential;
    const std::vector<Pin>& pins;
    double h;
    VecX y;                  ///< shape (3n) [m]
    double from, to;         ///< time where x starts and where it ends [s]
    const VecX& slide_from;  ///< positions that friction counts its way from, shape (3n) [m]
    VecX force = VecX();     ///< f, shape (3n) [N]; empty: none
};

bool minimize_among_barriers(const Model& model, const State& state, const StageProblem& problem, VecX& x,
                             Workspace& w, StepReport& report) {
    const auto& colliders = model.scene.colliders;
    w.contact->begin(x, problem.slide_from, problem.h, placements_at(colliders, problem.from),
                     placements_at(colliders, problem.to), touched_colliders(model, state));
    StepReport solve = minimize_with_contact(
        {model, problem.potential, *w.contact, problem.pins, problem.h, problem.y, problem.force}, w.solver,
        x, w.contact_work);
    if (solve.converged) {
        solve.contacts = w.contact->contact_count(x);
        solve.smallest_gap = w.contact->smallest_gap(x);
    }
    merge(report, solve);
    return solve.converged;
}

/// Root of the sum of the squared diagonal blocks' traces.
double diagonal_norm(const Model& model, const BlockMatrix& A) {
    double sum = 0.0;
    for (int i = 0; i < model.vertex_count(); ++i) {
        const double trace = A.blocks[model.pattern.diagonal(i)].trace();
        sum += trace * trace;
    }
    return std::sqrt(sum);
}

/// From the allowed positions x to the minimum; false where it is not reached. x is then of no use.
bool minimize(const Model& model, const State& state, const StageProblem& problem, VecX& x, Workspace& w,
              StepReport& report) {
    if (w.contact) return minimize_among_barriers(model, state, problem, x, w, report);
    const SimulationDesc& options = model.scene.simulation;
    const Potential& potential = problem.potential;
    const double h2 = problem.h * problem.h;

    auto objective = [&](const VecX& at) {
        w.trial = at - problem.y;
        multiply(model.pattern, model.mass, w.trial, w.momentum);
        double value = 0.5 / h2 * w.trial.dot(w.momentum) + potential.value(at);
        if (problem.force.size() > 0) value -= problem.force.dot(at);
        return value;
    };
    // Leaves -h² ∇Φ on the free vertices in w.rhs; gives |∇Φ|.
    auto gradient = [&](const VecX& at) {
        w.trial = at - problem.y;
        potential.gradient(at, w.gradient);
        if (problem.force.size() > 0) w.gradient -= problem.force;
        multiply(model.pattern, model.mass, w.trial, w.momentum);
        w.rhs = -(w.momentum + h2 * w.gradient);
        zero_pinned(problem.pins, w.rhs);
        return w.rhs.norm() / h2;
    };

    // Where the step begins in balance, the weight sets the scale.
    const double scale = std::max(gradient(x), 1e-2 * model.weight);
    double value = objective(x);

    // Inertia's guess, with the pins where they go. If that is not allowed, or no better, the pins go there
    // together with what the cloth's stiffness makes of their way, as far as is allowed at a time.
    bool placed = pins_placed(problem.pins, x);
    w.positions = problem.y;
    place_pinned(problem.pins, w.positions);
    const double guess = objective(w.positions);
    if (placed ? guess < value : std::isfinite(guess)) {
        x = w.positions;
        value = guess;
        placed = true;
    }
    constexpr int most_placements = 30;
    for (int k = 0; !placed && k < most_placements; ++k) {
        gradient(x);
        assemble_system(model, potential, x, problem.h, HessianKind::projected, w.system);
        if (!w.solver.factorize(w.system)) return false;
        ++report.iterations;
        w.positions.setZero(x.size());
        set_pinned_way(problem.pins, x, w.positions);
        multiply(model.pattern, w.system, w.positions, w.momentum);
        w.rhs -= w.momentum;
        w.solver.solve(w.rhs, w.direction);
        set_pinned_way(problem.pins, x, w.direction);
        const VecX start = x;
        double share = 1.0;
        x = start + share * w.direction;
        for (int halvings = 0; !std::isfinite(value = objective(x)); ++halvings) {
            if (halvings == 30) return false;
            share *= 0.5;
            x = start + share * w.direction;
        }
        if (share == 1.0) {
            placed = true;
            place_pinned(problem.pins, x);
            value = objective(x);
        }
    }
    if (!placed) return false;

    double norm = gradient(x);
    const double extent = x.cwiseAbs().maxCoeff();
    bool converged = norm <= options.newton_tolerance * scale;
    for (int k = 0; !converged && k < options.newton_iterations; ++k) {
        if (!factorize_newton_system(model, potential, x, problem.h, norm < 1e-2 * scale, w)) break;
        // Rounding of the positions alone is worth this much: nothing smaller can be asked for.
        constexpr double rounding_share = 4e-16;
        converged = norm <= rounding_share * extent * diagonal_norm(model, w.system) / h2;
        if (converged) break;
        w.solver.solve(w.rhs, w.direction);
        ++report.iterations;

        const double slope = -w.rhs.dot(w.direction) / h2;
        const double rounding = 1e-13 * (std::abs(value) + model.weight * extent);
        w.start = x;
        if (!search_line(w.start, w.direction, 1.0, slope, rounding, norm, objective, gradient, x, value))
            break;
        norm = gradient(x);
        converged = norm <= options.newton_tolerance * scale;
    }
    norm = gradient(x);
    const double residual = scale > 0.0 ? norm / scale : 0.0;
    report.residual = std::max(report.residual, residual);
    if (!converged) report.worst_vertex = worst_vertex(w.rhs);
    return converged;
}

bool step_implicit_euler(const Model& model, State& state, double dt, const std::vector<Pin>& pins,
                         Workspace& w, StepReport& report) {
    const Stage stage{{{1.0, state.positions}}, dt, state.time + dt, state};
    const StagePotential terms(model, state, stage, state.positions, w);
    const FilterOfStep filter(model, state, report);
    if (terms.penalty) report.contacts = std::max(report.contacts, terms.penalty->contact_count());
    VecX x = state.positions;
    if (!minimize(model, state,
                  {terms.potential, pins, dt, state.positions + dt * state.velocities, state.time, stage.time,
                   state.positions},
                  x, w, report)) {
        return false;
    }
    state.velocities = (x - state.positions) / dt;
    filter.apply(dt, x, state.velocities);
    state.positions = x;
    return true;
}

bool step_implicit_midpoint(const Model& model, State& state, double dt, const std::vector<Pin>& pins,
                            Workspace& w, StepReport& report) {
    const double h = 0.5 * dt;
    const Stage stage{{{1.0, state.positions}}, h, state.time + h, state};
    const StagePotential terms(model, state, stage, state.positions, w);
    const FilterOfStep filter(model, state, report);
    if (terms.penalty) report.contacts = std::max(report.contacts, terms.penalty->contact_count());
    // Half of the way for the pins too.
    std::vector<Pin> half = pins;
    for (Pin& pin : half) {
        pin.position = 0.5 * (pin.position + Vec3(state.positions.segment<3>(3 * pin.vertex)));
    }
    VecX x = state.positions;
    if (!minimize(model, state,
                  {terms.potential, half, h, state.positions + h * state.velocities, state.time, stage.time,
                   state.positions},
                  x, w, report)) {
        return false;
    }
    VecX velocities = 2.0 / h * (x - state.positions) - state.velocities;
    x = 2.0 * x - state.positions;
    set_pinned_velocities(pins, state.positions, dt, velocities);
    place_pinned(pins, x);
    filter.apply(dt, x, velocities);
    state.positions = x;
    state.velocities = velocities;
    return true;
}

bool step_tr_bdf2(const Model& model, State& state, double dt, const std::vector<Pin>& pins, Workspace& w,
                  StepReport& report) {
    const double root2 = std::sqrt(2.0), gamma = 2.0 - root2, h = 0.5 * gamma * dt;
    const FilterOfStep filter(model, state, report);
    const VecX q = state.positions, v = state.velocities;

    // The forces at the start, dissipation apart: that of the first stage is taken at its mean velocity.
    VecX force;
    {
        const VecX before = q - h * v;
        const Stage stage{{{1.0, before}}, h, state.time, state};
        const StagePotential terms(model, state, stage, before, w, 0.0);
        terms.potential.gradient(q, force);
        if (w.contact) {
            const auto there = placements_at(model.scene.colliders, state.time);
            w.contact->begin(q, before, h, there, there, touched_colliders(model, state));
            w.contact->add_gradient(q, force);
        }
        force *= -1.0;
        zero_pinned(pins, force);
    }
    VecX x = q, v_gamma;
    {
        const Stage stage{{{1.0, q}}, 2.0 * h, state.time + gamma * dt, state};
        const StagePotential terms(model, state, stage, q, w, 2.0);
        if (terms.penalty) report.contacts = std::max(report.contacts, terms.penalty->contact_count());
        std::vector<Pin> part = pins;
        for (Pin& pin : part) {
            const Vec3 from = q.segment<3>(3 * pin.vertex);
            if (pin.position != from) pin.position = from + gamma * (pin.position - from);
        }
        if (!minimize(model, state,
                      {terms.potential, part, h, q + 2.0 * h * v, state.time, stage.time, q, force}, x, w,
                      report)) {
            return false;
        }
        v_gamma = (x - q) / h - v;
        for (const Pin& pin : pins) v_gamma.segment<3>(3 * pin.vertex) = v.segment<3>(3 * pin.vertex);
    }
    const double c1 = 1.0 / (gamma * (2.0 - gamma)), c0 = (1.0 - gamma) * (1.0 - gamma) * c1;
    const VecX x_gamma = x;
    const Stage stage{{{c1, x_gamma}, {-c0, q}}, h, state.time + dt, state};
    const StagePotential terms(model, state, stage, x_gamma, w);
    const VecX base = stage.base();
    VecX y = base + h * (c1 * v_gamma - c0 * v);
    if (!minimize(model, state,
                  {terms.potential, pins, h, std::move(y), state.time + gamma * dt, stage.time, x_gamma}, x,
                  w, report)) {
        return false;
    }
    state.velocities = (x - base) / h;
    set_pinned_velocities(pins, q, dt, state.velocities);
    filter.apply(dt, x, state.velocities);
    state.positions = x;
    return true;
}

/// One step of any length, in two halves where it does not converge.
bool step_by(const Model& model, State& state, double dt, int halvings, Workspace& w, StepReport& report) {
    const std::vector<Pin> pins = pins_of_step(model.pin_groups, state.time, state.time + dt);
    leave_out(model, pins, w);
    StepReport attempt;
    const bool converged = [&] {
        switch (state.integrator) {
            case IntegratorKind::linearly_implicit_euler:
                return step_linearly_implicit(model, state, dt, pins, w, attempt);
            case IntegratorKind::implicit_euler:
                return step_implicit_euler(model, state, dt, pins, w, attempt);
            case IntegratorKind::tr_bdf2:
                return step_tr_bdf2(model, state, dt, pins, w, attempt);
            case IntegratorKind::implicit_midpoint:
                return step_implicit_midpoint(model, state, dt, pins, w, attempt);
        }
        return false;
    }();
    if (converged) {
        merge(report, attempt);
        state.time += dt;
        return true;
    }
    if (halvings == 0) {
        merge(report, attempt);
        return false;
    }
    merge_work(report, attempt);
    ++report.retries;
    return step_by(model, state, 0.5 * dt, halvings - 1, w, report) &&
           step_by(model, state, 0.5 * dt, halvings - 1, w, report);
}

void apply_events(const Model& model, State& state) {
    const auto& events = model.scene.events;
    constexpr double slack = 1e-9;  // an event at 0.3 meets the step that starts at 0.29999999999999998
    while (state.events_done < events.size() && events[state.events_done].time <= state.time + slack) {
        const EventDesc& event = events[state.events_done++];
        if (event.collider) {
            auto& on = state.collider_on[*event.collider];
            on = event.action == Switch::toggle ? !on : event.action == Switch::on;
        }
        if (event.integrator) state.integrator = *event.integrator;
        if (event.toggle_integrator) {
            state.integrator = state.integrator == IntegratorKind::implicit_euler
                                   ? IntegratorKind::linearly_implicit_euler
                                   : IntegratorKind::implicit_euler;
        }
    }
}

}  // namespace

Workspace::Workspace(const Model& model)
    : pinned(model.pinned), solver(model.pattern, model.pinned), stage_energies(make_stage_energies(model)) {
    for (BlockMatrix* matrix : {&system, &exact_system, &blended_system}) matrix->reset(model.pattern);
    for (const auto& energy : stage_energies) energy->bind(model.pattern);
    if (model.scene.simulation.contact == ContactKind::barrier) {
        contact.emplace(make_contact_system(model));
        contact->bind(model.pattern);
        contact_work.single.emplace(model.pattern, pinned, SparseSolver::Precision::single);
    }
}

double kinetic_energy(const Model& model, const State& state) {
    VecX scratch;
    return kinetic_energy(model, state.velocities, scratch);
}

namespace {

double stored_energy(const Model& model, const State& state,
                     const std::vector<std::unique_ptr<StageEnergy>>& stage_energies) {
    DragEnergy drags(model.scene.drags, state.drags, state.time);
    double energy = kinetic_energy(model, state) + Potential(model, {{&drags}}).value(state.positions);
    const SimulationDesc& options = model.scene.simulation;
    if (options.contact == ContactKind::penalty) {
        energy += ColliderContactEnergy(model.scene.colliders, touched_colliders(model, state),
                                        state.positions, options.contact_stiffness, model.time_step,
                                        options.sliding_speed.value_or(1e-3))
                      .value(state.positions);
    }
    for (const auto& term : stage_energies) {
        if (!term->conservative()) continue;
        term->begin({{{1.0, state.positions}}, model.time_step, state.time, state});
        energy += term->value(state.positions);
    }
    return energy;
}

}  // namespace

double total_energy(const Model& model, const State& state) {
    return stored_energy(model, state, make_stage_energies(model));
}

StepReport advance(const Model& model, State& state, Workspace& w) {
    apply_events(model, state);
    update_drags(model.scene.drags, state.time, state.positions, model.triangles, state.drags);

    if (w.contact && w.checked != state.collider_on) {
        const auto there = placements_at(model.scene.colliders, state.time);
        w.contact->begin(state.positions, state.positions, model.time_step, there, there,
                         touched_colliders(model, state));
        require_no_overlap(model, *w.contact, state.positions);
        w.checked = state.collider_on;
    }

    StepReport report;
    report.energy_before = stored_energy(model, state, w.stage_energies);
    const State before = state;
    report.converged = step_by(model, state, model.time_step, model.scene.simulation.retries, w, report);
    if (!report.converged) {
        state = before;
        return report;
    }
    ++state.step;
    state.time = static_cast<double>(state.step) * model.time_step;

    const int bad = first_non_finite_vertex(state);
    if (bad >= 0) {
        report.non_finite_vertex = bad;
        report.converged = false;
        return report;
    }
    for (const auto& energy : w.stage_energies) energy->finish(state);
    report.energy_after = stored_energy(model, state, w.stage_energies);
    report.largest_stretch = largest_stretch(model.triangles, model.triangle_rest, state.positions);
    return report;
}

}  // namespace cloth
