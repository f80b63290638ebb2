#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>

#include "base/memory.h"
#include "base/stopwatch.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/folder_lock.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/formats/video.h"
#include "pipeline/picture/overlap_picture.h"
#include "pipeline/run/branch.h"
#include "pipeline/run/certificate.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run.h"
#include "pipeline/run/run_page.h"
#include "pipeline/scene_file/memory_need.h"
#include "sim/simulation.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// What `work` throws; nothing where it does not.
template <class Work>
std::exception_ptr failure_of(Work work) {
    try {
        work();
        return nullptr;
    } catch (...) {
        return std::current_exception();
    }
}

std::string line_of(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const std::exception& e) {
        return e.what();
    }
}

// ---------------------------------------------------------------- frames

/// Why a step did not get to its end: what stood in its way, else what is farthest from balance.
std::string why_not_converged(const Simulation& simulation, const FrameReport& report) {
    const SimulationDesc& settings = simulation.model().scene.simulation;
    const State& state = simulation.state();
    const int parts = 1 << settings.retries;
    const std::string obstacle = report.obstacle ? words(simulation.model(), *report.obstacle) : "";
    if (!report.placed && report.obstacle) {
        return fmt::format(
            "from {:.6g} s on pins and colliders cannot get to where they are to be at {:.6g} s: {}",
            state.time, report.obstacle->time, obstacle);
    }
    if (!report.placed) {
        return fmt::format(
            "from {:.6g} s on, even in a step cut into {} parts, pins and colliders cannot get to "
            "where they are to be",
            state.time, parts);
    }
    std::string text =
        fmt::format("the step from {:.6g} s did not converge, not even cut into {} parts", state.time, parts);
    if (std::isfinite(report.residual) && report.residual > 0.0) {
        text +=
            fmt::format(": residual {:.2g}, must be {:.2g}", report.residual, settings.stopping().tolerance);
    }
    if (report.worst_vertex) {
        const Vec3 place = state.positions.segment<3>(3 * *report.worst_vertex);
        const auto& cloths = simulation.model().cloths;
        const auto cloth = std::find_if(cloths.rbegin(), cloths.rend(), [&](const ClothRange& range) {
            return range.first_vertex <= *report.worst_vertex;
        });
        text += fmt::format("; farthest from balance is vertex {} of cloth {} at ({:.4g}, {:.4g}, {:.4g})",
                            *report.worst_vertex - cloth->first_vertex, cloth->name, place.x(), place.y(),
                            place.z());
    }
    return text + (obstacle.empty() ? "" : "; " + obstacle);
}

/// Why the run cannot go on from the frame that has been made; empty: it can.
std::string frame_fault(const Simulation& simulation, const FrameReport& report, const fs::path& out) {
    const std::int64_t frame = report.frame;
    if (const std::string fault = state_fault(simulation.state()); !fault.empty()) {
        const std::string kept =
            frame == 0 ? "there is no good frame"
                       : fmt::format("the last good frame is {}; frames up to it are kept in {}", frame - 1,
                                     out.string());
        return fmt::format(
            "the simulation diverged: in frame {} {}; {}; a smaller simulation.time_step or softer cloth may "
            "help",
            frame, fault, kept);
    }
    if (report.converged) return {};
    return fmt::format("frame {}: {}; frames up to {} are kept in {}", frame,
                       why_not_converged(simulation, report), frame - 1, out.string());
}

/// A run under way: what was kept of it, and what is told of what is made.
struct Making {
    Simulation& simulation;
    const SceneFile& file;
    const StartedRun& started;
    std::optional<render::Rasterizer>& rasterizer;
    const RunOptions& options;

    const RunFolder& folder() const { return started.folder; }
    const RunPlan& plan() const { return started.plan; }
    bool all_drawn() const { return plan().kept_pictures() == plan().frames; }
    bool wants_movie() const { return options.movie && !plan().has_movie; }

    KeptPictures pictures() const {
        return {[this](std::int64_t frame) { return plan().has_picture(frame); },
                [this](std::int64_t frame, double draw, double png) {
                    started.ledger->add_picture(frame, {plan().pictures.at(static_cast<std::size_t>(frame)),
                                                        file_fingerprint(folder().image(frame)),
                                                        rasterizer->description(), draw, png});
                }};
    }
};

