#pragma once
// The stages of a run with pictures. Internal to this room.

#include <cstdint>
#include <vector>

#include "pipeline/formats/video.h"
#include "pipeline/picture/survey.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/stages.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/raster/rasterizer.h"
#include "sim/model.h"

namespace cloth::pipeline {

/// What is drawn, where to, and by what. Its parts must outlive it.
struct DrawnRun {
    const RunFolder& folder;
    const SceneFile& file;
    const Model& model;
    render::Rasterizer& rasterizer;
    const RunOptions& options;
};

/// Draws each state that `produce` delivers, `frames` in all; into a movie too, where one is wanted.
/// Pictures that `kept` has are taken from the folder.
StagesResult draw_run(const DrawnRun& run, RunFacts facts, std::int64_t frames, bool movie,
                      const Stages::Produce& produce, const KeptPictures& kept = {});

/// Brings kept states to the stages, where their pictures are not there.
Stages::Produce kept_states(StateReader read, std::vector<std::int64_t> frames);

/// Before anything is made: names, sizes and rates.
RunSummary planned(const SceneFile& file, std::int64_t frames);

/// Pictures per second of the movie.
double playback_rate(const SceneFile& file);
VideoOptions video_options(const SceneFile& file, const RunOptions& options);

}  // namespace cloth::pipeline
