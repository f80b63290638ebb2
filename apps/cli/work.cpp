#include "apps/cli/work.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "base/text.h"

namespace cloth::cli {
namespace {

using pipeline::Progress;
using pipeline::RunSummary;

const std::map<std::string, render::GlLibrary> gl_libraries{{"auto", render::GlLibrary::automatic},
                                                            {"osmesa", render::GlLibrary::osmesa},
                                                            {"egl", render::GlLibrary::egl}};

/// On standard error. What cannot be told is not worth a run.
void tell(const std::string& text) {
    std::fputs(text.c_str(), stderr);
}

/// What was made, how long each stage took, where it lies.
std::string last_line(const RunSummary& summary, const std::filesystem::path& out) {
    const bool nothing = summary.states + summary.images == 0 &&
                         (summary.movie.empty() || summary.kept_movie) && summary.kept_states > 0;
    if (nothing)
        return fmt::format("{}: nothing to do, all of {} is kept (wall {:.1f} s): {}", summary.scene,
                           plural(summary.frames, "frame"), summary.times.wall, out.string());
    std::string made = summary.states > 0 ? plural(summary.states, "frame") : std::string();
    if (summary.states > 0 && summary.kept_states > 0) made += fmt::format(" after {}", summary.kept_states);
    if (summary.images > 0)
        made += fmt::format("{}{} of {}x{}", made.empty() ? "" : ", ", plural(summary.images, "picture"),
                            summary.width, summary.height);
    if (!summary.movie.empty() && !summary.kept_movie)
        made += fmt::format("{}a movie at {:g} frames/s", made.empty() ? "" : ", ", summary.playback_rate);
    std::string stages;
    const auto stage = [&](const char* name, double seconds) {
        if (seconds > 0) stages += fmt::format("{} {:.1f} s, ", name, seconds);
    };
    stage("simulate", summary.times.simulate);
    stage("draw", summary.times.draw);
    stage("png", summary.times.png);
    stage("encode", summary.times.encode);
    return fmt::format("{}: {} ({}wall {:.1f} s): {}", summary.scene, made, stages, summary.times.wall,
                       summary.movie.empty() ? out.string() : summary.movie.string());
}

}  // namespace

std::string clock_text(double seconds) {
    const auto s = static_cast<long>(std::lround(seconds));
    return s >= 3600 ? fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
                     : fmt::format("{}:{:02}", s / 60, s % 60);
}

/// On standard error: a bar on a terminal, a line every few seconds elsewhere.
class ProgressLine {
  public:
    ProgressLine(bool pictures, bool json) : pictures_(pictures), json_(json) {}
    ~ProgressLine() { clear(); }

    void show(const Progress& progress) {
        // Where the pictures come after the simulation, that is what there is to tell of first.
        const bool simulating = pictures_ && progress.drawn == 0 && progress.simulated > 3;
        const std::int64_t done = pictures_ && !simulating ? progress.written : progress.simulated;
        const auto now = std::chrono::steady_clock::now();
        const bool last = done == progress.frames;  // of a stage
        const bool often = terminal_ || json_;
        if (now - shown_ < std::chrono::duration<double>(often ? 0.1 : 5.0) && !(last && often)) return;
        shown_ = now;
        if (json_) return show_json(progress, std::chrono::duration<double>(now - start_).count());
        const double seconds = std::chrono::duration<double>(now - start_).count();
        const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
        std::string text = fmt::format("{}/{} frames{}, {:.1f} frames/s", done, progress.frames,
                                       simulating ? " simulated" : "", rate);
        if (rate > 0) text += ", " + clock_text(static_cast<double>(progress.frames - done) / rate) + " left";
        if (terminal_) {
            constexpr std::int64_t width = 30;
            const auto full =
                static_cast<std::size_t>(width * done / std::max<std::int64_t>(progress.frames, 1));
            tell(fmt::format("\r\033[K[{}{}] {}", std::string(full, '#'), std::string(width - full, '.'),
                             text));
            drawn_ = true;
        } else {
            tell(text + "\n");
        }
        std::fflush(stderr);
    }

    /// A line about something else.
    void note(const std::string& line) {
        if (json_) return print_json_line({{"event", "note"}, {"text", line}});
        clear();
        tell("render_cloth: note: " + line + "\n");
    }

    /// Makes room for other lines.
    void clear() {
        if (drawn_) tell("\r\033[K");
        drawn_ = false;
    }

  private:
    static void show_json(const Progress& p, double seconds) {
        print_json_line({{"event", "progress"},
                         {"frames", p.frames},
                         {"simulated", p.simulated},
                         {"drawn", p.drawn},
                         {"written", p.written},
                         {"encoded", p.encoded},
                         {"seconds", seconds}});
    }