/// Simulates and keeps the states of a run that are not there; the start pose is its frame 0.
void simulate_frames(const Making& run, Stages& stages, StatesMade& made) {
    const StateReader read = state_reader(run.folder(), run.simulation.model());
    for (std::int64_t frame = 0; frame < run.plan().frames && stages.going_on(); ++frame) {
        if (run.plan().has_state(frame)) {
            made.records.push_back(run.plan().kept.states.at(frame).record);
            ++made.kept;
            stages.step(&Progress::simulated);
            if (stages.has_picture(frame))
                stages.deliver_kept(frame);
            else
                stages.deliver(std::make_shared<State>(read_kept(read, frame)));
            continue;
        }
        FrameRecord record;
        if (frame > 0) {
            const TimedScope watch(record.simulate);
            // Exactly where it would be had it come here by itself.
            if (run.simulation.state().frame != frame - 1) run.simulation.restore(read_kept(read, frame - 1));
            record.report = run.simulation.advance_frame();
        }
        made.simulate += record.simulate;
        if (record.report.stopped) return;
        record.report.frame = frame;
        if (const std::string fault = frame_fault(run.simulation, record.report, run.folder().root());
            !fault.empty()) {
            stages.fail_later(
                std::make_exception_ptr(Error(ExitCode::not_converged, run.file.name + ": " + fault)));
            return;
        }
        auto state = std::make_shared<State>(run.simulation.state());
        state->frame = frame;
        {
            const TimedScope watch(record.store);
            const std::string bytes =
                write_state(*state, run.folder().state(frame), Compression::fast, run.options.sync);
            record.state_hash = state_hash(*state);
            record.host = host_name();
            run.started.ledger->add_state(
                frame, {run.plan().states.at(static_cast<std::size_t>(frame)), bytes, record});
        }
        made.store += record.store;
        made.records.push_back(std::move(record));
        stages.step(&Progress::simulated);
        if (stages.has_picture(frame))
            stages.deliver_kept(frame);
        else
            stages.deliver(std::move(state));
    }
}

// ---------------------------------------------------------------- the run

/// Pictures that have to know of the whole run are drawn after it, all others while it is simulated.
std::exception_ptr make_frames(const Making& run, RunSummary& summary) {
    const Model& model = run.simulation.model();
    const auto simulate = [&](Stages& stages, StatesMade& made) { simulate_frames(run, stages, made); };
    const auto draw = [&](RunFacts facts, const Stages::Produce& produce) {
        const StagesResult drawn =
            draw_run({run.folder(), run.file, model, *run.rasterizer, run.options}, std::move(facts),
                     summary.frames, run.wants_movie(), produce, run.pictures());
        add(summary, drawn, run.folder());
        if (drawn.encoded.finished)
            run.started.ledger->add_movie(
                summary.movie.filename().string(),
                {run.plan().movie_key, file_fingerprint(summary.movie), summary.encoder});
        return drawn.failure;
    };
    const bool drawing = run.rasterizer && (!run.all_drawn() || run.wants_movie());
    if (drawing && !needs_whole_run(run.file)) return draw(facts_of(run.file), simulate);

    const StagesResult simulated =
        Stages(run.folder(), run.options, summary.frames).run(simulate, {}, nullptr);
    add(summary, simulated, run.folder());
    if (run.rasterizer && !drawing) summary.kept_images = run.plan().kept_pictures();
    if (!drawing || run.options.stopping()) return simulated.failure;
    const std::exception_ptr failure = failure_of([&] {
        const auto undrawn = draw(survey_run(run.folder(), run.file, model, run.options.stop),
                                  kept_states(state_reader(run.folder(), model), run.folder().kept_states()));
        if (undrawn) std::rethrow_exception(undrawn);
    });
    return simulated.failure ? simulated.failure : failure;
}

/// What drawing took, for who asks frame by frame.
void add_drawing_times(RunSummary& summary, const RunFolder& folder) {
    const LedgerEntries ledger = read_ledger(folder.ledger());
    for (FrameRecord& record : summary.records) {
        const auto picture = ledger.pictures.find(record.report.frame);
        if (picture == ledger.pictures.end()) continue;
        record.draw = picture->second.draw;
        record.png = picture->second.png;
    }
}

Wanted wanted_of(const SceneFile& file, const Model& model, const RunOptions& options,
                 const std::string& renderer, const Branch* branch) {
    return {file,
            model,
            file.output.frames,
            options.pictures,
            options.pictures && options.movie,
            renderer,
            branch ? branch->trunk : Trunk(),
            playback_rate(file)};
}

