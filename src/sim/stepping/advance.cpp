#include "sim/stepping/advance.h"

#include <string>

#include "sim/contact/overlap.h"
#include "sim/energies/drag.h"
#include "sim/energies/membrane.h"
#include "sim/scene/schema.h"
#include "sim/stepping/implicit_euler.h"
#include "sim/stepping/implicit_midpoint.h"
#include "sim/stepping/linearly_implicit_euler.h"
#include "sim/stepping/total_energy.h"
#include "sim/stepping/tr_bdf2.h"

namespace cloth {
namespace {

bool step_once(Step& step) {
    switch (step.state.integrator) {
        case IntegratorKind::linearly_implicit_euler:
            return step_linearly_implicit_euler(step);
        case IntegratorKind::implicit_euler:
            return step_implicit_euler(step);
        case IntegratorKind::tr_bdf2:
            return step_tr_bdf2(step);
        case IntegratorKind::implicit_midpoint:
            return step_implicit_midpoint(step);
    }
    return false;
}

/// What the longer steps around one were held up by: the same thing again and again.
struct HeldUp {
    std::optional<Obstacle> by;
    int times = 0;

    HeldUp again(const Model& model, const std::optional<Obstacle>& obstacle) const {
        const bool same = by && obstacle && same_obstacle(model, *by, *obstacle);
        return {obstacle, same ? times + 1 : 1};
    }
    /// Shorter steps would not help either.
    bool for_good() const { return by && (by->certain || times >= 4); }
};

/// One step of any length, in two halves where it does not converge.
bool step_by(const Model& model, State& state, double dt, int halvings, const HeldUp& before, Workspace& w,
             StepReport& report) {
    if (w.newton.stopping()) return false;
    std::vector<Pin> pins = pins_of_step(model.pin_groups, state.time, state.time + dt);
    add_holds(pins, w.holds, state.time + dt);
    w.leave_out(pins);
    StepReport attempt;
    Step step{model, state, dt, pins, w, attempt};
    if (step_once(step)) {
        merge(report, attempt);
        state.time += dt;
        return true;
    }
    if (attempt.obstacle) attempt.obstacle->time = state.time + dt;
    const HeldUp held_up = attempt.placed ? HeldUp() : before.again(model, attempt.obstacle);
    if (halvings == 0 || held_up.for_good() || w.newton.stopping()) {
        merge(report, attempt);
        return false;
    }
    merge_work(report, attempt);
    ++report.retries;
    return step_by(model, state, 0.5 * dt, halvings - 1, held_up, w, report) &&
           step_by(model, state, 0.5 * dt, halvings - 1, held_up, w, report);
}

/// Gives what was switched on, for who finds that it overlaps: " at 0.5 s, where an event switches …".
std::string apply_events(const Model& model, State& state) {
    std::string switched_on;
    const auto& events = model.scene.events;
    constexpr double slack = 1e-9;  // an event at 0.3 meets the step that starts at 0.29999999999999998
    while (state.events_done < events.size() && events[state.events_done].time <= state.time + slack) {
        const EventDesc& event = events[state.events_done++];
        if (event.collider) {
            auto& on = state.collider_on[*event.collider];
            on = event.action == Switch::toggle ? !on : event.action == Switch::on;
            if (on) {
                switched_on += (switched_on.empty() ? " at " + number_text(event.time) +
                                                          " s, where an event switches collider "
                                                    : " and ") +
                               model.scene.colliders[*event.collider].name + " on";
            }
        }
        if (event.integrator) state.integrator = *event.integrator;
        if (event.toggle_integrator) {
            state.integrator = state.integrator == IntegratorKind::implicit_euler
                                   ? IntegratorKind::linearly_implicit_euler
                                   : IntegratorKind::implicit_euler;
        }
    }
    return switched_on;
}

}  // namespace

StepReport advance(const Model& model, State& state, Workspace& w) {
    std::string occasion = apply_events(model, state);
    if (occasion.empty() && state.step > 0) occasion = " at " + number_text(state.time) + " s";
    update_drags(model.scene.drags, state.time, state.positions, model.triangles, state.drags);

    if (w.terms.contact() && w.checked != state.collider_on) {
        w.terms.begin({{{1.0, state.positions}}, model.time_step, state.time, state});
        require_no_overlap(model, *w.terms.contact(), state.positions, occasion);
        w.checked = state.collider_on;
    }

    StepReport report;
    report.energy_before = kinetic_energy(model, state) + w.terms.stored(state);
    const State before = state;
    report.converged = step_by(model, state, model.time_step, model.scene.simulation.retries, {}, w, report);
    if (!report.converged) {
        report.stopped = w.newton.stopping();
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
    w.terms.finish(state);
    report.energy_after = kinetic_energy(model, state) + w.terms.stored(state);
    report.largest_stretch = largest_stretch(model.triangles, model.triangle_rest, state.positions);
    return report;
}

}  // namespace cloth
