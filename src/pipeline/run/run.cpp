#include "pipeline/run/run.h"

#include <fmt/format.h>

#include <toml++/toml.h>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <condition_variable>
#include <cstddef>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <system_error>
#include <thread>
#include <utility>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/formats/video.h"
#include "pipeline/picture/overlap_picture.h"
#include "pipeline/picture/picture.h"
#include "pipeline/picture/survey.h"
#include "render/raster/rasterizer.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

class Stopwatch {
  public:
    double seconds() const {
        return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
    }

  private:
    std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

/// A bounded queue between two stages: a fast stage waits for a slow one instead of filling the memory.
template <class T>
class Channel {
  public:
    /// False where nobody will take it any more.
    bool push(T item) {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return items_.size() < capacity || closed_; });
        if (closed_) return false;
        items_.push_back(std::move(item));
        changed_.notify_all();
        return true;
    }
    /// Nothing once it is closed and empty.
    std::optional<T> pop() {
        std::unique_lock lock(mutex_);
        changed_.wait(lock, [&] { return !items_.empty() || closed_; });
        if (items_.empty()) return std::nullopt;
        T item = std::move(items_.front());
        items_.pop_front();
        changed_.notify_all();
        return item;
    }
    /// No more will come.
    void close() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        changed_.notify_all();
    }
    /// No more will come, and what waits is dropped.
    void abandon() {
        const std::lock_guard lock(mutex_);
        closed_ = true;
        items_.clear();
        changed_.notify_all();
    }

  private:
    static constexpr std::size_t capacity = 3;
    std::mutex mutex_;
    std::condition_variable changed_;
    std::deque<T> items_;
    bool closed_ = false;
};

using StatePtr = std::shared_ptr<const State>;
struct Picture {
    std::int64_t frame;
    std::shared_ptr<const render::Image> image;
};

/// The stages of one run. The caller's thread draws (a GL context belongs to one thread); one thread each
/// brings the states, writes PNGs, and feeds the encoder.
class Stages {
  public:
    Stages(const RunFolder& folder, const RunOptions& options, RunSummary& summary)
        : folder_(folder), options_(options), summary_(summary) {
        progress_.frames = summary.frames;
    }

    bool stopping() const { return options_.stop != nullptr && options_.stop->load(); }

    void step(std::int64_t Progress::*stage) {
        const std::lock_guard lock(progress_mutex_);
        ++(progress_.*stage);
        if (options_.progress) options_.progress(progress_);
    }

    /// A failure after which nothing more is worth doing.
    void fail_now(std::exception_ptr failure) {
        {
            const std::lock_guard lock(failure_mutex_);
            if (!failure_) failure_ = std::move(failure);
        }
        states_.abandon();
        to_png_.abandon();
        to_movie_.abandon();
    }
    /// A failure that lets the other stages finish.
    void fail_later(std::exception_ptr failure) {
        const std::lock_guard lock(failure_mutex_);
        if (!late_failure_) late_failure_ = std::move(failure);
    }

    /// `produce` hands states over in order of frames until it returns; `draw` may be empty.
    /// Returns the failure that the caller is to throw, if any.
    std::exception_ptr run(const std::function<void(Stages&)>& produce,
                           const std::function<render::Image(const State&)>& draw, VideoWriter* movie) {
        drawing_ = static_cast<bool>(draw);
        std::thread producer([&] {
            guarded([&] { produce(*this); });
            states_.close();
        });
        std::thread png_writer, encoder;
        if (draw) png_writer = std::thread([&] { guarded([&] { write_pictures(); }); });
        if (movie != nullptr) encoder = std::thread([&] { feed(*movie); });
        if (draw) guarded([&] { draw_states(draw, movie != nullptr); });
        to_png_.close();
        to_movie_.close();
        for (std::thread* thread : {&producer, &png_writer, &encoder})
            if (thread->joinable()) thread->join();
        summary_.times.wall = wall_.seconds();
        return failure_ ? failure_ : late_failure_;
    }

