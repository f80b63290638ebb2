#include "pipeline/run/sheet.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <stdexcept>

#include "pipeline/formats/error.h"
#include "pipeline/formats/video.h"
#include "pipeline/picture/annotation.h"
#include "pipeline/picture/picture.h"
#include "pipeline/picture/survey.h"
#include "pipeline/run/draw.h"
#include "render/overlay/overlay.h"
#include "render/raster/rasterizer.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr int tile_width = 320;
constexpr render::Ink paper{{250, 250, 250}}, text_ink{{28, 32, 38}};

void require_going_on(const RunOptions& options) {
    if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: nothing was written");
}

void tell(const RunOptions& options, std::int64_t done, std::int64_t frames) {
    if (!options.progress) return;
    Progress progress;
    progress.frames = frames;
    progress.drawn = progress.written = done;
    options.progress(progress);
}

/// Of frames in order of time, the one nearest to `time`.
std::int64_t nearest_frame(const std::vector<std::pair<double, std::int64_t>>& frames, double time) {
    return std::min_element(frames.begin(), frames.end(),
                            [&](const auto& a, const auto& b) {
                                return std::abs(a.first - time) < std::abs(b.first - time);
                            })
        ->second;
}

}  // namespace

std::vector<std::int64_t> spread(const std::vector<std::int64_t>& frames, int count) {
    if (count >= static_cast<int>(frames.size())) return frames;
    std::vector<std::int64_t> chosen;
    const std::size_t last = frames.size() - 1;
    for (int i = 0; i < count; ++i)
        chosen.push_back(frames[count == 1 ? last
                                           : (2 * static_cast<std::size_t>(i) * last +
                                              static_cast<std::size_t>(count) - 1) /
                                                 (2 * static_cast<std::size_t>(count - 1))]);
    return chosen;
}

render::Image contact_sheet(const std::vector<render::Image>& pictures, const std::vector<std::string>& texts,
                            int columns) {
    if (pictures.empty() || columns < 1)
        throw std::invalid_argument("a contact sheet needs a picture and a column");
    if (texts.size() != pictures.size())
        throw std::invalid_argument(
            fmt::format("{} texts for {} pictures of a contact sheet", texts.size(), pictures.size()));
    const int width = pictures.front().width, height = pictures.front().height;
    for (const render::Image& each : pictures)
        if (each.width != width || each.height != height)
            throw std::invalid_argument(fmt::format("a picture of {}x{} in a contact sheet of {}x{}",
                                                    each.width, each.height, width, height));
    const auto count = static_cast<int>(pictures.size());
    columns = std::min(columns, count);
    const int rows = (count + columns - 1) / columns;
    float widest = 1;
    for (const std::string& text : texts) widest = std::max(widest, render::text_width(text, 1));
    const float size = std::clamp(static_cast<float>(width) / 24.0f, 9.0f,
                                  std::max(9.0f, 0.95f * static_cast<float>(width) / widest));
    const int gap = std::max(4, static_cast<int>(size / 2)), strip = static_cast<int>(1.9f * size);
    render::Image sheet =
        render::plain_image(gap + columns * (width + gap), gap + rows * (height + strip), paper);
    for (int i = 0; i < count; ++i) {
        const int x = gap + i % columns * (width + gap), y = gap + i / columns * (height + strip);
        const std::string& text = texts[static_cast<std::size_t>(i)];
        const float room = 0.5f * (static_cast<float>(width) - render::text_width(text, size));
        render::draw_text(
            sheet,
            {static_cast<float>(x) + std::max(0.0f, room), static_cast<float>(y + height) + 1.25f * size},
            text, size, text_ink);
        render::paste(sheet, pictures[static_cast<std::size_t>(i)], x, y);
    }
    return sheet;
}

