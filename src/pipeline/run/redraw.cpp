#include <fmt/format.h>

#include <exception>
#include <optional>
#include <utility>

#include "base/memory.h"
#include "base/stopwatch.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/video.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/run.h"
#include "pipeline/scene_file/memory_need.h"
#include "render/image/image.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// The pictures of the run, in order, into its movie. Takes their size into `summary`.
void encode_pictures(const KeptRun& run, const std::vector<std::int64_t>& frames, const RunOptions& options,
                     RunSummary& summary) {
    const TimedScope watch(summary.times.encode);
    std::optional<VideoWriter> movie;
    for (const std::int64_t frame : frames) {
        if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: no movie was made");
        const render::Image image = render::read_png(run.folder.image(frame));
        if (!movie) {
            movie.emplace(run.folder.movie(run.file.name), image.width, image.height,
                          video_options(run.file, options));
            summary.width = image.width;
            summary.height = image.height;
        }
        if (image.width != summary.width || image.height != summary.height) {
            throw Error(
                ExitCode::other,
                fmt::format("{} is {}x{}, the pictures before it {}x{}: no movie; draw all frames with "
                            "render_cloth render --out {}",
                            run.folder.image(frame).string(), image.width, image.height, summary.width,
                            summary.height, run.folder.root().string()));
        }
        movie->add(image);
    }
    movie->finish();
    summary.movie = run.folder.movie(run.file.name);
}

}  // namespace

RunSummary render_run(const fs::path& out, const std::optional<FrameSpan>& span, const Overrides& overrides,
                      const RunOptions& options) {
    RunFolder::open(out).read_manifest();
    const RunFolder locked = RunFolder::create(out);
    const KeptRun run = open_run(out, overrides);
    require_memory(picture_need(run.file), available_memory());
    const std::vector<std::int64_t> frames = kept_frames(run.folder, span);
    RunSummary summary = planned(run.file, static_cast<std::int64_t>(frames.size()));
    if (options.movie) summary.encoder = ffmpeg_version(options.stop);
    render::Rasterizer rasterizer(options.threads, options.gl);
    summary.renderer = rasterizer.description();
    RunFacts facts = survey_run(run.folder, run.file, run.model, options.stop);

    // Without a gap from the start, all goes to the encoder while it is drawn; a part joins the pictures that
    // are there.
    const bool whole = frames == run.folder.kept_states() && std::cmp_equal(frames.size(), frames.back() + 1);
    const StagesResult drawn =
        draw_run({run.folder, run.file, run.model, rasterizer, options}, std::move(facts), summary.frames,
                 options.movie && whole, kept_states(state_reader(run.folder, run.model), frames));
    if (drawn.failure) std::rethrow_exception(drawn.failure);
    add(summary, drawn, run.folder);
    summary.interrupted = options.stopping() && (summary.images < summary.frames ||
                                                 (options.movie && whole && summary.movie.empty()));
    if (options.movie && !whole && !summary.interrupted) {
        if (!span || run.folder.kept_images() == run.folder.kept_states())
            encode_pictures(run, movie_frames(run), options, summary);
    }
    amend_report(run.folder, summary);
    return summary;
}

RunSummary encode_run(const fs::path& out, const Overrides& overrides, const RunOptions& options) {
    RunFolder::open(out).read_manifest();
    const RunFolder locked = RunFolder::create(out);
    const KeptRun run = open_run(out, overrides);
    const std::vector<std::int64_t> frames = movie_frames(run);
    RunSummary summary = planned(run.file, static_cast<std::int64_t>(frames.size()));
    summary.encoder = ffmpeg_version(options.stop);
    encode_pictures(run, frames, options, summary);
    summary.times.wall = summary.times.encode;
    return summary;
}

}  // namespace cloth::pipeline