    /// False where the states are no longer wanted.
    bool deliver(StatePtr state) { return !drawing_ || states_.push(std::move(state)); }

  private:
    template <class Work>
    void guarded(Work work) {
        try {
            work();
        } catch (...) {
            fail_now(std::current_exception());
        }
    }

    void draw_states(const std::function<render::Image(const State&)>& draw, bool to_movie) {
        while (const auto state = states_.pop()) {
            if (stopping()) {
                states_.abandon();
                break;
            }
            const Stopwatch watch;
            const Picture picture{(*state)->frame, std::make_shared<const render::Image>(draw(**state))};
            summary_.times.draw += watch.seconds();
            step(&Progress::drawn);
            if (!to_png_.push(picture)) break;
            if (to_movie) to_movie_.push(picture);
        }
    }

    void write_pictures() {
        while (const auto picture = to_png_.pop()) {
            const Stopwatch watch;
            render::write_png(*picture->image, folder_.image(picture->frame));
            summary_.times.png += watch.seconds();
            ++summary_.images;
            step(&Progress::written);
        }
    }

    /// After a failure the pictures are taken and dropped: the PNGs go on.
    void feed(VideoWriter& movie) {
        std::int64_t added = 0;
        bool good = true;
        const auto attempt = [&](auto&& work) {
            const Stopwatch watch;
            try {
                work();
            } catch (...) {
                good = false;
                fail_later(std::current_exception());
            }
            summary_.times.encode += watch.seconds();
        };
        while (const auto picture = to_movie_.pop()) {
            if (good) attempt([&] { movie.add(*picture->image); });
            if (!good) continue;
            ++added;
            step(&Progress::encoded);
        }
        // A movie of a part of the run would pass for the whole.
        if (good && added == summary_.frames) {
            attempt([&] { movie.finish(); });
            if (good) summary_.movie = folder_.movie(summary_.scene);
        }
    }

    const RunFolder& folder_;
    const RunOptions& options_;
    RunSummary& summary_;  // each field is written by one stage
    Stopwatch wall_;
    std::mutex progress_mutex_, failure_mutex_;
    Progress progress_;
    std::exception_ptr failure_, late_failure_;
    bool drawing_ = false;
    Channel<StatePtr> states_;
    Channel<Picture> to_png_, to_movie_;
};

// ---------------------------------------------------------------- a run's scene

/// The resolved scene with the meshes and textures that it names beside it: the folder can be moved, and the
/// originals may go.
void keep_scene(const RunFolder& folder, const SceneFile& file) {
    std::string text = file.resolved;
    struct Edit {
        std::size_t begin, end;
        std::string text;
    };
    std::vector<Edit> edits;
    const auto offset = [&](toml::source_position place) {
        std::size_t at = 0;
        for (toml::source_index line = 1; line < place.line; ++line) at = text.find('\n', at) + 1;
        // Columns count code points; continuation bytes of UTF-8 belong to the one before.
        for (toml::source_index column = 1; column < place.column; ++column) do
                ++at;
            while (at < text.size() && (static_cast<unsigned char>(text[at]) & 0xc0) == 0x80);
        return at;
    };
    const toml::table root = toml::parse(text);
    const auto replace = [&](const toml::node& entry, const char* key, const std::string& name) {
        const toml::node* node = entry.as_table()->get(key);
        if (node != nullptr && node->is_string())
            edits.push_back({offset(node->source().begin), offset(node->source().end), '"' + name + '"'});
    };
    const auto keep_mesh = [&](const toml::node& entry, const char* key, const char* stem, std::size_t number,
                               const MeshData& mesh) {
        const std::string name = fmt::format("meshes/{}_{:06d}.obj", stem, number);
        fs::create_directories(folder.meshes());
        write_mesh(mesh, MeshFormat::obj, folder.root() / name);
        replace(entry, key, name);
    };
    const auto* cloths = root["cloth"].as_array();
    for (std::size_t c = 0; cloths != nullptr && c < cloths->size(); ++c) {
        const ClothDesc& desc = file.scene.cloths.at(c);
        const toml::node& entry = *cloths->get(c);
        if (desc.mesh) keep_mesh(entry, "mesh", "rest", c, *desc.mesh);
        if (desc.pose)
            keep_mesh(entry, "pose", "pose", c, {*desc.pose, desc.mesh ? desc.mesh->triangles : Triangles()});
        if (const auto& image = file.cloth_looks.at(c).material.image) {
            const std::string name = fmt::format("textures/cloth_{:06d}.png", c);
            fs::create_directories(folder.textures());
            render::write_png(*image, folder.root() / name);
            replace(entry, "texture", name);
        }
    }
    const auto* colliders = root["collider"].as_array();
    for (std::size_t c = 0; colliders != nullptr && c < colliders->size(); ++c) {
        const ColliderDesc& desc = file.scene.colliders.at(c);
        if (desc.mesh) keep_mesh(*colliders->get(c), "mesh", "collider", c, *desc.mesh);
    }
    std::sort(edits.begin(), edits.end(), [](const Edit& a, const Edit& b) { return a.begin > b.begin; });
    for (const Edit& edit : edits) text.replace(edit.begin, edit.end - edit.begin, edit.text);
    write_file(folder.scene(), text);
}

