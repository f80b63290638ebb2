#include <fmt/format.h>

#include <exception>
#include <optional>
#include <utility>

#include "base/memory.h"
#include "base/stopwatch.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/video.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/ledger.h"
#include "pipeline/run/plan.h"
#include "pipeline/run/run.h"
#include "pipeline/run/run_page.h"
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

/// Keys of a kept run's states, by the ledger: that of a frame without one is empty.
std::vector<std::string> kept_keys(const LedgerEntries& ledger, std::int64_t frames) {
    std::vector<std::string> keys(static_cast<std::size_t>(frames));
    for (const auto& [frame, entry] : ledger.states)
        if (frame < frames) keys[static_cast<std::size_t>(frame)] = entry.key;
    return keys;
}

/// Keys of the pictures that this draws. Those that know of a whole run of which a part is there are no
/// run's.
std::vector<std::string> drawn_keys(const KeptRun& run, const LedgerEntries& ledger) {
    if (needs_whole_run(run.file) && std::cmp_less(run.folder.kept_states().size(), run.frames))
        return std::vector<std::string>(static_cast<std::size_t>(run.frames), "of a part of the run");
    return picture_keys(run.file, kept_keys(ledger, run.frames), run.frames);
}

/// The movie's line in the ledger. It has the pictures of all kept frames.
void keep_movie(const KeptRun& run, const RunSummary& summary) {
    const LedgerEntries entries = read_ledger(run.folder.ledger());
    const std::int64_t frames = std::ssize(run.folder.kept_states());
    std::vector<std::string> pictures(static_cast<std::size_t>(frames));
    for (const auto& [frame, entry] : entries.pictures)
        if (frame < frames) pictures[static_cast<std::size_t>(frame)] = entry.key;
    Ledger(run.folder.ledger(), entries)
        .add_movie(summary.movie.filename().string(),
                   {movie_key(run.file, pictures, frames, summary.playback_rate),
                    file_fingerprint(summary.movie), summary.encoder});
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
    const LedgerEntries entries = read_ledger(run.folder.ledger());
    const std::vector<std::string> keys = drawn_keys(run, entries);
    Ledger ledger(run.folder.ledger(), entries);
    const KeptPictures pictures{{}, [&](std::int64_t frame, double draw, double png) {
                                    ledger.add_picture(frame, {keys.at(static_cast<std::size_t>(frame)),
                                                               file_fingerprint(run.folder.image(frame)),
                                                               summary.renderer, draw, png});
                                }};
    const StagesResult drawn =
        draw_run({run.folder, run.file, run.model, rasterizer, options}, std::move(facts), summary.frames,
                 options.movie && whole, kept_states(state_reader(run.folder, run.model), frames), pictures);
    if (drawn.failure) std::rethrow_exception(drawn.failure);
    add(summary, drawn, run.folder);
    summary.interrupted = options.stopping() && (summary.images < summary.frames ||
                                                 (options.movie && whole && summary.movie.empty()));
    if (options.movie && !whole && !summary.interrupted) {
        if (!span || run.folder.kept_images() == run.folder.kept_states())
            encode_pictures(run, movie_frames(run), options, summary);
    }
    if (!summary.movie.empty()) keep_movie(run, summary);
    amend_report(run.folder, summary);
    if (!summary.interrupted) leave_run_page(out, options);
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
    keep_movie(run, summary);
    leave_run_page(out, options);
    summary.times.wall = summary.times.encode;
    return summary;
}

}  // namespace cloth::pipeline