SheetSummary write_sheet(const fs::path& out, const fs::path& file, const SheetOptions& sheet,
                         const Overrides& overrides, const RunOptions& options) {
    KeptRun run = open_run(out, overrides);
    const auto frames = spread(kept_frames(run.folder, sheet.span), sheet.count);
    // Time and frame stand under each picture.
    run.file.annotation.caption.reset();
    if (!sheet.own_size) {
        run.file.annotation.curves.clear();  // there is no room for them
        const double aspect = static_cast<double>(run.file.view.height) / run.file.view.width;
        run.file.view.width = std::min(run.file.view.width, tile_width);
        run.file.view.height =
            std::clamp(static_cast<int>(std::lround(run.file.view.width * aspect)), 16, 8192);
    }
    const auto count = static_cast<int>(frames.size());
    int columns = sheet.columns;
    if (columns == 0) columns = static_cast<int>(std::ceil(std::sqrt(static_cast<double>(count))));
    const auto size = [&](int n, int side) { return static_cast<std::int64_t>(n) * (side + 64); };
    if (size(std::min(columns, count), run.file.view.width) > 32768 ||
        size((count + columns - 1) / columns, run.file.view.height) > 32768)
        throw Error(ExitCode::usage,
                    fmt::format("a sheet of {} pictures of {}x{} in {} columns would have a side of "
                                "more than 32768 pixels; take fewer or smaller ones",
                                count, run.file.view.width, run.file.view.height, columns));
    render::Rasterizer rasterizer(options.threads, options.gl);
    const StateReader read = state_reader(run.folder, run.model);
    PictureMaker maker(run.file, run.model, survey_run(run.folder, run.file, run.model, options.stop),
                       rasterizer, read);
    std::vector<render::Image> pictures;
    std::vector<std::string> texts;
    for (const std::int64_t frame : frames) {
        require_going_on(options);
        const State state = read_kept(read, frame);
        pictures.push_back(maker.draw(state, "", sheet.own_size));
        texts.push_back(fmt::format("frame {}   {:.3f} s", frame, state.time));
        tell(options, static_cast<std::int64_t>(pictures.size()), count);
    }
    render::Image page = contact_sheet(pictures, texts, columns);
    if (const auto colors = maker.legend(); colors && !sheet.own_size) {
        // One for all of them, beside them.
        render::Image side = render::plain_image(180, page.height, paper);
        const int first = draw_legend(side, *colors);
        render::Image wide = render::plain_image(page.width + side.width - first, page.height, paper);
        render::paste(wide, side, page.width - first, 0);
        render::paste(wide, page, 0, 0);
        page = std::move(wide);
    }
    render::write_png(page, file);
    return {file, count, page.width, page.height};
}

ComparisonSummary write_comparison(const std::array<fs::path, 2>& runs, const fs::path& movie,
                                   const std::array<std::string, 2>& labels, const Overrides& overrides,
                                   const RunOptions& options) {
    ffmpeg_version(options.stop);
    std::array<KeptRun, 2> kept{open_run(runs[0], overrides), open_run(runs[1], overrides)};
    for (const int side : {0, 1}) {
        kept[side].file.view.width = kept[0].file.view.width;
        kept[side].file.view.height = kept[0].file.view.height;
    }
    std::array<std::vector<std::pair<double, std::int64_t>>, 2> times;
    std::array<RunFacts, 2> facts;
    for (const int side : {0, 1}) {
        const double rate = kept[side].file.scene.simulation.frame_rate;
        for (const std::int64_t frame : kept_frames(kept[side].folder, std::nullopt))
            times[side].emplace_back(static_cast<double>(frame) / rate, frame);
        facts[side] = survey_run(kept[side].folder, kept[side].file, kept[side].model, options.stop);
    }
    share(facts[0], facts[1]);
    const double last = std::min(times[0].back().first, times[1].back().first);
    std::erase_if(times[0], [&](const auto& t) { return t.first > last + 1e-9; });

    render::Rasterizer rasterizer(options.threads, options.gl);
    std::array<std::unique_ptr<PictureMaker>, 2> makers;
    std::array<StateReader, 2> read;
    for (const int side : {0, 1}) {
        read[side] = state_reader(kept[side].folder, kept[side].model);
        makers[side] = std::make_unique<PictureMaker>(kept[side].file, kept[side].model, facts[side],
                                                      rasterizer, read[side]);
    }
    ComparisonSummary summary;
    summary.frames = static_cast<std::int64_t>(times[0].size());
    const int width = kept[0].file.view.width, rule = std::max(2, width / 320);
    summary.width = 2 * width + rule;
    summary.height = kept[0].file.view.height;
    summary.playback_rate = playback_rate(kept[0].file);
    VideoWriter writer(movie, summary.width, summary.height,
                       {summary.playback_rate, kept[0].file.output.quality, options.threads, options.stop});
    std::int64_t done = 0;
    for (const auto& [time, frame] : times[0]) {
        require_going_on(options);
        render::Image both = render::plain_image(summary.width, summary.height, text_ink);
        for (const int side : {0, 1}) {
            const std::int64_t shown = side == 0 ? frame : nearest_frame(times[1], time);
            const State state = read_kept(read[side], shown);
            render::paste(both, makers[side]->draw(state, labels[side]), side * (width + rule), 0);
        }
        writer.add(both);
        tell(options, ++done, summary.frames);
    }
    writer.finish();
    return summary;
}

}  // namespace cloth::pipeline