// ---------------------------------------------------------------- report

nlohmann::ordered_json times_json(const StageTimes& times) {
    return {{"simulate", times.simulate}, {"store", times.store},   {"draw", times.draw},
            {"png", times.png},           {"encode", times.encode}, {"wall", times.wall}};
}

void write_report(const RunFolder& folder, const SceneFile& file, const Model& model,
                  const RunSummary& summary, const std::string& outcome) {
    nlohmann::ordered_json report;
    report["scene"] = summary.scene;
    report["outcome"] = outcome;
    report["program"] = {{"version", CLOTH_VERSION},
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
                        {"states", summary.states},
                        {"images", summary.images},
                        {"size_pixel", {summary.width, summary.height}},
                        {"playback_rate_hz", summary.playback_rate},
                        {"movie", summary.movie.filename().string()}};
    report["times_s"] = times_json(summary.times);
    if (file.scene.simulation.contact == ContactKind::barrier) {
        ContactTimes sum;
        for (const FrameRecord& record : summary.records) merge(sum, record.report.contact_times);
        report["contact_times_s"] = {{"detection", sum.detection},
                                     {"assembly", sum.assembly},
                                     {"factorization", sum.factorization},
                                     {"conjugate_gradients", sum.solution},
                                     {"line_search", sum.evaluation}};
    }
    auto frames = nlohmann::ordered_json::array();
    for (const FrameRecord& record : summary.records) {
        const FrameReport& r = record.report;
        frames.push_back(
            {{"frame", r.frame},
             {"steps", r.steps},
             {"converged", r.converged},
             {"iterations", r.iterations},
             {"residual", r.residual},
             {"retries", r.retries},
             {"energy_before_J", r.energy_before},
             {"energy_after_J", r.energy_after},
             {"largest_stretch", r.largest_stretch},
             {"smallest_gap_m", std::isfinite(r.smallest_gap) ? nlohmann::ordered_json(r.smallest_gap)
                                                              : nlohmann::ordered_json()},
             {"largest_penetration_m", std::isfinite(r.smallest_gap)
                                           ? nlohmann::ordered_json(std::max(0.0, -r.smallest_gap))
                                           : nlohmann::ordered_json()},
             {"contacts", r.contacts},
             {"state_hash", record.state_hash}});
    }
    report["frames"] = std::move(frames);
    write_file(folder.report(), report.dump(1) + "\n");
}