/// Throws the overlap anew, with a picture of its place where one can be drawn.
[[noreturn]] void show_overlap(const OverlapError& overlap, const SceneFile& file,
                               const Simulation& simulation, const RunFolder& folder,
                               std::optional<render::Rasterizer>& rasterizer, const RunOptions& options) {
    std::string line = overlap.what();
    if (const std::int64_t last = simulation.state().frame; simulation.state().step > 0)
        line = fmt::format("{}: frame {}: {}; frames up to {} are kept in {}", file.name, last + 1, line,
                           last, folder.root().string());
    const fs::path path = folder.overlap();
    if (!overlap.triangles.empty()) {
        const std::exception_ptr failure = failure_of([&] {
            if (!rasterizer) rasterizer.emplace(options.threads, options.gl);
            render::write_png(
                draw_overlap(file, simulation.model(), simulation.state(), overlap, *rasterizer), path);
        });
        line += failure ? "; no picture of it: " + line_of(failure) : "; in red in " + path.string();
        if (!failure) {
            RunOptions quiet = options;
            quiet.tell = nullptr;
            leave_run_page(folder.root(), quiet);  // with the picture
        }
    }
    throw Error(ExitCode::start_overlap, line);
}

}  // namespace

RunSummary run_scene(const SceneFile& file, const fs::path& out, const RunOptions& options,
                     const Branch* branch) {
    // What can be refused is refused first.
    if (file.output.frames < 1) throw Error(ExitCode::usage, "a run needs at least one frame");
    MemoryNeed need = simulation_need(file.scene);
    require_memory(need, available_memory());
    if (options.pictures) {
        const MemoryNeed pictures = picture_need(file);
        if (pictures.bytes > need.bytes) need.key = pictures.key;
        need.bytes += pictures.bytes;
        require_memory(need, available_memory());
    }
    require_place(out, file);
    const Stopwatch wall;
    RunSummary summary = planned(file, file.output.frames);
    if (options.pictures && options.movie) summary.encoder = ffmpeg_version(options.stop);
    Simulation simulation(file.scene, options.threads);
    simulation.stop_on(options.stop);
    std::optional<render::Rasterizer> rasterizer;
    if (options.pictures) {
        rasterizer.emplace(options.threads, options.gl);
        summary.renderer = rasterizer->description();
    } else {
        summary.width = summary.height = 0;
    }

    const Wanted wanted = wanted_of(file, simulation.model(), options, summary.renderer, branch);
    StartedRun started = start_run(out, wanted, options);
    if (branch) share_past(*branch, started);
    const RunFolder& folder = started.folder;
    const RunPlan& plan = started.plan;
    summary.kept_movie = plan.has_movie && options.movie;
    if (summary.kept_movie) summary.movie = folder.movie(file.name);
    const Making making{simulation, file, started, rasterizer, options};
    std::exception_ptr failure;
    const std::exception_ptr thrown = failure_of([&] { failure = make_frames(making, summary); });
    if (thrown) failure = thrown;
    summary.interrupted =
        options.stopping() && (summary.kept_states + summary.states < summary.frames ||
                               (options.pictures && summary.kept_images + summary.images < summary.frames) ||
                               (options.movie && summary.movie.empty()));

    const std::string outcome = failure ? line_of(failure) : summary.interrupted ? "interrupted" : "complete";
    const std::exception_ptr unwritten = failure_of([&] {
        if (started.finished && !failure && fs::exists(folder.report()) && fs::exists(folder.certificate()))
            return;  // they say so already
        add_drawing_times(summary, folder);
        write_report(folder, file, simulation.model(), summary, outcome);
        write_certificate(folder, file, summary, plan.states.at(static_cast<std::size_t>(plan.frames) - 1),
                          outcome);
    });
    if (!failure) failure = unwritten;  // else a full disk has been told of already
    const bool page_good = started.finished && !failure && fs::exists(folder.page());
    if (!page_good && !options.stopping() && summary.kept_states + summary.states > 0) {
        RunOptions quiet = options;
        if (failure) quiet.tell = nullptr;  // one line is enough, and that is the failure's
        leave_run_page(out, quiet);
    }
    summary.times.wall = wall.seconds();
    if (!failure) {
        if (const std::string broken = broken_promises(promises(file.expect, summary.records));
            !broken.empty())
            throw Error(ExitCode::broken_promise,
                        fmt::format("{}: {}; all is kept in {}", file.name, broken, out.string()));
        return summary;
    }
    try {
        std::rethrow_exception(failure);
    } catch (const OverlapError& overlap) {
        show_overlap(overlap, file, simulation, folder, rasterizer, options);
    }
}

std::vector<std::string> explain_run(const SceneFile& file, const fs::path& out, const RunOptions& options) {
    require_place(out, file);
    if (options.fresh) return {"--fresh: all is made anew"};
    const Model model = build_model(file.scene);
    RunPlan plan = plan_run(RunFolder::look(out), wanted_of(file, model, options, "", nullptr));
    plan.parts.insert(plan.parts.end(), plan.warnings.begin(), plan.warnings.end());
    return plan.parts;
}

}  // namespace cloth::pipeline
