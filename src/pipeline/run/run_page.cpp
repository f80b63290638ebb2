#include "pipeline/run/run_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>
#include <vector>

#include "base/text.h"
#include "pipeline/formats/base64.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/page/page.h"
#include "pipeline/page/view_data.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/ledger.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

/// What the page may hold at most [byte]: it is to be opened from a mail, too.
constexpr double most_view = 9e6, most_movie = 14e6;
constexpr std::size_t most_view_frames = 150;

/// A curve of the page, by its name in frame_json(); in "seconds" where that has a part so called.
struct Measure {
    const char *key, *label, *unit;
    bool log;
    const char *worst, *worst_label;  ///< "most" or "least" is worst; "": neither
};
constexpr Measure measures[] = {
    {"simulate", "Time to simulate", "s", false, "most", "slowest"},
    {"largest_stretch", "Greatest stretch", "", false, "most", "greatest stretch"},
    {"smallest_gap_m", "Smallest gap", "m", true, "least", "smallest gap"},
    {"energy_after_J", "Energy", "J", false, "", ""},
    {"residual", "Residual", "", true, "most", "greatest residual"},
    {"iterations", "Newton iterations", "", false, "most", "most iterations"},
    {"contacts", "Contacts", "", false, "", ""},
    {"retries", "Halved steps", "", false, "most", "most halved steps"},
};
constexpr Measure apart = {"apart_m",       "Greatest distance between the runs", "m", true, "most",
                           "farthest apart"};

Json measure_json(const Measure& m) {
    return {{"key", m.key}, {"label", m.label}, {"unit", m.unit},
            {"log", m.log}, {"worst", m.worst}, {"worst_label", m.worst_label}};
}

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
    for (const Measure& measure : measures) all[measure.key] = Json::array();
    for (const std::int64_t frame : frames) {
        const auto entry = ledger.states.find(frame);
        // No step leads to frame 0: there is nothing to tell.
        const Json json =
            frame == 0 || entry == ledger.states.end() ? Json::object() : frame_json(entry->second.record);
        for (const Measure& measure : measures) {
            const Json seconds = json.value("seconds", Json::object());
            all[measure.key].push_back(seconds.contains(measure.key) ? seconds[measure.key]
                                                                     : json.value(measure.key, Json()));
        }
    }
    return all;
}

Json movie_json(const RunFolder& folder, const std::string& name, const fs::path& page) {
    const fs::path movie = folder.movie(name);
    std::error_code failure;
    const auto size = fs::file_size(movie, failure);
    if (failure) return {{"text", "There is no movie: render_cloth render --out DIR makes one."}};
    if (static_cast<double>(size) <= most_movie) return {{"data", base64(read_file(movie))}};
    return {{"href", fs::proximate(movie, page.parent_path(), failure).string()},
            {"text",
             fmt::format("the movie of {:.0f} MB lies beside this page", 1e-6 * static_cast<double>(size))}};
}

/// Some of the frames for the view in three dimensions.
Json view_json(const fs::path& out, std::size_t frames, int vertices, const RunOptions& options) {
    const int every = std::max(view_stride(frames, vertices, most_view),
                               static_cast<int>((frames + most_view_frames - 1) / most_view_frames));
    ViewRecorder recorder;
    record_frames(out, every, recorder, options);
    Json view = recorder.view();
    view["every"] = every;
    return view;
}

/// A run as the page shows it.
struct Shown {
    Json run;
    Json report, certificate;
    SceneFile file;
    std::vector<std::int64_t> frames;
};

Shown shown_run(const fs::path& out, const std::string& label, const fs::path& page,
                const RunOptions& options) {
    const KeptRun kept = open_run(out);
    Shown shown{{},
                read_json(kept.folder.report()),
                read_json(kept.folder.certificate()),
                kept.file,
                kept.folder.kept_states()};
    if (shown.frames.empty())
        throw Error(ExitCode::other, out.string() + ": keeps no states; render_cloth run makes them");
    Json& run = shown.run;
    run["label"] = label;
    run["frames"] = columns(read_ledger(kept.folder.ledger()), shown.frames);
    run["frame_rate"] = kept.file.scene.simulation.frame_rate;
    run["playback_rate"] = playback_rate(kept.file);
    run["movie"] = movie_json(kept.folder, kept.file.name, page);
    run["expect"] = shown.certificate.value("expect", Json::array());
    run["scene"] = read_file(kept.folder.scene());
    run["view"] = view_json(out, shown.frames.size(), kept.model.vertex_count(), options);
    return shown;
}

