#include "pipeline/golden/golden.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <optional>
#include <stdexcept>
#include <system_error>
#include <utility>

#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/folder_lock.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/golden/golden_page.h"
#include "pipeline/picture/camera.h"
#include "pipeline/picture/frame_builder.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run_page.h"
#include "pipeline/scene_file/picture_schema.h"
#include "render/raster/rasterizer.h"
#include "sim/simulation.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

// ---------------------------------------------------------------- verdicts

StateVerdict judge_state(const State& golden, const State& actual, const StateGate& gate) {
    StateVerdict verdict;
    if (golden.positions.size() != actual.positions.size()) {
        verdict.largest_distance = std::numeric_limits<double>::infinity();
        verdict.reason = fmt::format("{} vertices instead of {}", actual.positions.size() / 3,
                                     golden.positions.size() / 3);
        return verdict;
    }
    for (Eigen::Index i = 0; i < golden.positions.size() / 3; ++i) {
        const double distance =
            (golden.positions.segment<3>(3 * i) - actual.positions.segment<3>(3 * i)).norm();
        // Not `distance > largest`: a distance that is no number must win.
        if (!(distance <= verdict.largest_distance)) {
            verdict.largest_distance = distance;
            verdict.worst_vertex = static_cast<int>(i);
        }
        if (!std::isfinite(distance)) break;
    }
    if (gate.exact) {
        const auto same = [](const VecX& a, const VecX& b) {
            return a.size() == b.size() &&
                   std::memcmp(a.data(), b.data(), sizeof(double) * static_cast<std::size_t>(a.size())) == 0;
        };
        if (!same(golden.positions, actual.positions))
            verdict.reason = fmt::format(
                "vertex {} is off by {:.3g} m; the build is the golden one, so every bit "
                "should agree",
                verdict.worst_vertex, verdict.largest_distance);
        else if (!same(golden.velocities, actual.velocities))
            verdict.reason = "velocities differ; the build is the golden one, so every bit should agree";
        verdict.passed = verdict.reason.empty();
        return verdict;
    }
    // A vertex moved by just the tolerance fails; the last factor is the rounding of that movement.
    verdict.passed = verdict.largest_distance < gate.tolerance * (1.0 - 1e-6);
    if (!verdict.passed)
        verdict.reason = fmt::format("vertex {} is off by {:.3g} m; allowed: less than {:.3g} m",
                                     verdict.worst_vertex, verdict.largest_distance, gate.tolerance);
    return verdict;
}

ImageVerdict judge_image(const render::Image& golden, const render::Image& actual, bool exact) {
    ImageVerdict verdict;
    verdict.difference = render::compare(golden, actual);
    const render::ImageDifference& d = verdict.difference;
    const std::string place =
        fmt::format("; worst by {} of 255 at ({}, {})", d.largest, d.worst_x, d.worst_y);
    if (!d.same_size)
        verdict.reason = fmt::format("{}x{} pixels instead of {}x{}", actual.width, actual.height,
                                     golden.width, golden.height);
    else if (exact && d.largest > 0)
        verdict.reason = "the renderer is the golden one, so every pixel should agree" + place;
    else if (d.fraction_over_2 > 0.0005)
        verdict.reason = fmt::format("{:.3f} % of the pixels off by more than 2; allowed: 0.05 %{}",
                                     100 * d.fraction_over_2, place);
    else if (d.fraction_over_32 > 0.0001)
        verdict.reason = fmt::format("{:.3f} % of the pixels off by more than 32; allowed: 0.01 %{}",
                                     100 * d.fraction_over_32, place);
    else if (!(d.psnr >= 57.0))
        verdict.reason = fmt::format("PSNR {:.1f} dB; at least 57 dB wanted{}", d.psnr, place);
    verdict.passed = verdict.reason.empty();
    return verdict;
}

