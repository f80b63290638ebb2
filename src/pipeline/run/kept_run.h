#pragma once
// A run on disk: what goes into its folder before it is simulated, and what is found there later.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/picture/survey.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"

namespace cloth::pipeline {

/// The folder `out` without what an earlier run made in it, with manifest, scene and topology of a new one.
RunFolder start_run(const std::filesystem::path& out, const SceneFile& file, const Model& model);

/// The scene whose folder is `out`. Throws Error(other) where it holds no run.
SceneFile load_run_scene(const std::filesystem::path& out, const Overrides& overrides = {});

/// A run on disk with what its states belong to.
struct KeptRun {
    RunFolder folder;
    SceneFile file;
    Model model;
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

StateReader state_reader(const RunFolder& folder);

/// What the pictures of `file` have to know of the states and the report in `folder`. `stop` as in
/// RunOptions.
RunFacts survey_run(const RunFolder& folder, const SceneFile& file, const Model& model,
                    const std::atomic<bool>* stop);

}  // namespace cloth::pipeline
