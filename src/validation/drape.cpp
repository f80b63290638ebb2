// Cusick's drape test: a disc of 30 cm over a pedestal of 18 cm.

#include <cmath>
#include <numbers>

#include <fmt/format.h>

#include "sim/fields/shadow.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "sim/simulation.h"
#include "validation/strip.h"
#include "validation/validation.h"

namespace cloth::validation {
namespace {

constexpr double disc_radius = 0.15, pedestal_radius = 0.09;

struct Band {
    const char* fabric;
    double low, high;  ///< [%]
};
constexpr Band bands[] = {{"silk", 20, 40}, {"cotton", 60, 76}, {"wool", 40, 70}, {"denim", 70, 90}};

}  // namespace

double cusick_drape_coefficient(const Fabric& fabric, int rings) {
    Scene scene = contact_free_scene();
    ClothDesc cloth;
    cloth.disc = Disc{disc_radius, rings};
    cloth.fabric = fabric;
    cloth.transform.rotate = Vec3(-90.0, 0.0, 0.0);  // level, the warp along -z
    scene.cloths.push_back(cloth);
    // The pedestal holds what lies on it.
    PinDesc pin;
    const Points rest = rest_shape(scene.cloths[0]).positions;
    for (int v = 0; v < rest.rows(); ++v) {
        if (rest.row(v).norm() <= pedestal_radius + 1e-9) pin.vertices.push_back(v);
    }
    scene.pins.push_back(pin);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.frame_rate = 30.0;
    scene.simulation.newton_tolerance = 1e-4;
    Simulation simulation(scene);
    // A faint unevenness, without which a level disc would not know where to fold.
    State state = simulation.state();
    for (int v = 0; v < simulation.model().vertex_count(); ++v) {
        const double x = state.positions(3 * v), z = state.positions(3 * v + 2);
        state.velocities(3 * v + 1) = 0.02 * std::sin(35.0 * x + 1.0) * std::cos(41.0 * z - 0.5);
    }
    for (int v : simulation.model().pinned) state.velocities.segment<3>(3 * v).setZero();
    simulation.restore(state);
    for (int frame = 0; frame < 120; ++frame) run_frame(simulation);
    const double inner = std::numbers::pi * pedestal_radius * pedestal_radius;
    const double outer = std::numbers::pi * disc_radius * disc_radius;
    const double shadow = shadow_area(simulation.state().positions, simulation.model().triangles, 5e-4);
    return drape_coefficient(shadow, inner, outer);
}

Outcome check_drape(const Parameters& parameters) {
    const int rings = parameters.resolution.value_or(30);
    Outcome outcome;
    for (const Band& band : bands) {
        if (parameters.fabric && *parameters.fabric != band.fabric) continue;
        const double measured = cusick_drape_coefficient(find_fabric(band.fabric)->fabric, rings);
        outcome.findings.push_back(
            {"drape", fmt::format("Cusick drape coefficient of {}", band.fabric), measured,
             0.5 * (band.low + band.high), 0.5 * (band.high - band.low), "%",
             fmt::format("measured band {:g} to {:g} % (BS 5058 discs)", band.low, band.high)});
    }
    if (outcome.findings.empty() && parameters.fabric) {
        if (const NamedFabric* fabric = find_fabric(*parameters.fabric)) {
            outcome.findings.push_back({"drape",
                                        fmt::format("Cusick drape coefficient of {}", *parameters.fabric),
                                        cusick_drape_coefficient(fabric->fabric, rings), 50.0, 50.0, "%",
                                        "no measured band; any share of the ring"});
        }
    }
    return outcome;
}

}  // namespace cloth::validation