namespace {

// ---------------------------------------------------------------- golden folder

fs::path golden_state(const fs::path& folder, std::int64_t frame) {
    return folder / fmt::format("state_{:06d}.bin", frame);
}
fs::path golden_image(const fs::path& folder, std::int64_t frame) {
    return folder / fmt::format("frame_{:06d}.png", frame);
}

struct GoldenFacts {
    std::string build, renderer;
    std::vector<std::int64_t> frames;
};

GoldenFacts read_facts(const fs::path& folder) {
    const fs::path path = folder / "golden.json";
    const nlohmann::json json = nlohmann::json::parse(read_file(path), nullptr, false);
    try {
        GoldenFacts facts{json.at("build"), json.at("renderer"), json.at("frames")};
        for (const std::int64_t frame : facts.frames)
            if (frame < 0 || frame >= most_frames) throw std::out_of_range("frames");
        return facts;
    } catch (const std::exception&) {
        throw Error(ExitCode::golden_mismatch,
                    path.string() + ": damaged: it must tell of build, renderer and frames");
    }
}

void write_facts(const fs::path& folder, const GoldenResult& result,
                 const std::vector<std::int64_t>& frames) {
    const nlohmann::ordered_json facts = {{"build", result.actual_build},
                                          {"renderer", result.actual_renderer},
                                          {"size_pixel", {golden_width, golden_height}},
                                          {"state_tolerance_m", result.state_tolerance},
                                          {"frames", frames}};
    write_file(folder / "golden.json", facts.dump(2) + "\n");
}

/// Goldens are written into a new or an empty folder, or over goldens.
void require_golden_folder(const fs::path& folder) {
    std::error_code failure;
    if (fs::exists(folder / "golden.json", failure)) {
        read_facts(folder);
    } else if (fs::exists(folder, failure) && !fs::is_empty(folder, failure)) {
        throw Error(
            ExitCode::usage,
            fmt::format("--golden: {} holds no goldens (no golden.json) and is not empty; give another "
                        "folder, or empty it",
                        folder.string()));
    }
}

std::vector<std::int64_t> golden_frames(const SceneFile& file) {
    std::vector<std::int64_t> frames(file.expect.frames.begin(), file.expect.frames.end());
    std::sort(frames.begin(), frames.end());
    frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
    if (frames.empty())
        throw Error(ExitCode::golden_mismatch,
                    file.name + ": has no golden frames; name some in its [expect] frames = […], then " +
                        bless_command(file.name));
    return frames;
}

std::vector<State> simulate(Simulation& simulation, const std::string& scene,
                            const std::vector<std::int64_t>& frames) {
    std::vector<State> states;
    for (std::int64_t frame = 0; frame <= frames.back(); ++frame) {
        const bool converged = frame == 0 || simulation.advance_frame().converged;
        if (const std::string fault = state_fault(simulation.state()); !fault.empty())
            throw Error(ExitCode::not_converged,
                        fmt::format("{}: the simulation diverged: in frame {} {}; the last good frame is {}",
                                    scene, frame, fault, frame - 1));
        if (!converged)
            throw Error(ExitCode::not_converged,
                        fmt::format("{}: a step of frame {} did not converge", scene, frame));
        if (std::binary_search(frames.begin(), frames.end(), frame)) {
            states.push_back(simulation.state());
            states.back().frame = frame;
        }
    }
    return states;
}

/// What compare and bless have in common.
struct Session {
    Session(const SceneFile& scene_file, int threads, render::GlLibrary gl)
        : file(scene_file),
          frames(golden_frames(scene_file)),
          simulation(file.scene, threads),
          rasterizer(threads, gl),
          builder(file, simulation.model()) {
        file.view.width = golden_width;
        file.view.height = golden_height;
        result.scene = file.name;
        result.state_tolerance = file.expect.state_tolerance;
        result.actual_build = build_fingerprint();
        result.actual_renderer = rasterizer.description();
    }
    Session(const Session&) = delete;  // the builder refers to the file