std::string text_at(const Json& json, const char* table, const char* key) {
    const Json part = json.value(table, Json::object());
    return part.contains(key) && part[key].is_string() ? part[key].get<std::string>() : std::string();
}

std::string number_at(const Json& json, const char* table, const char* key) {
    const Json part = json.value(table, Json::object());
    return part.contains(key) && part[key].is_number() ? fmt::format("{:g}", part[key].get<double>())
                                                       : std::string();
}

/// What a run was made from: name, and a text of each run.
Json facts(const std::vector<const Shown*>& runs) {
    Json all = Json::array();
    const auto row = [&](const char* name, const auto& text_of) {
        Json texts = Json::array();
        bool any = false;
        for (const Shown* run : runs) {
            texts.push_back(text_of(*run));
            any = any || !texts.back().template get<std::string>().empty();
        }
        if (any) all.push_back({name, std::move(texts)});
    };
    row("scene", [](const Shown& s) { return s.certificate.value("scene_hash", std::string()); });
    row("program", [](const Shown& s) {
        return (text_at(s.report, "program", "version") + " " + text_at(s.report, "program", "build"));
    });
    row("simulated by", [](const Shown& s) {
        std::string hosts;
        for (const Json& host : s.certificate.value("hosts", Json::array()))
            if (host.is_string()) hosts += (hosts.empty() ? "" : ", ") + host.get<std::string>();
        return hosts;
    });
    row("renderer", [](const Shown& s) { return text_at(s.report, "program", "renderer"); });
    row("encoder", [](const Shown& s) { return text_at(s.report, "program", "encoder"); });
    row("vertices", [](const Shown& s) { return number_at(s.report, "simulation", "vertices"); });
    row("triangles", [](const Shown& s) { return number_at(s.report, "simulation", "triangles"); });
    row("time step, s", [](const Shown& s) { return number_at(s.report, "simulation", "time_step_s"); });
    row("wall time of the last run, s",
        [](const Shown& s) { return number_at(s.report, "times_s", "wall"); });
    row("simulating, s", [](const Shown& s) { return number_at(s.report, "times_s", "simulate"); });
    row("drawing, s", [](const Shown& s) { return number_at(s.report, "times_s", "draw"); });
    return all;
}

/// Good, broken or unfinished, as the certificate says.
Json verdict(const Shown& run) {
    const std::string word = run.certificate.value("verdict", std::string());
    if (word == "good") return {{"text", "complete"}, {"tone", "good"}};
    if (word == "broken") return {{"text", "a limit is broken"}, {"tone", "bad"}};
    return {{"text", word.empty() ? "not certified" : word}, {"tone", "warn"}};
}

/// Outcomes that are no success are the first thing to be read.
void add_fault(Json& data, const Shown& run, const std::string& label) {
    const std::string outcome = run.report.value("outcome", std::string("complete"));
    if (outcome != "complete") data["faults"].push_back(label + outcome);
}

Json page_of_run(const fs::path& out, const fs::path& page, const RunOptions& options) {
    const Shown run = shown_run(out, out.filename().string(), page, options);
    Json data;
    data["mark"] = own_mark;
    data["title"] = run.file.name;
    data["verdict"] = verdict(run);
    data["lines"] = Json::array();
    if (!run.file.description.empty()) data["lines"].push_back(run.file.description);
    data["faults"] = Json::array();
    add_fault(data, run, "");
    data["measures"] = Json::array();
    for (const Measure& measure : measures) data["measures"].push_back(measure_json(measure));
    data["facts"] = facts({&run});
    data["notes"] = run.report.value("notes", Json::array());
    data["runs"] = Json::array({run.run});
    return data;
}

bool same_bits(const VecX& a, const VecX& b) {
    return a.size() == b.size() &&
           std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
}

/// Greatest distance of a vertex from itself [m].
double distance_of(const VecX& a, const VecX& b) {
    double largest = 0;
    for (Eigen::Index v = 0; v < a.size() / 3; ++v)
        largest = std::max(largest, (a.segment<3>(3 * v) - b.segment<3>(3 * v)).norm());
    return largest;
}

