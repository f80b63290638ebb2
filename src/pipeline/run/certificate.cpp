#include "pipeline/run/certificate.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "pipeline/formats/file_io.h"
#include "pipeline/run/plan.h"

namespace cloth::pipeline {

namespace {

using Json = nlohmann::ordered_json;

/// How one limit is measured: greater is worse where `most`, else less is.
struct Measure {
    const char *key, *unit;
    bool most;
    std::optional<double> limit;
    std::function<double(const FrameRecord&)> value;
};

/// The one list of them.
std::vector<Measure> measures(const ExpectDesc& e) {
    return {
        {"max_stretch", "", true, e.max_stretch, [](const auto& r) { return r.report.largest_stretch; }},
        {"min_gap", "m", false, e.min_gap, [](const auto& r) { return r.report.smallest_gap; }},
        {"max_residual", "", true, e.max_residual, [](const auto& r) { return r.report.residual; }},
        {"max_energy_rise", "J", true, e.max_energy_rise,
         [](const auto& r) { return r.report.energy_after - r.report.energy_before; }},
        {"all_converged", "retries", true, e.all_converged ? std::optional(0.0) : std::nullopt,
         [](const auto& r) { return r.report.converged ? r.report.retries : 1e9; }},
        {"max_seconds_per_frame", "s", true, e.max_seconds_per_frame,
         [](const auto& r) { return r.simulate; }},
    };
}

std::string value_text(double value, const std::string& unit) {
    return fmt::format("{:.6g}{}{}", value, unit.empty() ? "" : " ", unit);
}

}  // namespace

std::vector<Promise> promises(const ExpectDesc& expect, const std::vector<FrameRecord>& records) {
    std::vector<Promise> all;
    for (const Measure& measure : measures(expect)) {
        if (!measure.limit) continue;
        Promise promise{measure.key, measure.unit, *measure.limit, {}, 0, {}, 0};
        for (const FrameRecord& record : records) {
            if (record.report.frame == 0) continue;  // no step was made
            const double value = measure.value(record);
            if (std::isinf(value) && !measure.most) continue;  // nothing was near
            const auto worse = [&](double than) {
                return measure.most ? !(value <= than) : !(value >= than);
            };
            if (!promise.worst || worse(*promise.worst)) {
                promise.worst = value;
                promise.worst_frame = record.report.frame;
            }
            if (!promise.first_broken && worse(promise.limit)) {
                promise.first_broken = record.report.frame;
                promise.broken_by = value;
            }
        }
        all.push_back(std::move(promise));
    }
    return all;
}

std::string broken_promises(const std::vector<Promise>& promises) {
    std::string text;
    for (const Promise& p : promises) {
        if (!p.first_broken) continue;
        text += fmt::format("{}expect.{} = {} is broken: frame {} has {}", text.empty() ? "" : "; ", p.key,
                            p.key == "all_converged" ? "true" : value_text(p.limit, p.unit), *p.first_broken,
                            value_text(p.broken_by, p.unit));
        if (p.worst_frame != *p.first_broken)
            text += fmt::format(", frame {} the worst, {}", p.worst_frame, value_text(*p.worst, p.unit));
    }
    return text;
}

void write_certificate(const RunFolder& folder, const SceneFile& file, const RunSummary& summary,
                       const std::string& key, const std::string& outcome) {
    const std::vector<Promise> all = promises(file.expect, summary.records);
    std::set<std::string> hosts;
    for (const FrameRecord& record : summary.records) hosts.insert(record.host);
    const bool broken = !broken_promises(all).empty();
    Json json;
    json["scene"] = summary.scene;
    json["scene_hash"] = scene_key(file);
    json["states_key"] = key;
    json["build"] = maker();
    json["hosts"] = hosts;
    json["verdict"] = broken ? "broken" : outcome == "complete" ? "good" : "unfinished";
    json["outcome"] = outcome;
    json["expect"] = Json::array();
    const auto number = [](double value) { return std::isfinite(value) ? Json(value) : Json(); };
    for (const Promise& p : all) {
        Json entry = {{"key", p.key}, {"unit", p.unit}, {"limit", p.limit}, {"holds", !p.first_broken}};
        if (p.worst) {
            entry["worst"] = number(*p.worst);
            entry["worst_frame"] = p.worst_frame;
        }
        if (p.first_broken) {
            entry["first_broken_frame"] = *p.first_broken;
            entry["value_there"] = number(p.broken_by);
        }
        json["expect"].push_back(std::move(entry));
    }
    json["frames"] = Json::array();
    for (const FrameRecord& record : summary.records) json["frames"].push_back(frame_json(record));
    write_file(folder.certificate(), json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace cloth::pipeline
