#include "pipeline/run/shown_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <system_error>
#include <utility>

#include "base/text.h"
#include "pipeline/formats/base64.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/ledger.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t most_view_frames = 150;

constexpr PageMeasure measures[] = {
    {"simulate", "Time to simulate", "s", false, "most", "slowest", "max_seconds_per_frame"},
    {"largest_stretch", "Greatest stretch", "", false, "most", "greatest stretch", "max_stretch"},
    {"smallest_gap_m", "Smallest gap", "m", true, "least", "smallest gap", "min_gap"},
    {"energy_after_J", "Energy", "J"},
    {"residual", "Residual", "", true, "most", "greatest residual", "max_residual"},
    {"iterations", "Newton iterations", "", false, "most", "most iterations"},
    {"contacts", "Contacts", ""},
    {"retries", "Halved steps", "", false, "most", "most halved steps", "all_converged"},
    {.key = "draw", .label = "Time to draw", .unit = "s", .aside = true},
    {.key = "png", .label = "Time to write the picture", .unit = "s", .aside = true},
    {.key = "store", .label = "Time to store the state", .unit = "s", .aside = true},
    {.key = "cg_iterations", .label = "Iterations of conjugate gradients", .unit = "", .aside = true},
    {.key = "factorizations", .label = "Factorizations", .unit = "", .aside = true},
};

Json read_json(const fs::path& path) {
    try {
        return Json::parse(read_file(path));
    } catch (const std::exception&) {
        return Json::object();  // as good as none
    }
}

/// Frame by frame what the ledger tells, a list a measure.
Json columns(const LedgerEntries& ledger, const std::vector<std::int64_t>& frames) {
    Json all;
    all["frame"] = frames;
    for (const PageMeasure& measure : measures) all[measure.key] = Json::array();
    for (const std::int64_t frame : frames) {
        const auto entry = ledger.states.find(frame);
        Json json = Json::object();
        // No step leads to frame 0: there is nothing to tell.
        if (frame != 0 && entry != ledger.states.end()) {
            FrameRecord record = entry->second.record;
            if (const auto picture = ledger.pictures.find(frame); picture != ledger.pictures.end()) {
                record.draw = picture->second.draw;
                record.png = picture->second.png;
            }
            json = frame_json(record);
        }
        const Json seconds = json.value("seconds", Json::object());
        for (const PageMeasure& measure : measures)
            all[measure.key].push_back(seconds.contains(measure.key) ? seconds[measure.key]
                                                                     : json.value(measure.key, Json()));
    }
    return all;
}

Json movie_json(const RunFolder& folder, const std::string& name, const fs::path& page, std::size_t most) {
    const fs::path movie = folder.movie(name);
    std::error_code failure;
    const auto size = fs::file_size(movie, failure);
    if (failure) return {{"text", "There is no movie: render_cloth render --out DIR makes one."}};
    if (size <= most / 4 * 3) return {{"data", base64(read_file(movie))}};
    const fs::path href = fs::proximate(movie, fs::absolute(page, failure).parent_path(), failure);
    return {{"href", href.string()},
            {"text", fmt::format("This movie of {:.0f} MB is not in this page: it must lie at {}",
                                 1e-6 * static_cast<double>(size), href.string())}};
}

/// Some of the frames for the view in three dimensions.
Json view_json(const fs::path& out, const KeptRun& run, std::size_t frames, const Showing& showing,
               const RunOptions& options) {
    std::vector<ViewField> fields = view_fields(run.file);
    if (showing.more) fields.insert(fields.begin(), *showing.more);
    const std::size_t most = most_view / showing.runs;
    const int every = std::max(view_stride(frames, run.model.vertex_count(), fields.size(), most),
                               static_cast<int>((frames + most_view_frames - 1) / most_view_frames));
    ViewRecorder recorder(std::move(fields), most);
    record_frames(out, every, recorder, options);
    Json view = recorder.view();
    view["every"] = every * view["every"].get<int>();
    if (showing.more)
        view["shade"] = showing.more->name;
    else if (run.file.annotation.shade)
        view["shade"] = name_of(*run.file.annotation.shade).name;
    if (const auto& ground = run.file.ground) view["ground"] = ground->height;
    return view;
}

std::string text_at(const Json& json, const char* table, const char* key) {
    const Json part = json.value(table, Json::object());
    return part.contains(key) && part[key].is_string() ? part[key].get<std::string>() : std::string();
}