/// Redrawing adds to the report of the simulation.
void amend_report(const RunFolder& folder, const RunSummary& summary) {
    nlohmann::ordered_json report;
    try {
        report = nlohmann::ordered_json::parse(read_file(folder.report()));
    } catch (const std::exception&) {
        report = nlohmann::ordered_json::object();
    }
    report["redrawn"] = {{"images", summary.images},
                         {"size_pixel", {summary.width, summary.height}},
                         {"playback_rate_hz", summary.playback_rate},
                         {"renderer", summary.renderer},
                         {"encoder", summary.encoder},
                         {"movie", summary.movie.filename().string()},
                         {"times_s", times_json(summary.times)}};
    write_file(folder.report(), report.dump(1) + "\n");
}

std::string outcome_of(const RunSummary& summary, const std::exception_ptr& failure) {
    if (failure) try {
            std::rethrow_exception(failure);
        } catch (const std::exception& e) {
            return e.what();
        }
    return summary.interrupted ? "interrupted" : "complete";
}

/// Brings kept states to the stages.
std::function<void(Stages&)> state_producer(const RunFolder& folder, std::vector<std::int64_t> frames,
                                            RunSummary& summary) {
    return [&folder, frames = std::move(frames), &summary](Stages& stages) {
        for (const std::int64_t frame : frames) {
            if (stages.stopping()) return;
            const Stopwatch watch;
            auto state = std::make_shared<State>(read_state(folder.state(frame)));
            summary.times.store += watch.seconds();
            if (!stages.deliver(std::move(state))) return;
        }
    };
}

VideoOptions video_options(const SceneFile& file, const RunOptions& options) {
    return {playback_rate(file), file.output.quality, options.threads};
}

/// Throws the overlap anew, with a picture of its place where one can be drawn.
[[noreturn]] void show_overlap(const SceneFile& file, const Simulation& simulation,
                               const OverlapError& overlap, const fs::path& path,
                               std::optional<render::Rasterizer>& rasterizer, const RunOptions& options) {
    std::string line = overlap.what();
    if (!overlap.triangles.empty()) try {
            if (!rasterizer) rasterizer.emplace(options.threads, options.gl);
            render::write_png(
                draw_overlap(file, simulation.model(), simulation.state(), overlap, *rasterizer), path);
            line += "; in red in " + path.string();
        } catch (const std::exception& failure) {
            line += fmt::format("; no picture of it: {}", failure.what());
        }
    throw Error(ExitCode::start_overlap, line);
}

}  // namespace

std::string state_fault(const State& state) {
    constexpr double furthest = 1e9;  // [m]
    if (const int vertex = first_non_finite_vertex(state); vertex >= 0)
        return fmt::format("vertex {} is no longer finite", vertex);
    for (Eigen::Index i = 0; i < state.positions.size(); ++i)
        if (std::abs(state.positions[i]) > furthest)
            return fmt::format("vertex {} is more than {:g} m away", i / 3, furthest);
    return {};
}

double playback_rate(const SceneFile& file) {
    return file.output.playback_rate.value_or(file.scene.simulation.frame_rate);
}

// ---------------------------------------------------------------- simulate, draw, encode

