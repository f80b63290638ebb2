#include "pipeline/sweep/measures.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "sim/fields/shadow.h"

namespace cloth::pipeline {
namespace {

constexpr double none = std::numeric_limits<double>::quiet_NaN();

double flat_area(const MeasuredRun& run) {
    const Points& rest = run.topology.rest_positions;
    return surface_area(Eigen::Map<const VecX>(rest.data(), rest.size()), run.topology.triangles);
}

/// To a thousandth of the cloth's diameter: a share of about 1e-4 of the area.
double shadow(const MeasuredRun& run) {
    const double cell = 1e-3 * std::sqrt(flat_area(run));
    return shadow_area(run.last.positions, run.topology.triangles, cell);
}

double drape(const MeasuredRun& run) {
    const double pedestal = std::numbers::pi * run.pedestal_radius * run.pedestal_radius;
    return drape_coefficient(shadow(run), pedestal, flat_area(run));
}

double greatest_stretch(const MeasuredRun& run) {
    double greatest = none;
    for (const FrameRecord& record : run.records)
        if (record.report.frame > 0) greatest = std::fmax(greatest, record.report.largest_stretch);
    return greatest;
}

double lowest_point(const MeasuredRun& run) {
    double lowest = none;
    for (Eigen::Index v = 0; v < run.last.positions.size() / 3; ++v)
        lowest = std::fmin(lowest, run.last.positions(3 * v + 1));
    return lowest;
}

double energy(const MeasuredRun& run) {
    return run.records.empty() || run.records.back().report.frame == 0
               ? none
               : run.records.back().report.energy_after;
}

double seconds(const MeasuredRun& run) {
    double sum = 0;
    for (const FrameRecord& record : run.records) sum += record.simulate;
    return sum;
}

}  // namespace

const std::vector<Measure>& measures() {
    static const std::vector<Measure> all{
        {"drape_coefficient", "%",
         "share of the overhanging cloth that its shadow keeps at the end, beyond pedestal_radius", drape},
        {"greatest_stretch", "", "greatest principal stretch of any triangle in any frame", greatest_stretch},
        {"lowest_point", "m", "y of the lowest vertex at the end", lowest_point},
        {"energy", "J", "kinetic and potential, at the end", energy},
        {"shadow_area", "m²", "of the shadow under light from straight above, at the end", shadow},
        {"seconds", "s", "that simulating took", seconds},
    };
    return all;
}

}  // namespace cloth::pipeline
