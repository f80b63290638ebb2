#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <exception>
#include <memory>
#include <optional>

#include "base/memory.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/formats/video.h"
#include "pipeline/picture/overlap_picture.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/run.h"
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

/// Simulates and keeps the states of a run; the start pose is its frame 0.
void simulate_frames(Simulation& simulation, const SceneFile& file, const RunFolder& folder, Stages& stages,
                     StatesMade& made) {
    for (std::int64_t frame = 0; frame < file.output.frames && stages.going_on(); ++frame) {
        FrameRecord record;
        if (frame > 0) {
            const TimedScope watch(made.simulate);
            record.report = simulation.advance_frame();
        }
        if (record.report.stopped) return;
        record.report.frame = frame;
        if (const std::string fault = frame_fault(simulation, record.report, folder.root()); !fault.empty()) {
            stages.fail_later(
                std::make_exception_ptr(Error(ExitCode::not_converged, file.name + ": " + fault)));
            return;
        }
        auto state = std::make_shared<State>(simulation.state());
        state->frame = frame;
        {
            const TimedScope watch(made.store);
            write_state(*state, folder.state(frame));
            record.state_hash = state_hash(*state);
        }
        made.records.push_back(std::move(record));
        stages.step(&Progress::simulated);
        stages.deliver(std::move(state));
    }
}

// ---------------------------------------------------------------- the run

/// Pictures that have to know of the whole run are drawn after it, all others while it is simulated.
std::exception_ptr make_frames(Simulation& simulation, const SceneFile& file, const RunFolder& folder,
                               std::optional<render::Rasterizer>& rasterizer, const RunOptions& options,
                               RunSummary& summary) {
    const Model& model = simulation.model();
    const auto simulate = [&](Stages& stages, StatesMade& made) {
        simulate_frames(simulation, file, folder, stages, made);
    };
    const auto draw = [&](RunFacts facts, const Stages::Produce& produce) {
        const StagesResult drawn = draw_run({folder, file, model, *rasterizer, options}, std::move(facts),
                                            summary.frames, options.movie, produce);
        add(summary, drawn, folder);
        return drawn.failure;
    };
    if (rasterizer && !needs_whole_run(file)) return draw(facts_of(file), simulate);

    const StagesResult simulated = Stages(folder, options, summary.frames).run(simulate, {}, nullptr);
    add(summary, simulated, folder);
    if (!rasterizer || options.stopping()) return simulated.failure;
    const std::exception_ptr drawing = failure_of([&] {
        write_report(folder, file, model, summary, "simulated");  // curves are read from it
        const auto failure = draw(survey_run(folder, file, model, options.stop),
                                  kept_states(state_reader(folder, model), folder.kept_states()));
        if (failure) std::rethrow_exception(failure);
    });
    return simulated.failure ? simulated.failure : drawing;
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
    }
    throw Error(ExitCode::start_overlap, line);
}

}  // namespace

RunSummary run_scene(const SceneFile& file, const fs::path& out, const RunOptions& options) {
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

    const RunFolder folder = start_run(out, file, simulation.model());
    std::exception_ptr failure;
    const std::exception_ptr thrown =
        failure_of([&] { failure = make_frames(simulation, file, folder, rasterizer, options, summary); });
    if (thrown) failure = thrown;
    summary.interrupted = options.stopping() && (summary.states < summary.frames ||
                                                 (options.pictures && summary.images < summary.frames) ||
                                                 (options.movie && summary.movie.empty()));

    const std::string outcome = failure ? line_of(failure) : summary.interrupted ? "interrupted" : "complete";
    const std::exception_ptr unwritten =
        failure_of([&] { write_report(folder, file, simulation.model(), summary, outcome); });
    if (!failure) failure = unwritten;  // else a full disk has been told of already
    if (!failure) return summary;
    try {
        std::rethrow_exception(failure);
    } catch (const OverlapError& overlap) {
        show_overlap(overlap, file, simulation, folder, rasterizer, options);
    }
}

}  // namespace cloth::pipeline