RunSummary run_scene(const SceneFile& file, const fs::path& out, const RunOptions& options) {
    RunSummary summary;
    summary.scene = file.name;
    summary.frames = file.output.frames;
    summary.playback_rate = playback_rate(file);
    if (summary.frames < 1) throw Error(ExitCode::usage, "a run needs at least one frame");
    const bool movie_wanted = options.pictures && options.movie;

    if (movie_wanted) summary.encoder = ffmpeg_version();
    Simulation simulation(file.scene, options.threads);
    const Model& model = simulation.model();
    std::optional<render::Rasterizer> rasterizer;
    if (options.pictures) {
        rasterizer.emplace(options.threads, options.gl);
        summary.renderer = rasterizer->description();
        summary.width = file.view.width;
        summary.height = file.view.height;
    }

    const RunFolder folder = RunFolder::create(out);
    folder.clear();
    folder.write_manifest({file.name, summary.frames, build_fingerprint()});
    keep_scene(folder, file);
    write_topology(model, folder.topology());

    const auto simulate = [&](Stages& stages) {
        for (std::int64_t frame = 0; frame < summary.frames; ++frame) {
            if (stages.stopping()) return;
            FrameRecord record;
            if (frame > 0) {
                const Stopwatch watch;
                record.report = simulation.advance_frame();
                summary.times.simulate += watch.seconds();
            }
            record.report.frame = frame;
            const auto stop = [&](const std::string& what) {
                stages.fail_later(std::make_exception_ptr(
                    Error(ExitCode::not_converged, fmt::format("{}: {}", file.name, what))));
            };
            const std::string fault = state_fault(simulation.state());
            if (!fault.empty()) {
                const std::string kept =
                    frame == 0 ? "there is no good frame"
                               : fmt::format("the last good frame is {}; frames up to it are kept in {}",
                                             frame - 1, out.string());
                stop(
                    fmt::format("the simulation diverged: in frame {} {}; {}; a smaller simulation.time_step "
                                "or softer cloth may help",
                                frame, fault, kept));
                return;
            }
            if (!record.report.converged) {
                const SimulationDesc& settings = simulation.model().scene.simulation;
                const double time = simulation.state().time;
                const int parts = 1 << settings.retries;
                const int vertex = record.report.worst_vertex.value_or(0);
                const Vec3 place = simulation.state().positions.segment<3>(3 * vertex);
                const std::string why =
                    record.report.placed
                        ? fmt::format(
                              "the step from {:.6g} s did not converge, not even cut into {} parts: "
                              "residual {:.2g}, must be {:.2g}; farthest from balance is vertex {} at "
                              "({:.4g}, {:.4g}, {:.4g})",
                              time, parts, record.report.residual, settings.newton_tolerance, vertex,
                              place.x(), place.y(), place.z())
                        : fmt::format(
                              "in the step from {:.6g} s, even cut into {} parts, pins or colliders "
                              "cannot get to where the scene wants them: cloth is in the way",
                              time, parts);
                stop(fmt::format("frame {}: {}; frames up to {} are kept in {}", frame, why, frame - 1,
                                 out.string()));
                return;
            }
            const Stopwatch watch;
            auto state = std::make_shared<State>(simulation.state());
            state->frame = frame;
            write_state(*state, folder.state(frame));
            record.state_hash = state_hash(*state);
            summary.times.store += watch.seconds();
            ++summary.states;
            summary.records.push_back(std::move(record));
            stages.step(&Progress::simulated);
            if (!stages.deliver(std::move(state))) return;
        }
    };
    std::optional<VideoWriter> movie;
    const auto open_movie = [&] {
        if (movie_wanted)
            movie.emplace(folder.movie(file.name), summary.width, summary.height,
                          video_options(file, options));
    };
    std::optional<PictureMaker> pictures;
    const auto draw = [&](const State& state) { return pictures->draw(state); };
    // Pictures that have to know of the whole run are drawn after it, all others while it is simulated.
    const bool afterwards = rasterizer && needs_whole_run(file);
    if (rasterizer && !afterwards) {
        open_movie();
        pictures.emplace(file, model, facts_of(file), *rasterizer);
    }
    std::exception_ptr failure;
    bool stopped = false;
    {
        Stages stages(folder, options, summary);
        failure = pictures ? stages.run(simulate, draw, movie ? &*movie : nullptr)
                           : stages.run(simulate, {}, nullptr);
        stopped = stages.stopping();
    }
    if (afterwards && !stopped) try {
            write_report(folder, file, model, summary, "simulated");  // curves are read from it
            pictures.emplace(file, model, survey_run(folder, file, model, options.stop), *rasterizer,
                             state_reader(folder));
            open_movie();
            const double simulated = summary.times.wall;
            Stages stages(folder, options, summary);
            const auto drawing = stages.run(state_producer(folder, folder.kept_states(), summary), draw,
                                            movie ? &*movie : nullptr);
            if (!failure) failure = drawing;
            summary.times.wall += simulated;
            stopped = stages.stopping();
        } catch (...) {
            if (!failure) failure = std::current_exception();
        }
    movie.reset();
    summary.interrupted =
        stopped && (summary.states < summary.frames || (options.pictures && summary.images < summary.frames));
    const std::string outcome = outcome_of(summary, failure);
    try {
        write_report(folder, file, model, summary, outcome);
    } catch (const Error&) {
        if (!failure) throw;  // a full disk has been told of already
    }
    if (failure) try {
            std::rethrow_exception(failure);
        } catch (const OverlapError& overlap) {
            show_overlap(file, simulation, overlap, folder.overlap(), rasterizer, options);
        }
    return summary;
}

