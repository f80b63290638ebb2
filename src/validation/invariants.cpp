// What must hold whatever the scene: momentum, energy, order in time, independence of the mesh, rest.

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "sim/scene/fabrics.h"
#include "sim/simulation.h"
#include "sim/stepping/total_energy.h"
#include "validation/strip.h"
#include "validation/validation.h"

namespace cloth::validation {
namespace {

struct Named {
    IntegratorKind kind;
    const char* name;
};
constexpr Named euler{IntegratorKind::implicit_euler, "implicit Euler"};
constexpr Named tr_bdf2{IntegratorKind::tr_bdf2, "TR-BDF2"};
constexpr Named midpoint{IntegratorKind::implicit_midpoint, "implicit midpoint"};

Vec3 linear_momentum(const Simulation& simulation, Vec3* angular = nullptr) {
    const Model& model = simulation.model();
    const State& state = simulation.state();
    VecX p;
    multiply(model.pattern, model.mass, state.velocities, p);
    Vec3 sum = Vec3::Zero();
    if (angular) angular->setZero();
    for (int v = 0; v < model.vertex_count(); ++v) {
        sum += p.segment<3>(3 * v);
        if (angular) *angular += Vec3(state.positions.segment<3>(3 * v)).cross(Vec3(p.segment<3>(3 * v)));
    }
    return sum;
}

/// A soft sheet of a quarter metre with bending, in free space.
Scene soft_sheet(int resolution) {
    Scene scene = contact_free_scene();
    ClothDesc cloth;
    cloth.grid = {.size = {0.25, 0.25}, .resolution = {resolution, resolution}};
    cloth.fabric = {
        .density = 0.2, .thickness = 1.0, .young_modulus = 50.0, .poisson_ratio = 0.3, .bending = 1e-4};
    scene.cloths.push_back(cloth);
    scene.simulation.gravity.setZero();
    scene.simulation.newton_tolerance = 1e-11;
    return scene;
}

/// Half a metre of cotton, `cells` squares a side, hung up at two places: the upper left corner and `second`.
Scene hanging_cotton(int cells, Diagonals diagonals, const Vec3& second) {
    Scene scene = contact_free_scene();
    ClothDesc cloth;
    cloth.grid = {.size = {0.5, 0.5}, .resolution = {cells + 1, cells + 1}, .diagonals = diagonals};
    cloth.fabric = find_fabric("cotton")->fabric;
    cloth.bump = 0.01;
    scene.cloths.push_back(cloth);
    for (const Vec3& place : {Vec3(-0.25, 0.25, 0.0), second}) {
        PinDesc pin;
        pin.nearest = place;
        scene.pins.push_back(pin);
    }
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    return scene;
}

/// A turn about an oblique axis and a smooth wobble.
void set_spinning(Simulation& simulation) {
    State state = simulation.state();
    for (int v = 0; v < simulation.model().vertex_count(); ++v) {
        const Vec3 x = state.positions.segment<3>(3 * v);
        state.velocities.segment<3>(3 * v) =
            Vec3(0.3, -0.2, 0.1) + Vec3(1.0, 2.0, 3.0).cross(x) +
            Vec3(0.0, 0.2 * x.y(), 0.5 * std::cos(12.0 * x.x()) * std::sin(9.0 * x.y() + 0.5));
    }
    simulation.restore(state);
}

}  // namespace

Outcome check_momentum(const Parameters& parameters) {
    Outcome outcome;
    for (const Named& scheme : {euler, tr_bdf2, midpoint}) {
        Scene scene = soft_sheet(parameters.resolution.value_or(9) + 1);
        scene.simulation.integrator = scheme.kind;
        scene.simulation.frame_rate = 200.0;
        Simulation simulation(scene);
        set_spinning(simulation);
        Vec3 L0, L1;
        const Vec3 p0 = linear_momentum(simulation, &L0);
        for (int i = 0; i < 200; ++i) run_frame(simulation);
        const Vec3 p1 = linear_momentum(simulation, &L1);
        outcome.findings.push_back({"momentum", fmt::format("linear, change over 200 steps, {}", scheme.name),
                                    (p1 - p0).norm() / p0.norm(), 0.0, 1e-11, "of its size",
                                    "Newton's third law"});
        if (scheme.kind == IntegratorKind::implicit_midpoint) {
            outcome.findings.push_back(
                {"momentum", fmt::format("angular, change over 200 steps, {}", scheme.name),
                 (L1 - L0).norm() / L0.norm(), 0.0, 1e-9, "of its size", "conserved by the midpoint rule"});
        } else {
            const bool first = scheme.kind == IntegratorKind::implicit_euler;
            outcome.findings.push_back(
                {"momentum", fmt::format("angular, change over 1 s in 200 steps, {}", scheme.name),
                 (L1 - L0).norm() / L0.norm(), 0.0, first ? 0.1 : 2e-3, "of its size",
                 first ? "stated bound, first order in the step" : "stated bound, second order in the step"});
        }
    }
    return outcome;
}

Outcome check_energy(const Parameters& parameters) {
    Outcome outcome;
    Plot plot{"energy", "A swinging sheet's energy", "time [s]", "share of the start's", false, false, {}};
    for (const Named& scheme : {euler, tr_bdf2, midpoint}) {
        Scene scene = soft_sheet(parameters.resolution.value_or(9) + 1);
        scene.simulation.gravity = Vec3(0.0, -9.81, 0.0);
        scene.simulation.integrator = scheme.kind;
        scene.simulation.frame_rate = 240.0;
        PinDesc pin;
        pin.edge = "top";
        scene.pins.push_back(pin);
        // At rest first: energies are counted from there.
        Scene still = scene;
        still.simulation.integrator = IntegratorKind::implicit_euler;
        still.simulation.frame_rate = 2.0;
        still.simulation.newton_tolerance = 1e-8;
        Simulation hanging(still);
        for (int i = 0; i < 60; ++i) run_frame(hanging);
        const double lowest = total_energy(hanging.model(), hanging.state());

        Simulation simulation(scene);
        State state = simulation.state();
        state.positions = hanging.state().positions;
        for (int v = 0; v < simulation.model().vertex_count(); ++v) {
            const double depth = 0.125 - state.positions(3 * v + 1);
            state.velocities(3 * v + 2) = 2.0 * depth;
        }
        for (int v : simulation.model().pinned) state.velocities.segment<3>(3 * v).setZero();
        simulation.restore(state);
        const double start = total_energy(simulation.model(), simulation.state()) - lowest;
        double rise = 0.0, before = start, greatest = start, least = start;
        Curve curve{scheme.name, {{0.0, 1.0}}};
        for (int i = 1; i <= 1200; ++i) {
            run_frame(simulation);
            const double now = total_energy(simulation.model(), simulation.state()) - lowest;
            rise = std::max(rise, now - before);
            greatest = std::max(greatest, now);
            least = std::min(least, now);
            before = now;
            if (i % 4 == 0) curve.points.push_back({i / 240.0, now / start});
        }
        plot.curves.push_back(curve);
        if (scheme.kind == IntegratorKind::implicit_euler) {
            outcome.findings.push_back({"energy", "largest rise in a step, implicit Euler",
                                        std::max(rise, 0.0) / start, 0.0, 1e-7, "of the start's",
                                        "dissipative at every step"});
        } else {
            const bool symmetric = scheme.kind == IntegratorKind::implicit_midpoint;
            outcome.findings.push_back({"energy", fmt::format("rise above the start in 5 s, {}", scheme.name),
                                        greatest / start - 1.0, 0.0, symmetric ? 1e-3 : 1e-6,
                                        "of the start's", "stated bound"});
            outcome.findings.push_back({"energy", fmt::format("loss in 5 s, {}", scheme.name),
                                        1.0 - before / start, 0.0, symmetric ? 1e-3 : 0.01, "of the start's",
                                        "stated bound"});
        }
    }
    outcome.plots.push_back(plot);
    return outcome;
}

Outcome check_time_order(const Parameters& parameters) {
    constexpr double duration = 0.25;
    auto end = [&](IntegratorKind kind, int steps) {
        Scene scene = soft_sheet(parameters.resolution.value_or(7) + 1);
        scene.cloths[0].fabric.young_modulus = 2.0;  // its waves last as long as the run
        scene.simulation.integrator = kind;
        scene.simulation.frame_rate = steps / duration;
        Simulation simulation(scene);
        set_spinning(simulation);
        for (int i = 0; i < steps; ++i) run_frame(simulation);
        return simulation.state().positions;
    };
    const VecX exact = end(IntegratorKind::implicit_midpoint, 5120);
    Outcome outcome;
    Plot plot{"time_order", "Error after 0.25 s against the step", "step [s]", "error [m]", true, true, {}};
    for (const Named& scheme : {euler, tr_bdf2, midpoint}) {
        const int order = scheme.kind == IntegratorKind::implicit_euler ? 1 : 2;
        std::vector<double> errors;
        Curve curve{scheme.name, {}};
        for (int steps : {160, 320, 640}) {
            errors.push_back((end(scheme.kind, steps) - exact).norm() /
                             std::sqrt(static_cast<double>(exact.size()) / 3.0));
            curve.points.push_back({duration / steps, errors.back()});
        }
        plot.curves.push_back(curve);
        outcome.findings.push_back({"time_order", fmt::format("order, {}", scheme.name),
                                    std::log2(errors[1] / errors[2]), static_cast<double>(order), 0.15, "",
                                    "Taylor expansion"});
    }
    outcome.plots.push_back(plot);
    return outcome;
}

Outcome check_diagonals(const Parameters& parameters) {
    auto hanging = [&](Diagonals diagonals) {
        // Lopsided, so that the two directions are not each other's mirror image.
        Scene scene = hanging_cotton(parameters.resolution.value_or(40), diagonals, Vec3(0.1, 0.25, 0.0));
        scene.simulation.frame_rate = 20.0;
        scene.simulation.newton_tolerance = 1e-5;
        Simulation simulation(scene);
        for (int i = 0; i < 100; ++i) run_frame(simulation);
        const State& state = simulation.state();
        double height = 0.0;
        for (int v = 0; v < simulation.model().vertex_count(); ++v) height += state.positions(3 * v + 1);
        return height / simulation.model().vertex_count();
    };
    const double uniform = hanging(Diagonals::uniform);
    Outcome outcome;
    outcome.findings.push_back({"diagonals", "mean height, other diagonals", hanging(Diagonals::mirrored),
                                uniform, 0.005, "m", "diagonals in one direction; 1 % of the side"});
    outcome.findings.push_back({"diagonals", "mean height, alternating diagonals",
                                hanging(Diagonals::alternating), uniform, 0.005, "m",
                                "diagonals in one direction; 1 % of the side"});
    return outcome;
}

Outcome check_rest(const Parameters& parameters) {
    Scene scene =
        hanging_cotton(parameters.resolution.value_or(20), Diagonals::uniform, Vec3(0.25, 0.25, 0.0));
    scene.simulation.frame_rate = 60.0;
    Simulation simulation(scene);
    double worst = 0.0;
    VecX settled;
    for (int i = 1; i <= 10000; ++i) {
        run_frame(simulation);
        if (i == 3000) settled = simulation.state().positions;
        if (i > 3000) worst = std::max(worst, kinetic_energy(simulation.model(), simulation.state()));
    }
    const double way = (simulation.state().positions - settled).cwiseAbs().maxCoeff();
    return {.findings = {{"rest", "kinetic energy, steps 3000 to 10000 of 1/60 s", worst, 0.0, 1e-8, "J",
                          "a sheet at rest stays at rest"},
                         {"rest", "farthest way of a vertex in them", way, 0.0, 1e-4, "m",
                          "a sheet at rest stays at rest"}}};
}

}  // namespace cloth::validation
