// Arguments and verbs of the program `render_cloth`; the work is done by src/pipeline/run/run.h and golden.h.

#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <atomic>
#include <charconv>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/formats/video.h"
#include "pipeline/golden/golden.h"
#include "pipeline/run/run.h"
#include "pipeline/run/sheet.h"
#include "pipeline/scene_file/fabric_list.h"
#include "render/raster/rasterizer.h"
#include "sim/contact/overlap.h"
#include "sim/scene/fabrics.h"
#include "validation/validation.h"

namespace {

using namespace cloth;
using namespace cloth::pipeline;
namespace fs = std::filesystem;

// ---------------------------------------------------------------- arguments

/// As typed; the values are read below, so that each is refused in the same words wherever it is given.
struct Arguments {
    std::string scene, frames, out, size, fps, threads, frame, format, file, golden, what, name, gamma,
        resolution, fabric, plots, gl = "auto";
    std::vector<std::string> set;
    // Over the pictures
    std::string shade, shade_range, ids, curves, motion_blur;
    bool caption = false, wireframe = false;
    // Several pictures in one
    std::string count, columns, labels;
    std::vector<std::string> runs;
    bool quiet = false, no_video = false, version = false, sources = false, markdown = false;
};

[[noreturn]] void refuse(const std::string& line) {
    throw Error(ExitCode::usage, line);
}

template <class T>
std::optional<T> number(std::string_view text) {
    T value{};
    const auto [end, failure] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (failure != std::errc() || end != text.data() + text.size()) return std::nullopt;
    return value;
}

int frame_count(const std::string& text) {
    const auto n = number<int>(text);
    if (!n || *n < 1 || *n > 999999)
        refuse(fmt::format("--frames {}: give a whole number, 1 … 999999", text));
    return *n;
}

int thread_count(const std::string& text) {
    if (text.empty()) return 0;
    const auto n = number<int>(text);
    if (!n || *n < 1 || *n > 1024)
        refuse(fmt::format("--threads {}: give a whole number, 1 … 1024; without it all cores work", text));
    return *n;
}

std::array<int, 2> picture_size(const std::string& text) {
    const std::size_t x = std::min(text.find('x'), text.size());
    const auto side = [](std::string_view digits) {
        const int n = number<int>(digits).value_or(0);
        return n >= 16 && n <= 8192 ? n : 0;
    };
    const std::string_view view = text;
    const std::array<int, 2> size{side(view.substr(0, x)), side(view.substr(std::min(x + 1, view.size())))};
    if (size[0] == 0 || size[1] == 0)
        refuse(fmt::format("--size {}: give WIDTHxHEIGHT, each 16 … 8192 pixels, as in 1280x720", text));
    return size;
}

double frame_rate(const std::string& text) {
    const auto rate = number<double>(text);
    if (!rate || !std::isfinite(*rate) || *rate < 0.1 || *rate > 1000)
        refuse(fmt::format("--fps {}: give frames per second, 0.1 … 1000", text));
    return *rate;
}

FrameSpan frame_span(const std::string& text) {
    const std::size_t colon = text.find(':');
    const auto first = number<std::int64_t>(text.substr(0, colon));
    const auto last =
        colon == std::string::npos ? std::nullopt : number<std::int64_t>(text.substr(colon + 1));
    if (!first || !last || *first < 0 || *last <= *first)
        refuse(fmt::format("--frames {}: give A:B with 0 <= A < B; it draws the frames A … B-1", text));
    return {*first, *last};
}

std::vector<std::string> split(const std::string& text, char separator) {
    std::vector<std::string> parts;
    for (std::size_t begin = 0, end = 0; end != std::string::npos; begin = end + 1) {
        end = text.find(separator, begin);
        parts.push_back(text.substr(begin, end - begin));
    }
    return parts;
}

/// Finite numbers, separated; nothing where there is anything else.
std::optional<std::vector<double>> numbers(const std::string& text, char separator) {
    std::vector<double> values;
    for (const std::string& part : split(text, separator)) {
        const auto value = number<double>(part);
        if (!value || !std::isfinite(*value)) return std::nullopt;
        values.push_back(*value);
    }
    return values;
}

template <class Names>
std::string name_list(const Names& names) {
    std::string text;
    for (const auto& each : names) text += fmt::format("{}{}", text.empty() ? "" : ", ", each.name);
    return text;
}

template <class Names>
bool known(const Names& names, const std::string& name) {
    return std::any_of(std::begin(names), std::end(names), [&](const auto& n) { return name == n.name; });
}

/// What is drawn over the pictures, as --set lines.
void append_annotation(const Arguments& args, Overrides& list) {
    if (args.caption) list.push_back("output.caption=true");
    if (!args.shade.empty()) {
        if (!known(vertex_field_names(), args.shade))
            refuse(fmt::format("--shade {}: give one of {}", args.shade, name_list(vertex_field_names())));
        list.push_back("output.shade=" + args.shade);
    }
    if (!args.shade_range.empty()) {
        const auto ends = numbers(args.shade_range, ':');
        if (!ends || ends->size() != 2 || !((*ends)[0] < (*ends)[1]))
            refuse(fmt::format("--shade-range {}: give LOW:HIGH, as in 0.95:1.05", args.shade_range));
        list.push_back(fmt::format("output.shade_range=[{:#}, {:#}]", (*ends)[0], (*ends)[1]));
    }
    if (args.wireframe) list.push_back("output.wireframe=true");
    if (!args.ids.empty()) {
        const auto place = numbers(args.ids, ',');
        if (!place || (place->size() != 2 && place->size() != 3) ||
            (place->size() == 3 && !((*place)[2] > 0)))
            refuse(fmt::format(
                "--ids {}: give X,Y or X,Y,RADIUS of a place in the picture, in pixels from its top "
                "left corner",
                args.ids));
        list.push_back(fmt::format("output.ids=[{:#}]", fmt::join(*place, ", ")));
    }
    if (!args.curves.empty()) {
        std::string names;
        for (const std::string& each : split(args.curves, ',')) {
            if (!known(curve_names, each))
                refuse(fmt::format("--curves {}: \"{}\" is none of {}", args.curves, each,
                                   name_list(curve_names)));
            names += (names.empty() ? "\"" : ", \"") + each + '"';
        }
        list.push_back("output.curves=[" + names + "]");
    }
    if (!args.motion_blur.empty()) {
        const auto n = number<int>(args.motion_blur);
        if (!n || *n < 1 || *n > 64)
            refuse(fmt::format("--motion-blur {}: give a number of pictures, 1 … 64", args.motion_blur));
        list.push_back(fmt::format("output.motion_blur={}", *n));
    }
}

int small_count(const char* flag, const std::string& text, int fallback) {
    if (text.empty()) return fallback;
    const auto n = number<int>(text);
    if (!n || *n < 1 || *n > 1000) refuse(fmt::format("{} {}: give a whole number, 1 … 1000", flag, text));
    return *n;
}

// ---------------------------------------------------------------- progress

std::atomic<bool> stop_wanted = false;
static_assert(std::atomic<bool>::is_always_lock_free, "set by a signal handler");

void watch_signals() {
    struct sigaction action = {};
    action.sa_handler = [](int) { stop_wanted = true; };
    action.sa_flags = static_cast<int>(SA_RESETHAND);  // a second Ctrl-C ends the program at once
    sigaction(SIGINT, &action, nullptr);
    sigaction(SIGTERM, &action, nullptr);
}

std::string clock_text(double seconds) {
    const auto s = static_cast<long>(std::lround(seconds));
    return s >= 3600 ? fmt::format("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
                     : fmt::format("{}:{:02}", s / 60, s % 60);
}

/// On standard error: a bar on a terminal, a line every few seconds elsewhere.
class ProgressLine {
  public:
    explicit ProgressLine(bool pictures) : pictures_(pictures) {}
    ~ProgressLine() { clear(); }

    void show(const Progress& progress) {
        // Where the pictures come after the simulation, that is what there is to tell of first.
        const bool simulating = pictures_ && progress.drawn == 0 && progress.simulated > 3;
        const std::int64_t done = pictures_ && !simulating ? progress.written : progress.simulated;
        const auto now = std::chrono::steady_clock::now();
        const bool last = done == progress.frames;
        if (now - shown_ < std::chrono::duration<double>(terminal_ ? 0.1 : 5.0) && !(last && terminal_))
            return;
        shown_ = now;
        const double seconds = std::chrono::duration<double>(now - start_).count();
        const double rate = seconds > 0 ? static_cast<double>(done) / seconds : 0;
        std::string text = fmt::format("{}/{} frames{}, {:.1f} frames/s", done, progress.frames,
                                       simulating ? " simulated" : "", rate);
        if (rate > 0) text += ", " + clock_text(static_cast<double>(progress.frames - done) / rate) + " left";
        if (terminal_) {
            constexpr std::int64_t width = 30;
            const auto full = static_cast<std::size_t>(width * done / progress.frames);
            fmt::print(stderr, "\r\033[K[{}{}] {}", std::string(full, '#'), std::string(width - full, '.'),
                       text);
            drawn_ = true;
        } else {
            fmt::print(stderr, "{}\n", text);
        }
        std::fflush(stderr);
    }

    /// Makes room for other lines.
    void clear() {
        if (drawn_) fmt::print(stderr, "\r\033[K");
        drawn_ = false;
    }

  private:
    bool pictures_;
    bool terminal_ = isatty(STDERR_FILENO) == 1;
    bool drawn_ = false;
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), shown_ = start_;
};

render::GlLibrary gl_library(const std::string& text) {
    if (text == "auto") return render::GlLibrary::automatic;
    if (text == "osmesa") return render::GlLibrary::osmesa;
    if (text == "egl") return render::GlLibrary::egl;
    refuse(fmt::format("--gl {}: give egl, osmesa or auto", text));
}

// ---------------------------------------------------------------- verbs

/// The flags as --set lines, behind those that the user gave: a flag is the more deliberate of the two.
Overrides overrides(const Arguments& args) {
    for (const std::string& each : args.set)
        if (each.find('=') == std::string::npos || each.front() == '=')
            refuse(fmt::format("--set {}: give KEY=VALUE, as in cloth.resolution=40", each));
    Overrides list(args.set.begin(), args.set.end());
    if (!args.size.empty()) {
        const auto [width, height] = picture_size(args.size);
        list.push_back(fmt::format("output.size=[{}, {}]", width, height));
    }
    append_annotation(args, list);
    return list;
}

/// --fps sets the movie's rate. In a scene without a playback rate of its own time runs true, and it keeps
/// doing so: the simulation makes as many frames per second.
SceneFile scene_for(const Arguments& args) {
    if (args.scene.empty())
        refuse("--scene is missing: give a scene's name or file; render_cloth list names them");
    Overrides list = overrides(args);
    if (!args.frames.empty()) list.push_back(fmt::format("output.frames={}", frame_count(args.frames)));
    if (args.fps.empty()) return load_scene(args.scene, list);
    const double fps = frame_rate(args.fps);
    const bool own_rate = load_scene(args.scene, list).output.playback_rate.has_value();
    list.push_back(fmt::format("{}={:#}", own_rate ? "output.playback_rate" : "simulation.frame_rate", fps));
    return load_scene(args.scene, list);
}

Overrides redraw_overrides(const Arguments& args) {
    Overrides list = overrides(args);
    if (!args.fps.empty()) list.push_back(fmt::format("output.playback_rate={:#}", frame_rate(args.fps)));
    return list;
}

fs::path run_folder(const Arguments& args) {
    if (args.out.empty()) refuse("--out is missing: give the folder of a run");
    return args.out;
}

fs::path output_folder(const Arguments& args, const SceneFile& file) {
    return args.out.empty() ? fs::path("out") / file.name : fs::path(args.out);
}

std::string plural(std::int64_t n, const std::string& noun) {
    return fmt::format("{} {}{}", n, noun, n == 1 ? "" : "s");
}

/// What was made, how long each stage took, where it lies.
std::string last_line(const RunSummary& summary, const fs::path& out) {
    std::string made = summary.states > 0 ? plural(summary.states, "frame") : std::string();
    if (summary.images > 0)
        made += fmt::format("{}{} of {}x{}", made.empty() ? "" : ", ", plural(summary.images, "picture"),
                            summary.width, summary.height);
    if (!summary.movie.empty())
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

/// Tells of a run that came to its end, and gives its exit code.
ExitCode conclude(const RunSummary& summary, const fs::path& out) {
    if (summary.interrupted)
        throw Error(
            ExitCode::interrupted,
            summary.states > 0
                ? fmt::format("interrupted: {} and {} of {} are kept in {}", plural(summary.states, "state"),
                              plural(summary.images, "picture"), summary.frames, out.string())
                : fmt::format("interrupted: {} drawn of {} are kept in {}", plural(summary.images, "picture"),
                              summary.frames, out.string()));
    fmt::print("{}\n", last_line(summary, out));
    return ExitCode::good;
}

/// What `work` returns, its progress shown while it goes on.
template <class Work>
auto watched(const Arguments& args, bool pictures, Work work) {
    watch_signals();  // here only: elsewhere nothing asks whether to stop
    ProgressLine line(pictures);
    RunOptions options;
    options.pictures = pictures;
    options.movie = pictures && !args.no_video;
    options.threads = thread_count(args.threads);
    options.gl = gl_library(args.gl);
    options.stop = &stop_wanted;
    if (!args.quiet) options.progress = [&](const Progress& progress) { line.show(progress); };
    return work(options);
}

template <class Work>
ExitCode with_progress(const Arguments& args, bool pictures, const fs::path& out, Work work) {
    return conclude(watched(args, pictures, work), out);
}

ExitCode run(const Arguments& args, bool pictures) {
    thread_count(args.threads);
    gl_library(args.gl);
    const SceneFile file = scene_for(args);
    const fs::path out = output_folder(args, file);
    return with_progress(args, pictures, out,
                         [&](const RunOptions& options) { return run_scene(file, out, options); });
}

ExitCode render(const Arguments& args) {
    std::optional<FrameSpan> span;
    if (!args.frames.empty()) span = frame_span(args.frames);
    const fs::path out = run_folder(args);
    return with_progress(args, true, out, [&](const RunOptions& options) {
        return render_run(out, span, redraw_overrides(args), options);
    });
}

ExitCode encode(const Arguments& args) {
    const fs::path out = run_folder(args);
    return with_progress(args, true, out, [&](const RunOptions& options) {
        return encode_run(out, redraw_overrides(args), options);
    });
}

/// Of a run's folder, or of a scene that is simulated first.
ExitCode sheet(const Arguments& args) {
    SheetOptions wanted;
    wanted.count = small_count("--count", args.count, wanted.count);
    wanted.columns = small_count("--columns", args.columns, wanted.columns);
    wanted.own_size = !args.size.empty();
    thread_count(args.threads);
    fs::path out = args.out;
    Overrides list;
    if (args.scene.empty()) {
        if (args.out.empty())
            refuse("--out is missing: give the folder of a run, or a scene to simulate with --scene");
        if (!args.frames.empty()) wanted.span = frame_span(args.frames);
        list = redraw_overrides(args);
    } else {
        const SceneFile file = scene_for(args);
        out = output_folder(args, file);
        conclude(
            watched(args, false, [&](const RunOptions& options) { return run_scene(file, out, options); }),
            out);
    }
    const fs::path png = args.file.empty() ? RunFolder::open(out).sheet() : fs::path(args.file);
    const SheetSummary made = watched(
        args, true, [&](const RunOptions& options) { return write_sheet(out, png, wanted, list, options); });
    fmt::print("{} in {}x{} pixels: {}\n", plural(made.pictures, "picture"), made.width, made.height,
               made.file.string());
    return ExitCode::good;
}

ExitCode compare_video(const Arguments& args) {
    if (args.runs.size() != 2)
        refuse(
            "compare-video: give the folders of two runs, as in render_cloth compare-video out/a out/b "
            "--file "
            "ab.mp4");
    if (args.file.empty()) refuse("--file is missing: give the movie to write, as in ab.mp4");
    if (fs::path(args.file).extension() != ".mp4")
        refuse(fmt::format("--file {}: give a name.mp4", args.file));
    std::array<std::string, 2> labels{args.runs[0], args.runs[1]};
    if (!args.labels.empty()) {
        const auto given = split(args.labels, ',');
        if (given.size() != 2)
            refuse(fmt::format("--labels {}: give two texts, as in before,after", args.labels));
        labels = {given[0], given[1]};
    }
    const ComparisonSummary made = watched(args, true, [&](const RunOptions& options) {
        return write_comparison({args.runs[0], args.runs[1]}, args.file, labels, redraw_overrides(args),
                                options);
    });
    fmt::print("{} of {}x{} at {:g} frames/s: {}\n", plural(made.frames, "frame"), made.width, made.height,
               made.playback_rate, args.file);
    return ExitCode::good;
}

ExitCode export_mesh(const Arguments& args) {
    const fs::path out = run_folder(args);
    const auto frame = number<std::int64_t>(args.frame);
    if (args.frame.empty()) refuse("--frame is missing: give the number of a kept frame");
    if (!frame || *frame < 0) refuse(fmt::format("--frame {}: give a whole number, 0 or more", args.frame));
    if (args.format != "obj" && args.format != "ply")
        refuse(fmt::format("--format {}: give obj or ply", args.format.empty() ? "is missing" : args.format));
    if (args.file.empty()) refuse("--file is missing: give the mesh file to write");
    export_frame(out, *frame, args.format == "obj" ? MeshFormat::obj : MeshFormat::ply, args.file);
    fmt::print("frame {} as {}: {}\n", *frame, args.format, args.file);
    return ExitCode::good;
}

fs::path golden_folder(const Arguments& args, const SceneFile& file) {
    return (args.golden.empty() ? fs::path(CLOTH_GOLDEN_DIR) : fs::path(args.golden)) / file.name;
}

ExitCode compare(const Arguments& args) {
    const int threads = thread_count(args.threads);
    const SceneFile file = scene_for(args);
    const GoldenResult result = compare_golden(file, golden_folder(args, file), output_folder(args, file),
                                               threads, gl_library(args.gl));
    fmt::print("{}report: {}\n", golden_table(result), result.report.string());
    if (!result.passed)
        throw Error(
            ExitCode::golden_mismatch,
            fmt::format("{} differs from its goldens, see {}; if the change is wanted: render_cloth bless {}",
                        file.name, result.report.string(), args.scene));
    return ExitCode::good;
}

ExitCode bless(const Arguments& args) {
    const int threads = thread_count(args.threads);
    const SceneFile file = scene_for(args);
    const fs::path golden = golden_folder(args, file);
    const GoldenResult result =
        bless_golden(file, golden, output_folder(args, file), threads, gl_library(args.gl));
    if (result.rows.empty())
        fmt::print("{}: nothing to compare with\n", file.name);
    else
        fmt::print("old against new:\n{}", golden_table(result));
    fmt::print("{}: goldens written to {}\n", file.name, golden.string());
    return ExitCode::good;
}

ExitCode list(const Arguments& args) {
    if (args.what == "fabrics") {
        if (args.name.empty()) fmt::print("{}", fabric_table());
        if (args.sources && args.name.empty()) fmt::print("\n");
        if (args.sources || !args.name.empty()) fmt::print("{}", fabric_sources(args.name));
        if (!args.sources && args.name.empty())
            fmt::print(
                "\nwhere each number comes from: render_cloth list fabrics --sources, or list fabrics "
                "NAME\n");
        return ExitCode::good;
    }
    if (args.what != "scenes" && args.what != "keys")
        refuse(fmt::format("list {}: give scenes, fabrics or keys", args.what));
    if (!args.name.empty() || args.sources)
        refuse(fmt::format("list {} takes no name and no --sources; fabrics do", args.what));
    if (args.what == "keys") {
        fmt::print("{}", key_reference());
        return ExitCode::good;
    }
    for (const auto& [name, description] : list_scenes()) fmt::print("{:<16}{}\n", name, description);
    return ExitCode::good;
}

/// The checks that the arguments ask for, and their parameters.
std::vector<validation::Check> wanted_checks(const Arguments& args, validation::Parameters& parameters) {
    std::vector<validation::Check> wanted;
    std::string known;
    for (const validation::Check& check : validation::checks()) {
        known += (known.empty() ? "" : ", ") + check.name;
        if (args.name.empty() || args.name == check.name) wanted.push_back(check);
    }
    if (wanted.empty()) refuse(fmt::format("validate {}: unknown check; known: {}", args.name, known));
    const auto belongs = [&](const char* parameter) {
        if (args.name.empty())
            refuse(
                fmt::format("--{0}: give the check that it belongs to, as in render_cloth "
                            "validate CHECK --{0} …",
                            parameter));
        const auto& has = wanted.front().parameters;
        if (std::find(has.begin(), has.end(), parameter) == has.end()) {
            refuse(fmt::format("validate {}: has no --{}", args.name, parameter));
        }
    };
    if (!args.gamma.empty()) {
        belongs("gamma");
        parameters.gamma = number<double>(args.gamma);
        if (!parameters.gamma || !(*parameters.gamma >= 1e-3 && *parameters.gamma <= 1e5))
            refuse(fmt::format("--gamma {}: give a number, 0.001 … 100000", args.gamma));
    }
    if (!args.resolution.empty()) {
        belongs("resolution");
        parameters.resolution = number<int>(args.resolution);
        if (!parameters.resolution || *parameters.resolution < 4 || *parameters.resolution > 2000)
            refuse(fmt::format("--resolution {}: give a whole number, 4 … 2000", args.resolution));
    }
    if (!args.fabric.empty()) {
        belongs("fabric");
        if (!find_fabric(args.fabric))
            refuse(fmt::format("--fabric {}: unknown; render_cloth list fabrics names them", args.fabric));
        parameters.fabric = args.fabric;
    }
    return wanted;
}

ExitCode validate_physics(const Arguments& args) {
    validation::Parameters parameters;
    const auto wanted = wanted_checks(args, parameters);
    const fs::path plots = args.plots.empty() ? fs::path("out") / "validation" : fs::path(args.plots);
    int bad = 0, plots_written = 0;
    fmt::print("{}", validation::table_head(args.markdown));
    for (const validation::Check& check : wanted) {
        if (!args.quiet && isatty(STDERR_FILENO)) fmt::print(stderr, "\r{} …\033[K", check.name);
        validation::Outcome outcome;
        try {
            outcome = check.run(parameters);
        } catch (const std::exception& e) {
            throw Error(ExitCode::not_converged, fmt::format("validate {}: {}", check.name, e.what()));
        }
        if (!args.quiet && isatty(STDERR_FILENO)) fmt::print(stderr, "\r\033[K");
        for (const validation::Finding& finding : outcome.findings) {
            fmt::print("{}", validation::table_line(finding, args.markdown));
            bad += !finding.good();
        }
        std::fflush(stdout);
        for (const validation::Plot& plot : outcome.plots) {
            fs::create_directories(plots);
            write_file(plots / (plot.name + ".svg"), validation::to_svg(plot));
            ++plots_written;
        }
    }
    if (plots_written > 0 && !args.markdown) fmt::print("plots: {}\n", plots.string());
    if (bad > 0)
        throw Error(ExitCode::other,
                    fmt::format("validate: {} outside of tolerance", plural(bad, "finding")));
    return ExitCode::good;
}

ExitCode version(const Arguments& args) {
    const auto attempt = [](auto&& ask) -> std::string {
        try {
            return ask();
        } catch (const std::exception& e) {
            return std::string("not available: ") + e.what();
        }
    };
    fmt::print("render_cloth {}\ncompiler: {}\nbuild: {}\nrenderer: {}\nencoder: {}\n", CLOTH_VERSION,
#if defined(__clang__)
               "clang " __clang_version__,
#else
               "g++ " __VERSION__,
#endif
               build_fingerprint(),
               attempt([&] { return render::Rasterizer(1, gl_library(args.gl)).description(); }),
               attempt(ffmpeg_version));
    return ExitCode::good;
}

// ---------------------------------------------------------------- command line

void add_run_flags(CLI::App& app, Arguments& args) {
    app.add_option("--scene", args.scene, "Scene, by name or TOML file")->type_name("NAME|FILE");
    app.add_option("--frames", args.frames, "Number of frames; frame 0 is the start pose")->type_name("N");
    app.add_option("--out", args.out, "Folder of the run (default: out/NAME)")->type_name("DIR");
    app.add_option("--size", args.size, "Size of the pictures")->type_name("WxH");
    app.add_option("--fps", args.fps, "Frames per second of the movie")->type_name("F");
}

void add_common_flags(CLI::App& app, Arguments& args) {
    app.add_option("--set", args.set, "Override a key of the scene; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);
    app.add_option("--threads", args.threads, "Threads (default: all cores); the result is the same for any")
        ->type_name("N");
    app.add_option("--gl", args.gl, "Library that draws (default: auto, OSMesa where it is there)")
        ->type_name("egl|osmesa|auto");
    app.add_flag("--quiet", args.quiet, "No progress");
    app.add_flag("--no-video", args.no_video, "Pictures only, no MP4");
}

void add_annotation_flags(CLI::App& app, Arguments& args) {
    app.add_flag("--caption", args.caption, "Scene, time and frame in the picture");
    app.add_option("--shade", args.shade, "Colours for " + name_list(vertex_field_names()))
        ->type_name("WHAT");
    app.add_option("--shade-range", args.shade_range, "Ends of the colours (default: of the whole run)")
        ->type_name("LOW:HIGH");
    app.add_flag("--wireframe", args.wireframe, "The edges of the simulated triangles");
    app.add_option("--ids", args.ids, "Vertex and triangle numbers at a pixel")->type_name("X,Y[,R]");
    app.add_option("--curves", args.curves, "Draw curves of " + name_list(curve_names))->type_name("A,B,…");
    app.add_option("--motion-blur", args.motion_blur, "Each frame is the mean of K pictures")->type_name("K");
}

ExitCode dispatch(int argc, char** argv) {
    Arguments args;
    CLI::App app("Simulates cloth, draws every frame, and makes a movie of it.", "render_cloth");
    app.allow_extras();  // told of below, in one line
    app.get_formatter()->column_width(34);
    app.add_flag("--version", args.version, "Version, compiler, build fingerprint, GL renderer");
    add_run_flags(app, args);
    add_common_flags(app, args);
    add_annotation_flags(app, args);

    const auto verb = [&](const char* name, const char* what) { return app.add_subcommand(name, what); };
    CLI::App* run_verb = verb("run", "Simulate, draw and encode (the default)");
    CLI::App* simulate_verb = verb("simulate", "States only; the same flags");
    CLI::App* render_verb = verb("render", "Pictures and movie from the kept states of a run");
    CLI::App* encode_verb = verb("encode", "The movie from the kept pictures of a run");
    CLI::App* export_verb = verb("export", "A kept frame's state as a mesh file");
    CLI::App* compare_verb = verb("compare", "Run a scene and compare with its golden frames");
    CLI::App* bless_verb = verb("bless", "Run a scene and renew its golden frames");
    CLI::App* sheet_verb = verb("sheet", "Pictures of a run, or of a scene, in one PNG");
    CLI::App* compare_video_verb = verb("compare-video", "Two runs beside each other in one movie");
    CLI::App* list_verb = verb("list", "The scenes, the fabrics, or the keys of scene files");
    args.what = "scenes";
    list_verb->add_option("what", args.what, "scenes (the default), fabrics or keys")
        ->type_name("scenes|fabrics|keys");
    list_verb->add_option("name", args.name, "One fabric with the sources of its values")->type_name("NAME");
    list_verb->add_flag("--sources", args.sources, "Fabrics with the sources of all values");
    CLI::App* validate_verb = verb("validate", "Check the physics against theory: a table and plots");
    validate_verb->add_option("check", args.name, "One check; all of them without")->type_name("CHECK");
    validate_verb->add_option("--gamma", args.gamma, "cantilever: this load alone")->type_name("G");
    validate_verb->add_option("--resolution", args.resolution, "Elements along the longest side")
        ->type_name("N");
    validate_verb->add_option("--fabric", args.fabric, "drape: this fabric alone")->type_name("NAME");
    validate_verb->add_option("--plots", args.plots, "Folder for plots (default: out/validation)")
        ->type_name("DIR");
    validate_verb->add_flag("--markdown", args.markdown, "The table in Markdown");
    validate_verb->add_flag("--quiet", args.quiet, "No progress");
    for (CLI::App* each : {run_verb, simulate_verb, sheet_verb}) {
        add_run_flags(*each, args);
        add_common_flags(*each, args);
    }
    for (CLI::App* each : {run_verb, render_verb, sheet_verb, compare_video_verb})
        add_annotation_flags(*each, args);
    sheet_verb->add_option("--count", args.count, "Number of pictures (default: 12)")->type_name("N");
    sheet_verb->add_option("--columns", args.columns, "Pictures a row")->type_name("N");
    sheet_verb->add_option("--file", args.file, "The PNG (default: sheet.png in the run's folder)")
        ->type_name("F");
    compare_video_verb->add_option("runs", args.runs, "Folders of two runs")->type_name("A B");
    compare_video_verb->add_option("--file", args.file, "The MP4")->type_name("F");
    compare_video_verb->add_option("--labels", args.labels, "Texts at the top (default: the folders)")
        ->type_name("A,B");
    compare_video_verb->add_option("--size", args.size, "Size of each run's pictures")->type_name("WxH");
    compare_video_verb->add_option("--fps", args.fps, "Frames per second of the movie")->type_name("F");
    add_common_flags(*compare_video_verb, args);
    for (CLI::App* each : {render_verb, encode_verb}) {
        each->add_option("--out", args.out, "Folder of the run")->type_name("DIR");
        each->add_option("--fps", args.fps, "Frames per second of the movie")->type_name("F");
        add_common_flags(*each, args);
    }
    render_verb->add_option("--frames", args.frames, "Draw the frames A to B-1 only")->type_name("A:B");
    render_verb->add_option("--size", args.size, "Size of the pictures")->type_name("WxH");
    export_verb->add_option("--out", args.out, "Folder of the run")->type_name("DIR");
    export_verb->add_option("--frame", args.frame, "Number of the frame")->type_name("K");
    export_verb->add_option("--format", args.format, "obj or ply")->type_name("obj|ply");
    export_verb->add_option("--file", args.file, "Mesh file to write")->type_name("F");
    for (CLI::App* each : {compare_verb, bless_verb}) {
        each->add_option("scene", args.scene, "Scene, by name or TOML file")->type_name("SCENE");
        each->add_option("--golden", args.golden, "Folder with a folder of goldens for each scene")
            ->type_name("DIR");
        each->add_option("--out", args.out, "Folder of the report (default: out/NAME)")->type_name("DIR");
        each->add_option("--threads", args.threads, "Threads (default: all cores)")->type_name("N");
    }
    for (CLI::App* each : {compare_verb, bless_verb})
        each->add_option("--gl", args.gl, "Library that draws (default: auto)")->type_name("egl|osmesa|auto");
    compare_verb->add_option("--set", args.set, "Override a key of the scene; may be repeated")
        ->type_name("KEY=VALUE")
        ->allow_extra_args(false);

    try {
        app.parse(argc, argv);
    } catch (const CLI::Success& help) {
        app.exit(help);
        return ExitCode::good;
    } catch (const CLI::ParseError& e) {
        refuse(std::string(e.what()) + "; see render_cloth --help");
    }
    if (const std::vector<std::string> extra = app.remaining(true); !extra.empty()) {
        if (extra.front().starts_with("-"))
            refuse("unknown option " + extra.front() + "; see render_cloth --help");
        if (app.get_subcommands().empty())
            refuse("unknown verb \"" + extra.front() +
                   "\"; known: run, simulate, render, encode, sheet, compare-video, export, compare, bless, "
                   "list, validate");
        refuse("unexpected argument \"" + extra.front() + "\"; see render_cloth --help");
    }
    for (const char* name : {"compare", "bless"})
        if (app.got_subcommand(name) && args.scene.empty())
            refuse(fmt::format("{}: the scene is missing, as in render_cloth {} drape_sphere", name, name));

    if (args.version) return version(args);
    if (*list_verb) return list(args);
    if (*validate_verb) return validate_physics(args);
    if (*sheet_verb) return sheet(args);
    if (*compare_video_verb) return compare_video(args);
    if (*render_verb) return render(args);
    if (*encode_verb) return encode(args);
    if (*export_verb) return export_mesh(args);
    if (*compare_verb) return compare(args);
    if (*bless_verb) return bless(args);
    return run(args, !*simulate_verb);
}

}  // namespace

int main(int argc, char** argv) {
    // A file size limit then shows as a write error with its cause.
    std::signal(SIGXFSZ, SIG_IGN);
    ExitCode code = ExitCode::other;
    std::string line;
    try {
        return static_cast<int>(dispatch(argc, argv));
    } catch (const Error& e) {
        code = e.code;
        line = e.what();
    } catch (const OverlapError& e) {
        code = ExitCode::start_overlap;
        line = e.what();
    } catch (const SceneError& e) {
        code = ExitCode::invalid_scene;
        line = e.key.empty() ? e.what() : e.key + ": " + e.what();
    } catch (const std::exception& e) {
        line = e.what();
    }
    std::fflush(stdout);
    fmt::print(stderr, "render_cloth: {}\n", line);
    return static_cast<int>(code);
}