// ---------------------------------------------------------------- from a kept run

SceneFile load_run_scene(const fs::path& out, const Overrides& overrides) {
    const RunFolder folder = RunFolder::open(out);
    SceneFile file = load_scene(folder.scene().string(), overrides);
    file.name = folder.read_manifest().scene;
    return file;
}

KeptRun open_run(const fs::path& out, const Overrides& overrides) {
    SceneFile file = load_run_scene(out, overrides);
    Model model = build_model(file.scene);
    RunFolder folder = RunFolder::open(out);
    if (!same_topology(read_topology(folder.topology()), model))
        throw Error(
            ExitCode::other,
            folder.scene().string() + ": its cloth is not the one of the kept states; " + "simulate again");
    return {std::move(folder), std::move(file), std::move(model)};
}

PictureMaker::StateReader state_reader(const RunFolder& folder) {
    return [folder](std::int64_t frame) -> std::optional<State> {
        std::error_code ignored;
        if (!fs::exists(folder.state(frame), ignored)) return std::nullopt;
        return read_state(folder.state(frame));
    };
}

namespace {

std::string span_text(const std::vector<std::int64_t>& frames) {
    if (frames.empty()) return "none";
    return frames.size() == 1
               ? fmt::format("frame {}", frames.front())
               : fmt::format("{} frames from {} to {}", frames.size(), frames.front(), frames.back());
}

RunSummary summary_of(const KeptRun& run, std::int64_t frames) {
    RunSummary summary;
    summary.scene = run.file.name;
    summary.frames = frames;
    summary.playback_rate = playback_rate(run.file);
    summary.width = run.file.view.width;
    summary.height = run.file.view.height;
    return summary;
}

/// All pictures of the run, in order, into its movie.
void encode_pictures(const KeptRun& run, const RunOptions& options, RunSummary& summary) {
    const Stopwatch watch;
    const auto frames = run.folder.kept_images();
    std::optional<VideoWriter> movie;
    for (const std::int64_t frame : frames) {
        if (options.stop != nullptr && options.stop->load()) {
            summary.interrupted = true;
            return;
        }
        const render::Image image = render::read_png(run.folder.image(frame));
        if (!movie) {
            movie.emplace(run.folder.movie(run.file.name), image.width, image.height,
                          video_options(run.file, options));
            summary.width = image.width;
            summary.height = image.height;
        }
        if (image.width != summary.width || image.height != summary.height)
            throw Error(
                ExitCode::other,
                fmt::format("{} is {}x{}, the pictures before it {}x{}: no movie; draw all frames with "
                            "render_cloth render --out {}",
                            run.folder.image(frame).string(), image.width, image.height, summary.width,
                            summary.height, run.folder.root().string()));
        movie->add(image);
    }
    movie->finish();
    summary.movie = run.folder.movie(run.file.name);
    summary.times.encode += watch.seconds();
}

bool complete(const std::vector<std::int64_t>& frames, std::int64_t count) {
    return std::cmp_equal(frames.size(), count) && (count == 0 || frames.back() == count - 1);
}

}  // namespace

