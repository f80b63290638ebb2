#include "pipeline/run/report.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <type_traits>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/ledger.h"

namespace cloth::pipeline {

namespace {

using Json = nlohmann::ordered_json;

/// "energy_after_J"
std::string key_of(const char* name, const char* unit) {
    return *unit == '\0' ? name : std::string(name) + '_' + unit;
}

/// A number that JSON can hold, or null.
template <class T>
Json value_of(T value) {
    if constexpr (std::is_floating_point_v<T>) {
        if (!std::isfinite(value)) return nullptr;
    }
    return value;
}

Json contact_times_json(const std::vector<FrameRecord>& records) {
    ContactTimes sum;
    for (const FrameRecord& record : records) merge(sum, record.report.contact_times);
    Json json;
    ContactTimes::describe(
        [&](const char* name, auto member, const char*, auto) { json[name] = value_of(sum.*member); });
    return json;
}

Json read_json(const RunFolder& folder) {
    try {
        if (Json json = Json::parse(read_file(folder.report())); json.is_object()) return json;
    } catch (const std::exception&) {
        // As good as none.
    }
    return Json::object();
}

void write_json(const RunFolder& folder, const Json& json) {
    // Messages name files, whose names may be any bytes.
    write_file(folder.report(), json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
}

}  // namespace

Json times_json(const StageTimes& times) {
    return {{"simulate", times.simulate}, {"store", times.store},   {"draw", times.draw},
            {"png", times.png},           {"encode", times.encode}, {"wall", times.wall}};
}

Json frame_json(const FrameRecord& record) {
    const FrameReport& report = record.report;
    Json json = {{"frame", report.frame}, {"steps", report.steps}};
    StepReport::describe([&](const char* name, auto member, const char* unit, auto) {
        json[key_of(name, unit)] = value_of(report.*member);
    });
    json["largest_penetration_m"] =
        std::isfinite(report.smallest_gap) ? value_of(std::max(0.0, -report.smallest_gap)) : Json();
    json["state_hash"] = record.state_hash;
    json["host"] = record.host;
    json["seconds"] = {
        {"simulate", record.simulate}, {"store", record.store}, {"draw", record.draw}, {"png", record.png}};
    return json;
}

FrameRecord frame_record(const Json& json) {
    FrameRecord record;
    FrameReport& report = record.report;
    json.at("frame").get_to(report.frame);
    json.at("steps").get_to(report.steps);
    StepReport::describe([&](const char* name, auto member, const char* unit, auto) {
        // null: as a report begins, which is how a gap without anything near is told
        const auto found = json.find(key_of(name, unit));
        if (found != json.end() && !found->is_null()) found->get_to(report.*member);
    });
    json.at("state_hash").get_to(record.state_hash);
    json.at("host").get_to(record.host);
    const Json& seconds = json.at("seconds");
    seconds.at("simulate").get_to(record.simulate);
    seconds.at("store").get_to(record.store);
    seconds.at("draw").get_to(record.draw);
    seconds.at("png").get_to(record.png);
    return record;
}

void write_report(const RunFolder& folder, const SceneFile& file, const Model& model,
                  const RunSummary& summary, const std::string& outcome) {
    Json report;
    report["scene"] = summary.scene;
    report["outcome"] = outcome;
    if (!file.notes.empty()) report["notes"] = file.notes;
    report["program"] = {{"version", program_version()},
                         {"build", build_fingerprint()},
                         {"renderer", summary.renderer},
                         {"encoder", summary.encoder}};
    report["simulation"] = {{"vertices", model.vertex_count()},
                            {"triangles", model.triangle_count()},
                            {"cloths", model.cloths.size()},
                            {"pinned", model.pinned.size()},
                            {"time_step_s", model.time_step},
                            {"steps_per_frame", model.steps_per_frame},
                            {"frame_rate_hz", file.scene.simulation.frame_rate}};
    report["output"] = {{"frames", summary.frames},
                        {"states", summary.kept_states + summary.states},
                        {"images", summary.kept_images + summary.images},
                        {"size_pixel", {summary.width, summary.height}},
                        {"playback_rate_hz", summary.playback_rate},
                        {"movie", summary.movie.filename().string()}};
    report["kept"] = {{"states", summary.kept_states}, {"images", summary.kept_images}};
    report["times_s"] = times_json(summary.times);
    if (file.scene.simulation.contact == ContactKind::barrier)
        report["contact_times_s"] = contact_times_json(summary.records);
    Json frames = Json::array();
    for (const FrameRecord& record : summary.records) frames.push_back(frame_json(record));
    report["frames"] = std::move(frames);
    write_json(folder, report);
}

void amend_report(const RunFolder& folder, const RunSummary& summary) {
    Json report = read_json(folder);
    report["redrawn"] = {{"images", summary.images},
                         {"size_pixel", {summary.width, summary.height}},
                         {"playback_rate_hz", summary.playback_rate},
                         {"renderer", summary.renderer},
                         {"encoder", summary.encoder},
                         {"movie", summary.movie.filename().string()},
                         {"times_s", times_json(summary.times)}};
    write_json(folder, report);
}

FrameReports read_frame_reports(const RunFolder& folder) {
    FrameReports reports;
    for (const auto& [frame, entry] : read_ledger(folder.ledger()).states)
        reports[frame] = entry.record.report;
    return reports;
}

}  // namespace cloth::pipeline
