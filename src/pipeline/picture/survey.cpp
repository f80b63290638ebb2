#include "pipeline/picture/survey.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/stepping/total_energy.h"

namespace cloth::pipeline {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr std::size_t most_samples = 2'000'000;

/// What the reports tell for a curve; NaN where they tell nothing. Frame 0 was not stepped to: its energy is
/// that before frame 1.
double reported(const FrameReports& reports, std::int64_t frame, Curve curve) {
    const bool start = frame == 0;
    const auto found = reports.find(start ? 1 : frame);
    if (found == reports.end()) return nan;
    const FrameReport& report = found->second;
    if (start) return curve == Curve::energy ? report.energy_before : nan;
    switch (curve) {
        case Curve::energy:
            return report.energy_after;
        case Curve::stretch:
            return report.largest_stretch;
        case Curve::gap:
            return std::isfinite(report.smallest_gap) ? report.smallest_gap : nan;
        case Curve::iterations:
            return report.iterations;
        case Curve::contacts:
            return report.contacts;
        case Curve::kinetic:
            break;
    }
    return nan;
}

double least(const VecX& values) {
    double smallest = nan;
    for (const double v : values)
        if (!(smallest <= v)) smallest = v;
    return smallest;
}

}  // namespace

ShadeRange shade_range(VertexField field, std::vector<double> values, double diagonal) {
    std::erase_if(values, [](double v) { return !std::isfinite(v); });
    ShadeRange range;
    if (values.empty()) return range;
    const auto [least_value, greatest_value] = std::minmax_element(values.begin(), values.end());
    const double smallest = *least_value, greatest = *greatest_value;
    const auto quantile = [&](double share) {
        const auto place = values.begin() +
                           static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
        std::nth_element(values.begin(), place, values.end());
        return *place;
    };
    double low = quantile(0.005), high = quantile(0.995);
    const bool not_negative =
        field == VertexField::bending || field == VertexField::kinetic || field == VertexField::strain_rate;
    if (not_negative) low = 0.0;
    if (field == VertexField::gap) high = std::min(high, low + 0.05 * diagonal);
    const double floor_width = std::max(1e-4 * std::abs(high), 1e-9);
    if (high - low < floor_width) high = low + floor_width;
    const auto places = ticks(low, high, 6);
    const double step = places.size() > 1 ? places[1] - places[0] : high - low;
    range.low = step * std::floor(low / step + 1e-6);
    range.high = step * std::ceil(high / step - 1e-6);
    range.below = smallest < range.low - 1e-6 * step;
    range.above = greatest > range.high + 1e-6 * step;
    return range;
}

bool needs_whole_run(const SceneFile& file) {
    const AnnotationDesc& a = file.annotation;
    return file.camera.framing == Framing::automatic || (a.shade && !a.shade_range) || !a.curves.empty() ||
           a.motion_blur > 1;
}

RunFacts facts_of(const SceneFile& file) {
    RunFacts facts;
    if (file.annotation.shade && file.annotation.shade_range) {
        const auto [low, high] = *file.annotation.shade_range;
        facts.shade = {low, high, true, true};
    }
    return facts;
}

RunFacts survey(const SimulatedRun& run, const SceneFile& file, const Model& model,
                const std::atomic<bool>* stop) {
    RunFacts facts = facts_of(file);
    const AnnotationDesc& wanted = file.annotation;
    const bool range_wanted = wanted.shade && !facts.shade;
    if (!range_wanted && wanted.curves.empty() && file.camera.framing != Framing::automatic) return facts;

    const std::vector<std::int64_t>& frames = run.frames;
    const VertexFields fields(model);
    Extent extent(file.camera, static_cast<double>(file.view.width) / file.view.height);
    for (const Curve curve : wanted.curves)
        facts.curves.push_back({curve_names[static_cast<std::size_t>(curve)].title, {}});
    std::vector<double> values;
    const std::size_t all = frames.size() * static_cast<std::size_t>(model.vertex_count());
    const auto stride = static_cast<int>(1 + all / most_samples);
    for (std::size_t k = 0; k < frames.size(); ++k) {
        if (stop != nullptr && stop->load()) break;
        const State state = run.read(frames[k]).value();
        for (int i = 0; i < model.vertex_count(); ++i) extent.add(state.positions.segment<3>(3 * i));
        if (range_wanted) {
            const VecX field = fields.at(*wanted.shade, state);
            for (int i = static_cast<int>(k) % stride; i < field.size(); i += stride)
                values.push_back(field(i));
        }
        if (wanted.curves.empty()) continue;
        facts.times.push_back(state.time);
        for (std::size_t c = 0; c < wanted.curves.size(); ++c) {
            const Curve curve = wanted.curves[c];
            double value = reported(run.reports, frames[k], curve);
            if (curve == Curve::kinetic) value = kinetic_energy(model, state);
            // Between cloths the step's own contact knows; NaN gives way.
            if (curve == Curve::gap)
                value = 1e3 * std::fmin(least(fields.at(VertexField::gap, state)), value);
            facts.curves[c].values.push_back(value);
        }
    }
    if (range_wanted) facts.shade = shade_range(*wanted.shade, std::move(values), extent.diagonal());
    if (file.camera.framing == Framing::automatic) facts.extent = extent;
    return facts;
}

void share(RunFacts& a, RunFacts& b) {
    if (a.shade && b.shade) {
        ShadeRange& s = *a.shade;
        const ShadeRange& t = *b.shade;
        s = {std::min(s.low, t.low), std::max(s.high, t.high), s.low < t.low ? s.below : t.below,
             s.high > t.high ? s.above : t.above};
        b.shade = s;
    }
    if (a.extent && b.extent) {
        a.extent->add(*b.extent);
        b.extent = a.extent;
    }
}

}  // namespace cloth::pipeline