std::vector<std::int64_t> kept_frames(const RunFolder& folder, const std::optional<FrameSpan>& span) {
    const std::vector<std::int64_t> kept = folder.kept_states();
    const std::string out = folder.root().string();
    if (kept.empty()) throw Error(ExitCode::other, out + ": keeps no states to draw");
    if (!span) return kept;
    std::vector<std::int64_t> frames;
    for (std::int64_t frame = span->first; frame < span->last; ++frame) {
        if (!std::binary_search(kept.begin(), kept.end(), frame))
            throw Error(ExitCode::usage,
                        fmt::format("--frames {}:{}: the state of frame {} is not kept in {}; kept: {}",
                                    span->first, span->last, frame, out, span_text(kept)));
        frames.push_back(frame);
    }
    return frames;
}

RunSummary render_run(const fs::path& out, const std::optional<FrameSpan>& span, const Overrides& overrides,
                      const RunOptions& options) {
    const KeptRun run = open_run(out, overrides);
    const std::vector<std::int64_t> frames = kept_frames(run.folder, span);
    RunSummary summary = summary_of(run, static_cast<std::int64_t>(frames.size()));
    const std::int64_t run_frames = run.folder.read_manifest().frames;
    if (options.movie) summary.encoder = ffmpeg_version();
    render::Rasterizer rasterizer(options.threads, options.gl);
    summary.renderer = rasterizer.description();
    PictureMaker pictures(run.file, run.model, survey_run(run.folder, run.file, run.model, options.stop),
                          rasterizer, state_reader(run.folder));
    RunFolder::create(out);

    // The whole run goes to the encoder while it is drawn; a part of it joins the pictures that are there.
    const bool whole = complete(frames, run_frames);
    std::optional<VideoWriter> movie;
    if (options.movie && whole)
        movie.emplace(run.folder.movie(run.file.name), summary.width, summary.height,
                      video_options(run.file, options));
    const auto draw = [&](const State& state) { return pictures.draw(state); };
    Stages stages(run.folder, options, summary);
    const std::exception_ptr failure =
        stages.run(state_producer(run.folder, frames, summary), draw, movie ? &*movie : nullptr);
    movie.reset();
    if (failure) std::rethrow_exception(failure);
    summary.interrupted = stages.stopping() && summary.images < summary.frames;
    if (options.movie && !whole && !summary.interrupted && complete(run.folder.kept_images(), run_frames))
        encode_pictures(run, options, summary);
    amend_report(run.folder, summary);
    return summary;
}

RunSummary encode_run(const fs::path& out, const Overrides& overrides, const RunOptions& options) {
    const KeptRun run = open_run(out, overrides);
    const std::int64_t run_frames = run.folder.read_manifest().frames;
    const auto images = run.folder.kept_images();
    if (!complete(images, run_frames))
        throw Error(ExitCode::other,
                    fmt::format("{}: has pictures of {} of the run's {} frames: no movie; draw the rest with "
                                "render_cloth render --out {}",
                                out.string(), images.size(), run_frames, out.string()));
    RunSummary summary = summary_of(run, run_frames);
    summary.encoder = ffmpeg_version();
    const Stopwatch watch;
    encode_pictures(run, options, summary);
    summary.times.wall = watch.seconds();
    return summary;
}

void export_frame(const fs::path& out, std::int64_t frame, MeshFormat format, const fs::path& file) {
    const RunFolder folder = RunFolder::open(out);
    const auto kept = folder.kept_states();
    if (!std::binary_search(kept.begin(), kept.end(), frame))
        throw Error(ExitCode::usage, fmt::format("--frame {}: its state is not kept in {}; kept: {}", frame,
                                                 out.string(), span_text(kept)));
    const Topology topology = read_topology(folder.topology());
    const State state = read_state(folder.state(frame));
    if (state.positions.size() != topology.rest_positions.size())
        throw Error(ExitCode::other,
                    folder.state(frame).string() + ": does not fit " + folder.topology().string());
    MeshData mesh;
    mesh.positions = Eigen::Map<const Points>(state.positions.data(), topology.rest_positions.rows(), 3);
    mesh.triangles = topology.triangles;
    write_mesh(mesh, format, file);
}

}  // namespace cloth::pipeline
