// Bending: the cantilever's shape, lateral buckling, vibration, and order in space.

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/simulation.h"
#include "validation/elastica.h"
#include "validation/strip.h"
#include "validation/validation.h"

namespace cloth::validation {
namespace {

/// One metre long, one kilogram per square metre, g = 1 m/s²: Γ = 1/D.
Scene cantilever_scene(double gamma, int cells, double grading, double stiffness) {
    constexpr int across = 2;
    const auto columns = clamped_columns(1.0, cells, grading);
    Scene scene = contact_free_scene();
    ClothDesc cloth;
    cloth.mesh = make_strip(columns, 0.1, across, -Vec3::UnitZ());
    cloth.fabric = {.density = 1.0,
                    .thickness = 1.0,
                    .young_modulus = stiffness,
                    .poisson_ratio = 0.0,
                    .bending = 1.0 / gamma};
    scene.cloths.push_back(cloth);
    PinDesc pin;
    pin.vertices = column_vertices(cells + 1, across + 1, 0, 1);
    scene.pins.push_back(pin);
    scene.simulation.gravity = Vec3(0.0, -1.0, 0.0);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.frame_rate = 1.0;  // steps of a second: implicit Euler's dissipation brings it to rest
    scene.simulation.newton_iterations = 200;
    scene.simulation.newton_tolerance = 1e-7;
    scene.simulation.retries = 8;
    return scene;
}

/// H/W of the tip at rest.
double simulated_cantilever(double gamma, int cells, double stiffness) {
    // The curvature lives within L/√Γ of the clamp.
    const double grading = gamma > 50.0 ? 20.0 : 1.0;
    Simulation simulation(cantilever_scene(gamma, cells, grading, stiffness));
    settle(simulation, 1e-14, 400);
    const Vec3 tip = column_position(simulation, cells + 1, 3, cells);
    return -tip.y() / tip.x();
}

}  // namespace

Outcome check_cantilever(const Parameters& parameters) {
    const int cells = parameters.resolution.value_or(80);
    std::vector<double> gammas;
    if (parameters.gamma) {
        gammas.push_back(*parameters.gamma);
    } else {
        for (int i = 0; i < 13; ++i) gammas.push_back(0.1 * std::pow(10.0, 5.0 * i / 12.0));
    }
    Outcome outcome;
    Curve points{"simulated", {}, true}, curve{"heavy elastica", {}};
    for (double gamma : gammas) {
        const Elastica exact = heavy_elastica(gamma);
        const double expected = exact.drop / exact.span;
        const double measured = simulated_cantilever(gamma, cells, 2000.0);
        outcome.findings.push_back({"cantilever", fmt::format("H/W at Gamma {:.5g}", gamma), measured,
                                    expected, 0.02 * expected, "",
                                    "heavy elastica (Romero et al. 2021's protocol)"});
        points.points.push_back({gamma, measured});
    }
    if (!parameters.gamma) {
        for (double e = -1.0; e <= 4.001; e += 0.1) {
            const Elastica exact = heavy_elastica(std::pow(10.0, e));
            curve.points.push_back({std::pow(10.0, e), exact.drop / exact.span});
        }
        outcome.plots.push_back({"cantilever",
                                 "Cantilever under its own weight",
                                 "Γ = ρ g L³ / D",
                                 "drop / span of the tip, H/W",
                                 true,
                                 true,
                                 {curve, points}});
    }
    return outcome;
}

Outcome check_space_order(const Parameters&) {
    // A moderate load and a stiff membrane, so that bending's error is what remains.
    constexpr double gamma = 4.0;
    const Elastica exact = heavy_elastica(gamma);
    const double expected = exact.drop / exact.span;
    Curve curve{"simulated", {}, true};
    std::vector<double> errors;
    for (int cells : {10, 20, 40}) {
        errors.push_back(std::abs(simulated_cantilever(gamma, cells, 1e5) - expected) / expected);
        curve.points.push_back({static_cast<double>(cells), errors.back()});
    }
    Outcome outcome;
    outcome.findings.push_back({"space_order", "order of H/W's error, 10 to 40 cells",
                                0.5 * std::log2(errors.front() / errors.back()), 2.0, 0.3, "",
                                "second differences"});
    outcome.findings.push_back({"space_order", "error falls from 20 to 40 cells by", errors[1] / errors[2],
                                4.0, 1.5, "", "second differences"});
    outcome.plots.push_back({"space_order",
                             "Cantilever, Γ = 4: error under refinement",
                             "cells along the strip",
                             "relative error of H/W",
                             true,
                             true,
                             {curve}});
    return outcome;
}

Outcome check_lateral_buckling(const Parameters& parameters) {
    constexpr double width = 0.1, D = 1e-3;
    constexpr int across = 6;
    const int cells = parameters.resolution.value_or(60);
    const double critical = lateral_buckling_load(width);
    Outcome outcome;
    for (double load : {0.95, 1.05}) {
        // w L³ / √(B C) with w = ρ g b, B = D b, C = 2 D b.
        const double density = 1.0, g = load * critical * std::numbers::sqrt2 * D / density;
        Scene scene = contact_free_scene();
        ClothDesc cloth;
        cloth.mesh = make_strip(clamped_columns(1.0, cells, 1.0), width, across, Vec3::UnitY());
        cloth.fabric = {.density = density,
                        .thickness = 1.0,
                        .young_modulus = 1e6 * D / (width * width),
                        .poisson_ratio = 0.0,
                        .bending = D};
        // A push to the side, to be forgotten or to grow.
        cloth.velocity = Vec3(0.0, 0.0, 1e-6);
        scene.cloths.push_back(cloth);
        PinDesc pin;
        pin.vertices = column_vertices(cells + 1, across + 1, 0, 1);
        scene.pins.push_back(pin);
        scene.simulation.gravity = Vec3(0.0, -g, 0.0);
        scene.simulation.integrator = IntegratorKind::implicit_euler;
        // The first mode's time is about 2π/3.5 √(ρ/D) s; the slow growth just above the load needs its
        // 1/√0.05.
        scene.simulation.frame_rate = 0.2;
        scene.simulation.newton_iterations = 200;
        scene.simulation.newton_tolerance = 1e-7;
        Simulation simulation(scene);
        for (int frame = 0; frame < 400; ++frame) run_frame(simulation);
        const double aside = std::abs(column_position(simulation, cells + 1, across + 1, cells).z());
        const std::string source = fmt::format("critical load {:.3f} (12.85 for a narrow strip)", critical);
        if (load < 1.0) {
            outcome.findings.push_back(
                {"lateral_buckling", "tip's way aside at 0.95 of the load", aside, 0.0, 1e-4, "m", source});
        } else {
            outcome.findings.push_back(
                {"lateral_buckling", "tip's way aside at 1.05 of the load", aside, 0.4, 0.39, "m", source});
        }
    }
    return outcome;
}

Outcome check_vibration(const Parameters& parameters) {
    constexpr double density = 0.2, D = 1e-4, length = 0.5, width = 0.05;
    constexpr int across = 2;
    const int cells = parameters.resolution.value_or(60);
    Outcome outcome;
    // Roots of cos β cosh β = -1.
    const double roots[] = {1.8751040687, 4.6940911330, 7.8547574382};
    for (int mode = 0; mode < 3; ++mode) {
        const double beta = roots[mode];
        const double frequency =
            beta * beta / (2.0 * std::numbers::pi) * std::sqrt(D / density) / (length * length);
        Scene scene = contact_free_scene();
        ClothDesc cloth;
        const auto columns = clamped_columns(length, cells, 1.0);
        cloth.mesh = make_strip(columns, width, across, -Vec3::UnitZ());
        cloth.fabric = {
            .density = density, .thickness = 1.0, .young_modulus = 500.0, .poisson_ratio = 0.0, .bending = D};
        scene.cloths.push_back(cloth);
        PinDesc pin;
        pin.vertices = column_vertices(cells + 1, across + 1, 0, 1);
        scene.pins.push_back(pin);
        scene.simulation.gravity.setZero();
        scene.simulation.integrator = IntegratorKind::tr_bdf2;
        const double dt = 1.0 / (80.0 * frequency);
        scene.simulation.frame_rate = 1.0 / dt;
        Simulation simulation(scene);
        // The mode's own shape as start velocity, small.
        State state = simulation.state();
        const double sigma = (std::cosh(beta) + std::cos(beta)) / (std::sinh(beta) + std::sin(beta));
        for (int j = 0; j <= across; ++j) {
            for (int i = 2; i <= cells; ++i) {
                const double x = beta * columns[i] / length;
                const double shape = std::cosh(x) - std::cos(x) - sigma * (std::sinh(x) - std::sin(x));
                state.velocities(3 * (j * (cells + 1) + i) + 1) = 1e-3 * length * frequency * shape;
            }
        }
        simulation.restore(state);
        std::vector<double> tip;
        for (int frame = 0; frame < 400; ++frame) {
            run_frame(simulation);
            tip.push_back(column_position(simulation, cells + 1, across + 1, cells).y());
        }
        outcome.findings.push_back({"vibration", fmt::format("frequency of mode {}", mode + 1),
                                    1.0 / mean_period(tip, dt), frequency, 0.02 * frequency, "Hz",
                                    "Euler-Bernoulli beam, cos(b) cosh(b) = -1"});
    }
    return outcome;
}

}  // namespace cloth::validation
