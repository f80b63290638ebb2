#include "sim/integrator.h"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <optional>

#include "sim/contact.h"
#include "sim/drag.h"
#include "sim/membrane.h"
#include "sim/simulation.h"
#include "sim/velocity_filter.h"

namespace cloth {
namespace {

/// The sum of the model's energies and of those that hold for one step only.
class Potential {
  public:
    Potential(const Model& model, std::initializer_list<Energy*> of_this_step) {
        for (const auto& energy : model.energies) terms_.push_back(energy.get());
        for (Energy* energy : of_this_step) {
            if (!energy) continue;
            energy->bind(model.pattern);
            terms_.push_back(energy);
        }
    }
    double value(const VecX& x) const {
        double sum = 0.0;
        for (const Energy* term : terms_) sum += term->value(x);
        return sum;
    }
    void gradient(const VecX& x, VecX& g) const {
        g.setZero(x.size());
        for (const Energy* term : terms_) term->add_gradient(x, g);
    }
    void hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
        for (const Energy* term : terms_) term->add_hessian(x, kind, H);
    }

  private:
    std::vector<const Energy*> terms_;
};

double kinetic_energy(const Model& model, const VecX& v, VecX& scratch) {
    multiply(model.pattern, model.mass, v, scratch);
    return 0.5 * v.dot(scratch);
}

void zero_pinned(const Model& model, VecX& v) {
    for (int i : model.pinned) v.segment<3>(3 * i).setZero();
}

/// system = M + dt² H(x)
void assemble_system(const Model& model, const Potential& potential, const VecX& x, HessianKind kind,
                     BlockMatrix& system) {
    const double dt = model.time_step;
    system.reset(model.pattern);
    potential.hessian(x, kind, system);
    for (std::size_t s = 0; s < system.blocks.size(); ++s) {
        system.blocks[s] *= dt * dt;
        system.blocks[s].diagonal().array() += model.mass.values[s];
    }
}

/// Factorises M + dt² H at w.positions with the exact Hessian where that is positive definite, else with as
/// large a share of it as is: near a bifurcation (a sheet about to buckle) a full projection hides the soft
/// direction.
bool factorize_newton_system(const Model& model, const Potential& potential, Workspace& w) {
    assemble_system(model, potential, w.positions, HessianKind::exact, w.system);
    if (w.solver.factorize(w.system)) return true;
    std::swap(w.system, w.exact_system);
    assemble_system(model, potential, w.positions, HessianKind::projected, w.system);
    for (double share : {0.9, 0.6}) {
        for (std::size_t s = 0; s < w.system.blocks.size(); ++s) {
            w.blended_system.blocks[s] =
                share * w.exact_system.blocks[s] + (1.0 - share) * w.system.blocks[s];
        }
        if (w.solver.factorize(w.blended_system)) return true;
    }
    return w.solver.factorize(w.system);
}

void solve_linearly_implicit(const Model& model, const Potential& potential, const State& state, Workspace& w,
                             StepReport& report) {
    const HessianKind kind = model.scene.simulation.hessian;
    assemble_system(model, potential, state.positions, kind, w.system);
    potential.gradient(state.positions, w.gradient);
    multiply(model.pattern, model.mass, state.velocities, w.rhs);
    w.rhs -= model.time_step * w.gradient;
    report.iterations = 1;
    report.converged = w.solver.factorize(w.system);
    if (report.converged) {
        w.solver.solve(w.rhs, w.velocity);
    } else {
        w.velocity = state.velocities;
    }
}

void solve_implicit(const Model& model, const Potential& potential, const State& state, Workspace& w,
                    StepReport& report) {
    const SimulationDesc& options = model.scene.simulation;
    const double dt = model.time_step;
    w.velocity = state.velocities;

    auto objective = [&](const VecX& v) {
        w.positions = state.positions + dt * v;
        w.trial = v - state.velocities;
        return kinetic_energy(model, w.trial, w.momentum) + potential.value(w.positions);
    };
    auto gradient = [&](const VecX& v) {
        w.positions = state.positions + dt * v;
        w.trial = v - state.velocities;
        potential.gradient(w.positions, w.gradient);
        multiply(model.pattern, model.mass, w.trial, w.momentum);
        w.rhs = -(w.momentum + dt * w.gradient);
        zero_pinned(model, w.rhs);
        return w.rhs.norm();
    };

    const double at_start = gradient(w.velocity);
    // Where the step begins in balance, the weight sets the scale.
    const double scale = std::max(at_start, 1e-3 * dt * model.weight);
    double norm = at_start;
    double value = objective(w.velocity);
    report.converged = norm <= options.newton_tolerance * scale;
    while (!report.converged && report.iterations < options.newton_iterations) {
        w.positions = state.positions + dt * w.velocity;
        if (!factorize_newton_system(model, potential, w)) break;
        w.solver.solve(w.rhs, w.direction);
        ++report.iterations;

        const double slope = -w.rhs.dot(w.direction);
        // Armijo's rule; where the decrease is lost in rounding, a smaller gradient is accepted instead.
        constexpr double sufficient = 1e-4;
        const VecX start = w.velocity;
        const double rounding = 1e-13 * (std::abs(value) + kinetic_energy(model, start, w.momentum));
        double length = 1.0;
        bool accepted = false;
        for (int k = 0; k < 40 && !accepted; ++k, length *= 0.5) {
            w.velocity = start + length * w.direction;
            const double trial_value = objective(w.velocity);
            if (trial_value <= value + sufficient * length * slope) {
                accepted = true;
            } else if (trial_value <= value + rounding && gradient(w.velocity) < norm) {
                accepted = true;
            }
            if (accepted) value = trial_value;
        }
        if (!accepted) {
            w.velocity = start;
            gradient(w.velocity);
            break;
        }
        norm = gradient(w.velocity);
        report.converged = norm <= options.newton_tolerance * scale;
    }
    report.residual = scale > 0.0 ? norm / scale : 0.0;
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

Workspace::Workspace(const Model& model) : solver(model.pattern, model.pinned) {
    for (BlockMatrix* matrix : {&system, &exact_system, &blended_system}) matrix->reset(model.pattern);
}

double total_energy(const Model& model, const State& state) {
    VecX scratch;
    DragEnergy drags(model.scene.drags, state.drags, state.time);
    return kinetic_energy(model, state.velocities, scratch) +
           Potential(model, {&drags}).value(state.positions);
}

StepReport advance(const Model& model, State& state, Workspace& w) {
    apply_events(model, state);
    update_drags(model.scene.drags, state.time, state.positions, model.triangles, state.drags);
    // The step ends at time + dt, so that is where its implicit springs pull to.
    DragEnergy drags(model.scene.drags, state.drags, state.time + model.time_step);
    const SimulationDesc& options = model.scene.simulation;
    std::vector<FilterContact> filtered;
    std::optional<ColliderContactEnergy> penalty;
    if (options.contact == ContactKind::velocity_filter) {
        filtered = find_filter_contacts(model.scene.colliders, state.collider_on, state.positions);
    } else {
        penalty.emplace(model.scene.colliders, state.collider_on, state.positions, options.contact_stiffness,
                        model.time_step, options.sliding_speed);
    }
    const Potential potential(model, {&drags, penalty ? &*penalty : nullptr});

    StepReport report;
    report.contacts = penalty ? penalty->contact_count() : static_cast<int>(filtered.size());
    report.energy_before =
        kinetic_energy(model, state.velocities, w.momentum) + potential.value(state.positions);
    if (state.integrator == IntegratorKind::implicit_euler) {
        solve_implicit(model, potential, state, w, report);
    } else {
        solve_linearly_implicit(model, potential, state, w, report);
    }
    filter_velocities(filtered, w.velocity);
    zero_pinned(model, w.velocity);

    state.velocities = w.velocity;
    state.positions += model.time_step * w.velocity;
    ++state.step;
    state.time = static_cast<double>(state.step) * model.time_step;

    const int bad = first_non_finite_vertex(state);
    if (bad >= 0) {
        report.non_finite_vertex = bad;
        report.converged = false;
        return report;
    }
    report.energy_after =
        kinetic_energy(model, state.velocities, w.momentum) + potential.value(state.positions);
    report.largest_stretch = model.membrane->largest_stretch(state.positions);
    return report;
}

}  // namespace cloth