    bool pictures_, json_;
    bool terminal_ = isatty(STDERR_FILENO) == 1;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), shown_ = start_;
};

void WorkFlags::add_threads(Flags& flags) {
    flags.integer({"--threads", "N", "Threads (default: all cores); the result is the same for any"}, threads,
                  1, 1024);
}

void WorkFlags::add_gl(Flags& flags) {
    std::vector<std::string> names;
    for (const auto& [name, library] : gl_libraries) names.push_back(name);
    flags.choice({"--gl", "NAME", "Library that draws (default: auto, OSMesa where it is there)"}, gl, names);
}

void WorkFlags::add(Flags& flags) {
    add_threads(flags);
    add_gl(flags);
    flags.yes("--quiet", quiet, "No progress");
    flags.yes("--no-video", no_video, "Pictures only, no MP4");
    flags.yes("--json", json, "The result as JSON on standard output");
    flags.choice({"--progress", "FORM",
                  "text (default), or json: progress, notes and the result on standard output, "
                  "one object a line"},
                 progress, {"text", "json"});
}

void WorkFlags::add_reuse(Flags& flags) {
    flags.yes("--fresh", fresh, "Start over: use nothing that the folder holds");
    flags.yes("--explain", explain, "Say what would be reused, what made, and why; do nothing");
}

render::GlLibrary WorkFlags::gl_library() const {
    return gl_libraries.at(gl);
}

Watch::Watch(const WorkFlags& flags, bool pictures, OnSignal on_signal)
    : line_(std::make_unique<ProgressLine>(pictures, flags.progress == "json")) {
    if (on_signal == OnSignal::finish) options_.stop = request_.emplace().flag();
    options_.pictures = pictures;
    options_.movie = pictures && !flags.no_video;
    options_.threads = flags.threads;
    options_.gl = flags.gl_library();
    options_.fresh = flags.fresh;
    options_.tell = [this](const std::string& line) { line_->note(one_line(line)); };
    if (!flags.quiet) options_.progress = [this](const Progress& progress) { line_->show(progress); };
}

Watch::~Watch() = default;

namespace {

nlohmann::ordered_json summary_json(const RunSummary& summary, const std::filesystem::path& out) {
    return {{"event", "result"},
            {"scene", summary.scene},
            {"out", out.string()},
            {"frames", summary.frames},
            {"states", {{"made", summary.states}, {"kept", summary.kept_states}}},
            {"pictures", {{"made", summary.images}, {"kept", summary.kept_images}}},
            {"movie", summary.movie.string()},
            {"movie_kept", summary.kept_movie},
            {"size_pixel", {summary.width, summary.height}},
            {"playback_rate_hz", summary.playback_rate},
            {"times_s", pipeline::times_json(summary.times)}};
}

}  // namespace

void conclude(const RunSummary& summary, const std::filesystem::path& out, const WorkFlags& flags) {
    if (summary.interrupted) {
        const std::int64_t states = summary.kept_states + summary.states,
                           images = summary.kept_images + summary.images;
        std::string line =
            states > 0 ? fmt::format("interrupted: {} and {} of {} are kept in {}", plural(states, "state"),
                                     plural(images, "picture"), summary.frames, out.string())
                       : fmt::format("interrupted: {} drawn of {} are kept in {}",
                                     plural(summary.images, "picture"), summary.frames, out.string());
        if (!summary.encoder.empty() && std::max(states, images) > 0)
            line += fmt::format("; a movie of them: render_cloth {} --out {}",
                                images == states ? "encode" : "render", out.string());
        if (states > 0) line += "; the same command again continues";
        throw pipeline::Error(ExitCode::interrupted, line);
    }
    if (flags.progress == "json") return print_json_line(summary_json(summary, out));
    if (flags.json) return print_json(summary_json(summary, out));
    fmt::print("{}\n", last_line(summary, out));
}

std::filesystem::path run_scene(const SceneFlags& scene, const WorkFlags& flags, bool pictures) {
    const pipeline::SceneFile file = scene.load();
    const std::filesystem::path out = scene.folder(file);
    const Watch watch(flags, pictures, flags.explain ? OnSignal::end : OnSignal::finish);
    if (flags.explain) {
        const std::vector<std::string> lines = pipeline::explain_run(file, out, watch.options());
        if (flags.json || flags.progress == "json") {
            print_json_line({{"event", "plan"}, {"out", out.string()}, {"parts", lines}});
        } else {
            for (const std::string& line : lines) fmt::print("{}\n", one_line(line));
        }
        return out;
    }
    conclude(pipeline::run_scene(file, out, watch.options()), out, flags);
    return out;
}

}  // namespace cloth::cli
