#include <fmt/format.h>

#include <exception>
#include <optional>
#include <utility>

#include "base/stopwatch.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/video.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/run.h"
#include "render/image/image.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// Whether these are all frames of a run.
bool complete(const std::vector<std::int64_t>& frames, std::int64_t run_frames) {
    return !frames.empty() && std::cmp_equal(frames.size(), run_frames) && frames.back() == run_frames - 1;
}

/// All pictures of the run, in order, into its movie. Takes the pictures' size into `summary`.
void encode_pictures(const KeptRun& run, const RunOptions& options, RunSummary& summary) {
    const TimedScope watch(summary.times.encode);
    std::optional<VideoWriter> movie;
    for (const std::int64_t frame : run.folder.kept_images()) {
        if (options.stopping()) {
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
    const KeptRun run = open_run(out, overrides);
    const std::vector<std::int64_t> frames = kept_frames(run.folder, span);
    const std::int64_t run_frames = run.folder.read_manifest().frames;
    RunSummary summary = planned(run.file, static_cast<std::int64_t>(frames.size()));
    if (options.movie) summary.encoder = ffmpeg_version();
    render::Rasterizer rasterizer(options.threads, options.gl);
    summary.renderer = rasterizer.description();
    RunFacts facts = survey_run(run.folder, run.file, run.model, options.stop);
    RunFolder::create(out);

    // The whole run goes to the encoder while it is drawn; a part of it joins the pictures that are there.
    const bool whole = complete(frames, run_frames);
    const StagesResult drawn =
        draw_run({run.folder, run.file, run.model, rasterizer, options}, std::move(facts), summary.frames,
                 options.movie && whole, kept_states(run.folder, frames));
    if (drawn.failure) std::rethrow_exception(drawn.failure);
    add(summary, drawn, run.folder);
    summary.interrupted = options.stopping() && summary.images < summary.frames;
    if (options.movie && !whole && !summary.interrupted && complete(run.folder.kept_images(), run_frames))
        encode_pictures(run, options, summary);
    amend_report(run.folder, summary);
    return summary;
}

RunSummary encode_run(const fs::path& out, const Overrides& overrides, const RunOptions& options) {
    const KeptRun run = open_run(out, overrides);
    const std::int64_t run_frames = run.folder.read_manifest().frames;
    const auto images = run.folder.kept_images();
    if (!complete(images, run_frames)) {
        throw Error(ExitCode::other,
                    fmt::format("{}: has pictures of {} of the run's {} frames: no movie; draw the rest with "
                                "render_cloth render --out {}",
                                out.string(), images.size(), run_frames, out.string()));
    }
    RunSummary summary = planned(run.file, run_frames);
    summary.encoder = ffmpeg_version();
    encode_pictures(run, options, summary);
    summary.times.wall = summary.times.encode;
    return summary;
}

}  // namespace cloth::pipeline