std::string number_at(const Json& json, const char* table, const char* key) {
    const Json part = json.value(table, Json::object());
    return part.contains(key) && part[key].is_number() ? fmt::format("{:.4g}", part[key].get<double>())
                                                       : std::string();
}

}  // namespace

Json measure_json(const PageMeasure& m) {
    return {{"key", m.key},     {"label", m.label},  {"unit", m.unit},
            {"log", m.log},     {"worst", m.worst},  {"worst_label", m.worst_label},
            {"aside", m.aside}, {"expect", m.expect}};
}

Json frame_measures() {
    Json all = Json::array();
    for (const PageMeasure& measure : measures) all.push_back(measure_json(measure));
    return all;
}

ShownRun shown_run(const fs::path& out, const Showing& showing, const RunOptions& options) {
    const KeptRun kept = open_run(out);
    ShownRun shown{{},
                   read_json(kept.folder.report()),
                   read_json(kept.folder.certificate()),
                   kept.file,
                   kept.folder.kept_states()};
    if (shown.frames.empty())
        throw Error(ExitCode::other, out.string() + ": keeps no states; render_cloth run makes them");
    Json& run = shown.run;
    run["label"] = showing.label;
    run["frames"] = columns(read_ledger(kept.folder.ledger()), shown.frames);
    run["frame_rate"] = kept.file.scene.simulation.frame_rate;
    run["playback_rate"] = playback_rate(kept.file);
    run["movie"] = movie_json(kept.folder, kept.file.name, showing.page, most_movie / showing.runs);
    run["expect"] = shown.certificate.value("expect", Json::array());
    run["scene"] = read_file(kept.folder.scene());
    if (const std::size_t branch = kept.folder.read_manifest().trunk.size(); branch > 0)
        run["branch"] = branch - 1;
    run["view"] = view_json(out, kept, shown.frames.size(), showing, options);
    return shown;
}

Json facts_of(const std::vector<const ShownRun*>& runs) {
    Json all = Json::array();
    const auto row = [&](const char* name, const auto& text_of) {
        Json texts = Json::array();
        bool any = false;
        for (const ShownRun* run : runs) {
            texts.push_back(text_of(*run));
            any = any || !texts.back().template get<std::string>().empty();
        }
        if (any) all.push_back({name, std::move(texts)});
    };
    const auto of_certificate = [&](const char* name, const char* key) {
        row(name, [&](const ShownRun& s) { return s.certificate.value(key, std::string()); });
    };
    const auto of_report = [&](const char* name, const char* table, const char* key) {
        row(name, [&](const ShownRun& s) { return text_at(s.report, table, key); });
    };
    const auto number = [&](const char* name, const char* table, const char* key) {
        row(name, [&](const ShownRun& s) { return number_at(s.report, table, key); });
    };
    of_certificate("fingerprint of the scene", "scene_hash");
    of_certificate("key of the last state", "states_key");
    row("branch", [](const ShownRun& s) {
        return s.run.contains("branch")
                   ? fmt::format("goes on from frame {} of another run", s.run["branch"].get<std::int64_t>())
                   : std::string();
    });
    row("meshes and textures", [](const ShownRun& s) {
        std::vector<std::string> files;
        for (const auto& [key, name] : s.file.files)
            files.push_back(fmt::format("{} = {}", key, fs::path(name).filename().string()));
        return join(files);
    });
    of_report("program", "program", "version");
    of_certificate("build", "build");
    row("simulated by the hosts", [](const ShownRun& s) {
        std::vector<std::string> hosts;
        for (const Json& host : s.certificate.value("hosts", Json::array()))
            if (host.is_string()) hosts.push_back(host);
        return join(hosts);
    });
    of_report("renderer", "program", "renderer");
    of_report("encoder", "program", "encoder");
    number("vertices", "simulation", "vertices");
    number("triangles", "simulation", "triangles");
    number("time step [s]", "simulation", "time_step_s");
    number("steps per frame", "simulation", "steps_per_frame");
    number("wall time of the last run [s]", "times_s", "wall");
    number("of it simulating [s]", "times_s", "simulate");
    number("of it drawing [s]", "times_s", "draw");
    return all;
}

void add_fault(Json& page, const ShownRun& run, const std::string& label) {
    const std::string outcome = run.report.value("outcome", std::string("complete"));
    if (outcome != "complete") page["faults"].push_back(label + outcome);
}

}  // namespace cloth::pipeline
