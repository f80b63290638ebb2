#include "pipeline/run/draw.h"

#include <memory>
#include <optional>
#include <utility>

#include "pipeline/picture/picture.h"
#include "pipeline/run/kept_run.h"

namespace cloth::pipeline {

StagesResult draw_run(const DrawnRun& run, RunFacts facts, std::int64_t frames, bool movie,
                      const Stages::Produce& produce, const KeptPictures& kept) {
    const SceneFile& file = run.file;
    PictureMaker pictures(file, run.model, std::move(facts), run.rasterizer,
                          state_reader(run.folder, run.model));
    std::optional<VideoWriter> writer;
    if (movie) {
        writer.emplace(run.folder.movie(file.name), file.view.width, file.view.height,
                       video_options(file, run.options));
    }
    return Stages(run.folder, run.options, frames)
        .run(
            produce, [&](const State& state) { return pictures.draw(state); }, writer ? &*writer : nullptr,
            kept);
}

Stages::Produce kept_states(StateReader read, std::vector<std::int64_t> frames) {
    return [read = std::move(read), frames = std::move(frames)](Stages& stages, StatesMade& made) {
        for (const std::int64_t frame : frames) {
            if (!stages.going_on()) return;
            if (stages.has_picture(frame)) {
                stages.deliver_kept(frame);
                continue;
            }
            std::shared_ptr<const State> state;
            {
                const TimedScope watch(made.store);
                state = std::make_shared<const State>(read_kept(read, frame));
            }
            stages.deliver(std::move(state));
        }
    };
}

RunSummary planned(const SceneFile& file, std::int64_t frames) {
    RunSummary summary;
    summary.scene = file.name;
    summary.frames = frames;
    summary.width = file.view.width;
    summary.height = file.view.height;
    summary.playback_rate = playback_rate(file);
    return summary;
}

double playback_rate(const SceneFile& file) {
    return file.output.playback_rate.value_or(file.scene.simulation.frame_rate);
}

VideoOptions video_options(const SceneFile& file, const RunOptions& options) {
    return {playback_rate(file), file.output.quality, options.threads, options.stop};
}

}  // namespace cloth::pipeline
