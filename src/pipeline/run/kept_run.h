#pragma once
// A run on disk: what goes into its folder before it is simulated, and what is found there later.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/picture/survey.h"
#include "pipeline/run/plan.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/run_options.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"

namespace cloth::pipeline {

/// Throws Error(usage) where a run of `file` may not go to `out`: what is there is the user's
/// (require_own_folder()), or the scene or a mesh or texture of it lies there; Error(invalid_scene) where its
/// name cannot be written down.
void require_place(const std::filesystem::path& out, const SceneFile& file,
                   const std::string& flag = "--out");

/// The folder of a run, held, with what is known to be good in it.
struct StartedRun {
    RunFolder folder;
    RunPlan plan;
    std::unique_ptr<Ledger> ledger;
    bool finished = false;  ///< it was found complete, and of this very scene
};
/// The folder `out` without what an earlier run made in it that is not what is wanted now (all of it where
/// `options.fresh`), with manifest, scene and topology. Tells before anything finished goes. Throws as
/// require_place(), RunFolder::create() and plan_run().
StartedRun start_run(const std::filesystem::path& out, const Wanted& wanted, const RunOptions& options);

/// The scene whose folder is `out`. Throws Error(other) where it holds no run.
SceneFile load_run_scene(const std::filesystem::path& out, const Overrides& overrides = {});

/// A run on disk with what its states belong to.
struct KeptRun {
    RunFolder folder;
    SceneFile file;
    Model model;
    std::int64_t frames;  ///< asked for when it was simulated
};
/// Throws Error(other) where there is none, or where its scene and states do not belong together.
KeptRun open_run(const std::filesystem::path& out, const Overrides& overrides = {});

/// The frames first … last - 1.
struct FrameSpan {
    std::int64_t first = 0, last = 0;
};
/// The frames of a span, all of which must be kept, or all kept frames. Throws Error(usage).
std::vector<std::int64_t> kept_frames(const RunFolder& folder, const std::optional<FrameSpan>& span);
/// "none", "frame 3", "5 frames from 0 to 4".
std::string span_text(const std::vector<std::int64_t>& frames);

/// Why `state` cannot be used: "vertex 12 is no longer finite", or "vertex 12 is more than 1e+09 m away"
/// (what flies apart passes the range of pictures long before that of numbers). Empty for a good state.
std::string state_fault(const State& state);

/// Reads kept states: nothing for a frame that has none. Throws Error(other) for a file that is damaged,
/// belongs to another frame or another scene, or has a state_fault().
StateReader state_reader(const RunFolder& folder, const Model& model);
/// A state that must be there.
State read_kept(const StateReader& read, std::int64_t frame);

/// The frames 0 … n-1 of a run's movie: all whose state is kept, which may be a run's beginning. Throws
/// Error(other), with the command that helps, where a state or a picture is missing, so that no movie leaves
/// out a frame or takes a picture of another run.
std::vector<std::int64_t> movie_frames(const KeptRun& run);

/// What the pictures of `file` have to know of the states and the report in `folder`. `stop` as in
/// RunOptions.
RunFacts survey_run(const RunFolder& folder, const SceneFile& file, const Model& model,
                    const std::atomic<bool>* stop);

}  // namespace cloth::pipeline
