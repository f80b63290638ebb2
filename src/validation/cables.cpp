// Tension: catenary, stretch under own weight, pendulum, wave speed.

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/simulation.h"
#include "validation/strip.h"
#include "validation/validation.h"

namespace cloth::validation {
namespace {

constexpr double g = 9.81;
constexpr int across = 1;

/// A strip without bending stiffness or Poisson's ratio.
ClothDesc strip(const std::vector<double>& columns, double width, double density, double stiffness) {
    ClothDesc cloth;
    cloth.mesh = make_strip(columns, width, across, -Vec3::UnitZ());
    cloth.fabric = {.density = density, .thickness = 1.0, .young_modulus = stiffness, .poisson_ratio = 0.0};
    return cloth;
}

/// Turned to hang from x = 0 downwards.
Points hanging(const MeshData& mesh) {
    Points pose = mesh.positions;
    pose.col(1) = -mesh.positions.col(0);
    pose.col(0).setZero();
    return pose;
}

PinDesc hold(std::vector<int> vertices) {
    PinDesc pin;
    pin.vertices = std::move(vertices);
    return pin;
}

}  // namespace

Outcome check_catenary(const Parameters& parameters) {
    const int cells = parameters.resolution.value_or(64);
    constexpr double length = 1.25, span = 1.0, width = 0.02, density = 0.15;
    // 2 a sinh(span / 2a) = length
    double low = 0.05, high = 10.0;
    for (int i = 0; i < 200; ++i) {
        const double a = 0.5 * (low + high);
        (2.0 * a * std::sinh(span / (2.0 * a)) > length ? low : high) = a;
    }
    const double a = 0.5 * (low + high);
    const double sag = a * (std::cosh(span / (2.0 * a)) - 1.0);
    const double tension = density * g * width * a * std::cosh(span / (2.0 * a));  // at the ends

    Scene scene = contact_free_scene();
    const auto columns = even_columns(length, cells);
    ClothDesc cloth = strip(columns, width, density, 1e5 * density * g);
    // Held at the span's ends; in between a parabola to start from, near enough not to be stretched.
    Points pose = cloth.mesh->positions;
    for (int v = 0; v < pose.rows(); ++v) {
        const double s = columns[v % (cells + 1)] - 0.5 * length;
        const double x = a * std::asinh(s / a);
        pose(v, 0) = x;
        pose(v, 1) = 1.05 * (a * (std::cosh(x / a) - std::cosh(span / (2.0 * a))));
    }
    cloth.pose = pose;
    scene.cloths.push_back(cloth);
    auto ends = column_vertices(cells + 1, across + 1, 0, 0);
    for (int v : column_vertices(cells + 1, across + 1, cells, cells)) ends.push_back(v);
    scene.pins.push_back(hold(ends));
    scene.simulation.gravity = Vec3(0.0, -g, 0.0);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.frame_rate = 5.0;
    scene.simulation.newton_iterations = 200;
    Simulation simulation(scene);
    settle(simulation, 1e-14, 400);

    // What the pins hold: the elastic forces on them, half a cell's weight apart.
    VecX gradient = VecX::Zero(simulation.state().positions.size());
    for (const auto& energy : simulation.model().energies) {
        energy->add_gradient(simulation.state().positions, gradient);
    }
    Vec3 pull = Vec3::Zero();
    for (int v : column_vertices(cells + 1, across + 1, 0, 0)) pull += gradient.segment<3>(3 * v);
    const double lowest = -column_position(simulation, cells + 1, across + 1, cells / 2).y();
    return {
        .findings = {{"catenary", "sag at the middle", lowest, sag, 0.005 * sag, "m", "a (cosh(s/2a) - 1)"},
                     {"catenary", "tension at the ends", pull.norm(), tension, 0.01 * tension, "N",
                      "w a cosh(s/2a)"}}};
}

Outcome check_own_weight(const Parameters& parameters) {
    const int cells = parameters.resolution.value_or(40);
    constexpr double length = 1.0, density = 0.2, stiffness = 100.0;
    const double expected = density * g * length * length / (2.0 * stiffness);
    Outcome outcome;
    for (MembraneKind kind :
         {MembraneKind::corotational, MembraneKind::neo_hookean, MembraneKind::st_venant_kirchhoff}) {
        Scene scene = contact_free_scene();
        ClothDesc cloth = strip(even_columns(length, cells), 0.1, density, stiffness);
        cloth.fabric.membrane = kind;
        // The laws agree at small strain: a stiff one is loaded a thousand times as lightly.
        const double scale = kind == MembraneKind::corotational ? 1.0 : 1e-3;
        cloth.pose = hanging(*cloth.mesh);
        scene.cloths.push_back(cloth);
        scene.pins.push_back(hold(column_vertices(cells + 1, across + 1, 0, 0)));
        scene.simulation.gravity = Vec3(0.0, -g * scale, 0.0);
        scene.simulation.integrator = IntegratorKind::implicit_euler;
        scene.simulation.frame_rate = 2.0;
        Simulation simulation(scene);
        settle(simulation, 1e-22, 200);
        const double longer = -column_position(simulation, cells + 1, across + 1, cells).y() - length;
        const char* name = kind == MembraneKind::corotational  ? "co-rotational"
                           : kind == MembraneKind::neo_hookean ? "neo-Hookean"
                                                               : "St. Venant-Kirchhoff";
        outcome.findings.push_back({"own_weight", fmt::format("lengthening, {}", name), longer,
                                    expected * scale, 0.005 * expected * scale, "m", "rho g L^2 / (2 E h)"});
    }
    return outcome;
}

Outcome check_pendulum(const Parameters& parameters) {
    const int cells = parameters.resolution.value_or(50);
    constexpr double length = 1.0, density = 0.15;
    const double expected = 5.2255 * std::sqrt(length / g);
    Scene scene = contact_free_scene();
    ClothDesc cloth = strip(even_columns(length, cells), 0.1, density, 1e4);
    cloth.pose = hanging(*cloth.mesh);
    scene.cloths.push_back(cloth);
    scene.pins.push_back(hold(column_vertices(cells + 1, across + 1, 0, 0)));
    scene.simulation.gravity = Vec3(0.0, -g, 0.0);
    scene.simulation.integrator = IntegratorKind::tr_bdf2;
    const double dt = expected / 60.0;
    scene.simulation.frame_rate = 1.0 / dt;
    Simulation simulation(scene);
    // The first mode's shape, J0(2.4048 √(distance from the free end)), as a small start velocity.
    State state = simulation.state();
    for (int v = 0; v < state.positions.size() / 3; ++v) {
        const double height = 1.0 + state.positions(3 * v + 1) / length;
        state.velocities(3 * v) =
            0.01 * std::cyl_bessel_j(0.0, 2.404825557695773 * std::sqrt(std::max(height, 0.0)));
    }
    for (int v : simulation.model().pinned) state.velocities.segment<3>(3 * v).setZero();
    simulation.restore(state);
    std::vector<double> tip;
    for (int frame = 0; frame < 300; ++frame) {
        run_frame(simulation);
        tip.push_back(column_position(simulation, cells + 1, across + 1, cells).x());
    }
    return {.findings = {{"pendulum", "period of a hanging sheet", mean_period(tip, dt), expected,
                          0.01 * expected, "s", "5.2255 sqrt(L/g), Bernoulli's hanging chain"}}};
}

Outcome check_wave_speed(const Parameters& parameters) {
    const int cells = parameters.resolution.value_or(60);
    constexpr double length = 1.0, density = 0.2, stiffness = 500.0;
    const double expected = std::sqrt(stiffness / density);
    Scene scene = contact_free_scene();
    scene.cloths.push_back(strip(even_columns(length, cells), 0.05, density, stiffness));
    scene.pins.push_back(hold(column_vertices(cells + 1, across + 1, 0, 0)));
    scene.simulation.gravity.setZero();
    scene.simulation.integrator = IntegratorKind::tr_bdf2;
    // A standing wave of a quarter length: period 4 L / c.
    const double dt = 4.0 * length / expected / 80.0;
    scene.simulation.frame_rate = 1.0 / dt;
    Simulation simulation(scene);
    State state = simulation.state();
    for (int v = 0; v < state.positions.size() / 3; ++v) {
        state.velocities(3 * v) =
            1e-4 * expected * std::sin(0.5 * std::numbers::pi * state.positions(3 * v) / length);
    }
    simulation.restore(state);
    std::vector<double> tip;
    for (int frame = 0; frame < 400; ++frame) {
        run_frame(simulation);
        tip.push_back(column_position(simulation, cells + 1, across + 1, cells).x() - length);
    }
    return {.findings = {{"wave_speed", "in-plane wave along a strip", 4.0 * length / mean_period(tip, dt),
                          expected, 0.02 * expected, "m/s", "sqrt(E h / rho_A)"}}};
}

}  // namespace cloth::validation
