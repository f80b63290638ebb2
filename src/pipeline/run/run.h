#pragma once
// A whole run: simulate, draw, write pictures, encode. The stages work at the same time on successive frames;
// the results do not depend on how they interleave.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/formats/mesh_file.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/picture/picture.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/gl/gl_library.h"
#include "sim/scene/state.h"
#include "sim/simulation.h"

namespace cloth::pipeline {

/// Frames that each stage has finished.
struct Progress {
    std::int64_t frames = 0;  ///< to be made
    std::int64_t simulated = 0, drawn = 0, written = 0, encoded = 0;
};

struct RunOptions {
    bool pictures = true;
    bool movie = true;                                    ///< needs pictures
    int threads = 0;                                      ///< ≤ 0: all cores
    render::GlLibrary gl = render::GlLibrary::automatic;  ///< what draws
    /// Called after each frame of each stage, by one thread at a time.
    std::function<void(const Progress&)> progress;
    /// Looked at between frames: true ends the run, every finished frame kept.
    const std::atomic<bool>* stop = nullptr;
};

/// Time that each stage was busy [s]; they overlap, so `wall` is less than their sum.
struct StageTimes {
    double simulate = 0, store = 0, draw = 0, png = 0, encode = 0, wall = 0;
};

/// What is known of one simulated frame.
struct FrameRecord {
    FrameReport report;
    std::string state_hash;
};

struct RunSummary {
    std::string scene;
    std::int64_t frames = 0;    ///< asked for
    std::int64_t states = 0;    ///< written
    std::int64_t images = 0;    ///< written
    int width = 0, height = 0;  ///< of the pictures [pixel]; 0 without
    double playback_rate = 0;   ///< [1/s]
    bool interrupted = false;
    std::vector<FrameRecord> records;
    StageTimes times;
    std::string renderer, encoder;  ///< versions; empty where not used
    std::filesystem::path movie;    ///< empty where none was made
};

/// Why `state` cannot be used: "vertex 12 is no longer finite", or "vertex 12 is more than 1e+09 m away"
/// (what flies apart passes the range of pictures long before that of numbers). Empty for a good state.
std::string state_fault(const State& state);

/// Pictures per second of the movie.
double playback_rate(const SceneFile& file);

/// Runs `file` for its output.frames frames into the folder `out`, in place of the run that it may hold, and
/// leaves a report there. What can be refused is refused before anything there is touched: SceneError,
/// Error(encoder) without ffmpeg. Throws Error(not_converged) at the first state with a fault, naming
/// frame, vertex and last good frame, once the good frames are drawn; Error(encoder) where only the movie
/// failed, once all is drawn.
RunSummary run_scene(const SceneFile& file, const std::filesystem::path& out, const RunOptions& options);

/// The frames first … last - 1.
struct FrameSpan {
    std::int64_t first = 0, last = 0;
};

/// Draws the kept states of the run in `out`, and makes the movie where all pictures of the run are there in
/// the end. `overrides` change the scene that is drawn, not the kept one. Throws Error(usage) for a span with
/// frames that have no state.
RunSummary render_run(const std::filesystem::path& out, const std::optional<FrameSpan>& span,
                      const Overrides& overrides, const RunOptions& options);

/// Makes the movie again from the kept pictures, which must be all of the run and of one size.
RunSummary encode_run(const std::filesystem::path& out, const Overrides& overrides,
                      const RunOptions& options);

/// Writes the kept state of `frame` as a mesh, all cloths together. Throws Error(usage) where it is not kept.
void export_frame(const std::filesystem::path& out, std::int64_t frame, MeshFormat format,
                  const std::filesystem::path& file);

/// A run on disk with what its states belong to.
struct KeptRun {
    RunFolder folder;
    SceneFile file;
    Model model;
};
/// Throws Error(other) where there is none, or where its scene and states do not belong together.
KeptRun open_run(const std::filesystem::path& out, const Overrides& overrides = {});
/// The frames of a span, all of which must be kept, or all kept frames. Throws Error(usage).
std::vector<std::int64_t> kept_frames(const RunFolder& folder, const std::optional<FrameSpan>& span);
PictureMaker::StateReader state_reader(const RunFolder& folder);

/// The scene whose folder is `out`. Throws Error(other) where it and the kept states do not belong together.
SceneFile load_run_scene(const std::filesystem::path& out, const Overrides& overrides = {});

}  // namespace cloth::pipeline