/// Frames that both keep, and how far apart they are there, as a column of run `a`'s.
RunDifference compare_states(const fs::path& a, const fs::path& b, Shown& shown_a,
                             const RunOptions& options) {
    const KeptRun run_a = open_run(a), run_b = open_run(b);
    RunDifference difference;
    difference.comparable = run_a.model.vertex_count() == run_b.model.vertex_count();
    const StateReader read_a = state_reader(run_a.folder, run_a.model),
                      read_b = state_reader(run_b.folder, run_b.model);
    const std::vector<std::int64_t> frames_b = run_b.folder.kept_states();
    Json apart_column = Json::array();
    for (const std::int64_t frame : shown_a.frames) {
        if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: no page was written");
        if (!difference.comparable || !std::binary_search(frames_b.begin(), frames_b.end(), frame)) {
            apart_column.push_back(nullptr);
            continue;
        }
        ++difference.common;
        const State state_a = read_kept(read_a, frame), state_b = read_kept(read_b, frame);
        const double distance = distance_of(state_a.positions, state_b.positions);
        apart_column.push_back(distance);
        if (!difference.first && !(same_bits(state_a.positions, state_b.positions) &&
                                   same_bits(state_a.velocities, state_b.velocities)))
            difference.first = frame;
        if (distance > difference.largest) {
            difference.largest = distance;
            difference.largest_frame = frame;
        }
    }
    shown_a.run["frames"][apart.key] = std::move(apart_column);
    return difference;
}

std::string difference_text(const RunDifference& d) {
    if (!d.comparable) return "They have different numbers of vertices: only their measures can be compared.";
    if (d.common == 0) return "They keep no frame in common.";
    const std::string common = plural(d.common, "common frame");
    if (!d.first) return fmt::format("Their states are the same to the bit in all of {}.", common);
    return fmt::format(
        "Of {} frame {} is the first whose state differs; farthest apart is a vertex in frame {}, by {:.3g} "
        "m.",
        common, *d.first, d.largest_frame, d.largest);
}

}  // namespace

void write_run_page(const fs::path& out, const RunOptions& options) {
    const RunFolder folder = RunFolder::open(out);
    write_file(folder.page(), page_text(page_of_run(out, folder.page(), options)));
}

void leave_run_page(const fs::path& out, const RunOptions& options) {
    if (!options.page) return;
    try {
        write_run_page(out, options);
    } catch (const std::exception& e) {
        if (options.tell) options.tell(fmt::format("no report.html: {}", e.what()));
    }
}

RunDifference write_comparison_page(const fs::path& a, const fs::path& b, const fs::path& file,
                                    const RunOptions& options) {
    std::error_code ignored;
    if (fs::exists(file, ignored) && read_file(file).find(own_mark) == std::string::npos)
        throw Error(ExitCode::usage,
                    fmt::format("--file {}: is there and no page of this program's; give another name",
                                file.string()));
    const std::string label_a = a.string(), label_b = b.string();
    Shown run_a = shown_run(a, label_a, file, options), run_b = shown_run(b, label_b, file, options);
    const RunDifference difference = compare_states(a, b, run_a, options);
    Json data;
    data["mark"] = own_mark;
    data["title"] = fmt::format("{} and {}", label_a, label_b);
    const bool same = difference.comparable && !difference.first && difference.common > 0;
    data["verdict"] = {{"text", same ? "the same" : "they differ"}, {"tone", same ? "good" : "warn"}};
    data["lines"] = {difference_text(difference)};
    if (const auto keys = differences(run_a.file, run_b.file); !keys.empty())
        data["lines"].push_back("Keys of their scenes that differ: " + join(keys) + ".");
    data["faults"] = Json::array();
    add_fault(data, run_a, label_a + ": ");
    add_fault(data, run_b, label_b + ": ");
    data["measures"] = Json::array();
    if (difference.common > 0) data["measures"].push_back(measure_json(apart));
    for (const Measure& measure : measures) data["measures"].push_back(measure_json(measure));
    data["facts_head"] = {"", label_a, label_b};
    data["facts"] = facts({&run_a, &run_b});
    data["runs"] = Json::array({run_a.run, run_b.run});
    write_file(file, page_text(data));
    return difference;
}

}  // namespace cloth::pipeline