    render::Image draw(const State& state) {
        if (moves(file.camera)) aim(file.view, file.camera, state.time);
        return rasterizer.draw(builder.build(state), file.view);
    }
    bool fits(const State& state) const {
        return state_fault(state).empty() && state.positions.size() == simulation.state().positions.size() &&
               state.collider_on.size() == simulation.state().collider_on.size();
    }

    SceneFile file;
    std::vector<std::int64_t> frames;
    Simulation simulation;
    render::Rasterizer rasterizer;
    FrameBuilder builder;
    GoldenResult result;
};

/// The row of a frame and its part of the page, against what stood there; nothing where the frame is new, or
/// its old files cannot be read.
std::optional<std::pair<GoldenRow, nlohmann::ordered_json>> compared_with_old(
    const fs::path& golden, const GoldenFacts& before, std::int64_t frame, const State& state,
    const render::Image& picture, const GoldenResult& result) {
    try {
        const State old_state = read_state(golden_state(golden, frame));
        const render::Image old_picture = render::read_png(golden_image(golden, frame));
        GoldenRow row;
        row.frame = frame;
        row.state =
            judge_state(old_state, state, {before.build == result.actual_build, result.state_tolerance});
        row.image = judge_image(old_picture, picture, before.renderer == result.actual_renderer);
        nlohmann::ordered_json part = row_json(row, &old_picture, &picture);
        return std::pair(std::move(row), std::move(part));
    } catch (const std::runtime_error&) {
        return std::nullopt;
    }
}

void conclude(GoldenResult& result) {
    result.passed = std::all_of(result.rows.begin(), result.rows.end(),
                                [](const GoldenRow& row) { return row.state.passed && row.image.passed; });
}

/// What the goldens in a folder tell of themselves. Throws Error(golden_mismatch) where they are not all
/// there.
GoldenFacts whole_goldens(const SceneFile& file, const fs::path& golden,
                          const std::vector<std::int64_t>& frames) {
    for (const std::int64_t frame : frames)
        for (const fs::path& path :
             {golden / "golden.json", golden_state(golden, frame), golden_image(golden, frame)}) {
            std::error_code failure;
            if (!fs::is_regular_file(path, failure))
                throw Error(ExitCode::golden_mismatch,
                            fmt::format("{}: the golden {} is missing; make it with {}", file.name,
                                        path.string(), bless_command(file.name)));
        }
    GoldenFacts facts = read_facts(golden);
    if (facts.frames.empty())
        throw Error(ExitCode::golden_mismatch,
                    fmt::format("{}: the goldens in {} were not written to their end; make them with {}",
                                file.name, golden.string(), bless_command(file.name)));
    return facts;
}

/// The states of the session's frames against the goldens: the result, and the page's part of each frame.
nlohmann::ordered_json compare_states(Session& session, const GoldenFacts& facts, const fs::path& golden,
                                      const std::vector<State>& states) {
    GoldenResult& result = session.result;
    result.golden_build = facts.build;
    result.golden_renderer = facts.renderer;
    const StateGate gate{facts.build == result.actual_build, result.state_tolerance};
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < states.size(); ++i) {
        GoldenRow row;
        row.frame = session.frames[i];
        const State golden_now = read_state(golden_state(golden, row.frame));
        const render::Image golden_picture = render::read_png(golden_image(golden, row.frame));
        row.state = judge_state(golden_now, states[i], gate);
        std::optional<render::Image> picture;
        if (session.fits(golden_now)) {
            picture = session.draw(golden_now);
            row.image = judge_image(golden_picture, *picture, facts.renderer == result.actual_renderer);
        } else {
            row.image.reason = "not drawn: the golden state does not fit the scene";
        }
        std::optional<render::Image> moved;
        if (!row.state.passed && session.fits(states[i])) moved = session.draw(states[i]);
        rows.push_back(
            row_json(row, &golden_picture, picture ? &*picture : nullptr, moved ? &*moved : nullptr));
        result.rows.push_back(std::move(row));
    }
    conclude(result);
    return rows;
}

}  // namespace

GoldenResult compare_golden(const SceneFile& scene_file, const fs::path& golden, const fs::path& out,
                            int threads, render::GlLibrary gl) {
    require_place(out, scene_file);
    // Missing goldens are told of before any work is done.
    const GoldenFacts facts = whole_goldens(scene_file, golden, golden_frames(scene_file));
    Session session(scene_file, threads, gl);
    const std::vector<State> states = simulate(session.simulation, session.result.scene, session.frames);
    nlohmann::ordered_json rows = compare_states(session, facts, golden, states);
    session.result.report = write_page(session.result, std::move(rows), out);
    return std::move(session.result);
}

GoldenResult compare_kept_run(const fs::path& run, const fs::path& goldens, const RunOptions& options) {
    const KeptRun kept = open_run(run);
    const fs::path golden = goldens / kept.file.name;
    std::vector<std::int64_t> frames;
    const std::vector<std::int64_t> there = kept.folder.kept_states();
    for (const std::int64_t frame : golden_frames(kept.file))
        if (std::binary_search(there.begin(), there.end(), frame)) frames.push_back(frame);
    if (frames.empty())
        throw Error(ExitCode::golden_mismatch,
                    fmt::format("{}: keeps none of the golden frames of {}", run.string(), kept.file.name));
    const GoldenFacts facts = whole_goldens(kept.file, golden, frames);
    Session session(kept.file, options.threads, options.gl);
    // What the program's own build is in compare_golden().
    session.result.actual_build = kept.folder.read_manifest().build;
    const std::string own = facts.build + "; ";
    if (session.result.actual_build.starts_with(own)) session.result.actual_build = facts.build;
    const StateReader read = state_reader(kept.folder, kept.model);
    std::vector<State> states;
    for (const std::int64_t frame : frames) states.push_back(read_kept(read, frame));
    session.frames = frames;
    nlohmann::ordered_json rows = compare_states(session, facts, golden, states);
    const nlohmann::ordered_json part = page_part(session.result, std::move(rows), 5'000'000);
    write_run_page(run, options, &part);
    session.result.report = kept.folder.page();
    return std::move(session.result);
}

GoldenResult bless_golden(const SceneFile& scene_file, const fs::path& golden, const fs::path& out,
                          int threads, render::GlLibrary gl) {
    require_place(out, scene_file);
    require_golden_folder(golden);
    Session session(scene_file, threads, gl);
    GoldenResult& result = session.result;
    const std::vector<State> states = simulate(session.simulation, result.scene, session.frames);

    std::error_code failure;
    std::optional<GoldenFacts> before;
    if (fs::exists(golden / "golden.json", failure)) {
        before = read_facts(golden);
        result.golden_build = before->build;
        result.golden_renderer = before->renderer;
    }
    fs::create_directories(golden, failure);
    if (failure)
        throw Error(ExitCode::other,
                    "cannot write to the folder " + golden.string() + ": " + failure.message());

    const FolderLock lock(golden);
    // Until all is written anew the goldens count as missing, never as a mixture.
    write_facts(golden, result, {});
    nlohmann::ordered_json rows = nlohmann::ordered_json::array();
    for (std::size_t i = 0; i < states.size(); ++i) {
        const std::int64_t frame = session.frames[i];
        const render::Image picture = session.draw(states[i]);
        if (before) {
            if (auto row = compared_with_old(golden, *before, frame, states[i], picture, result)) {
                rows.push_back(std::move(row->second));
                result.rows.push_back(std::move(row->first));
            }
        }
        write_state(states[i], golden_state(golden, frame), Compression::small);
        render::write_png(picture, golden_image(golden, frame));
    }
    if (before)
        for (const std::int64_t frame : before->frames)
            if (!std::binary_search(session.frames.begin(), session.frames.end(), frame)) {
                fs::remove(golden_state(golden, frame), failure);
                fs::remove(golden_image(golden, frame), failure);
            }
    write_facts(golden, result, session.frames);
    conclude(result);
    result.report = write_page(result, std::move(rows), out);
    return std::move(result);
}

}  // namespace cloth::pipeline
