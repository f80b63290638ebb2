#include "pipeline/sweep/sheet_movie.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <system_error>

#include <fmt/format.h>

#include "base/parallel.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/video.h"
#include "pipeline/picture/picture.h"
#include "pipeline/run/draw.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/sheet.h"
#include "render/image/image.h"
#include "render/overlay/overlay.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr int widest_page = 3840, highest_page = 2160;
constexpr int least_named = 150;  ///< width of a picture that has room for its cell's name [pixel]

/// The picture in width x height pixels, each the mean of those that it covers; with what it does not fill
/// in grey.
render::Image scaled(const render::Image& image, int width, int height) {
    if (image.width == width && image.height == height) return image;
    render::Image small = render::plain_image(width, height, {{235, 235, 235}});
    const double scale =
        std::min(static_cast<double>(width) / image.width, static_cast<double>(height) / image.height);
    const int w = std::clamp(static_cast<int>(std::lround(image.width * scale)), 1, width),
              h = std::clamp(static_cast<int>(std::lround(image.height * scale)), 1, height);
    const int left = (width - w) / 2, top = (height - h) / 2;
    for (int y = 0; y < h; ++y) {
        const int y0 = y * image.height / h, y1 = std::max(y0 + 1, (y + 1) * image.height / h);
        for (int x = 0; x < w; ++x) {
            const int x0 = x * image.width / w, x1 = std::max(x0 + 1, (x + 1) * image.width / w);
            int sum[3] = {};
            for (int j = y0; j < y1; ++j)
                for (int i = x0; i < x1; ++i)
                    for (int c = 0; c < 3; ++c) sum[c] += image.pixel(i, j)[c];
            const int count = (x1 - x0) * (y1 - y0);
            for (int c = 0; c < 3; ++c)
                small.pixel(left + x, top + y)[c] = static_cast<std::uint8_t>((sum[c] + count / 2) / count);
        }
    }
    return small;
}

/// A cell's pictures in order of time.
struct Reel {
    fs::path folder;
    std::string name;
    std::vector<std::int64_t> frames;
};

}  // namespace

SheetGrid sheet_grid(int count, double aspect, int widest) {
    SheetGrid best;
    for (int columns = 1; columns <= count; ++columns) {
        const int rows = (count + columns - 1) / columns;
        const double fits = std::min(
            {static_cast<double>(widest), 0.98 * widest_page / columns, 0.98 * highest_page / rows * aspect});
        const int width = static_cast<int>(fits) & ~1;
        // Where nothing is gained by it, a sheet is as wide as a screen.
        const double shape = columns * aspect / rows;
        if (width > best.width || (width == best.width && shape <= 1.8)) {
            best = {columns, rows, width, std::max(2, static_cast<int>(std::lround(width / aspect)) & ~1)};
        }
    }
    return best;
}

bool write_sheet_movie(const SweepResults& results, const SweepFolder& folder, const SweepOptions& options) {
    std::vector<Reel> reels;
    std::string made_of;
    std::size_t longest = 0;
    for (const ResultRow& row : results.rows) {
        if (!row.record) continue;
        Reel reel{folder.cell(row.cell->name), row.cell->name, {}};
        if (!RunFolder::look(reel.folder).has_manifest()) continue;
        reel.frames = RunFolder::look(reel.folder).kept_images();
        if (reel.frames.empty()) continue;
        longest = std::max(longest, reel.frames.size());
        made_of += fmt::format("{} {} {}\n", row.cell->name, row.cell->key, reel.frames.size());
        reels.push_back(std::move(reel));
    }
    const std::string key = fingerprint(made_of);
    std::error_code missing;
    if (reels.empty()) {
        fs::remove(folder.sheet(), missing);
        return false;
    }
    if (folder.read_sheet_key() == key && fs::exists(folder.sheet(), missing)) return true;

    const SceneFile first = load_cell(*results.sweep, *results.rows.front().cell);
    const render::Image sample = render::read_png(RunFolder::look(reels[0].folder).image(reels[0].frames[0]));
    const SheetGrid grid = sheet_grid(static_cast<int>(reels.size()),
                                      static_cast<double>(sample.width) / sample.height, sample.width);
    const bool named = grid.width >= least_named;
    std::vector<std::string> names;
    for (const Reel& reel : reels) names.push_back(reel.name);
    std::vector<render::Image> tiles(reels.size());
    std::optional<VideoWriter> movie;
    std::atomic<bool> stopped = false;
    for (std::size_t frame = 0; frame < longest; ++frame) {
        parallel_tasks(static_cast<int>(reels.size()), [&](int i) {
            const Reel& reel = reels[static_cast<std::size_t>(i)];
            if (frame >= reel.frames.size()) return;  // the last one stays
            if (options.stop && options.stop->load()) {
                stopped = true;
                return;
            }
            tiles[static_cast<std::size_t>(i)] =
                scaled(render::read_png(RunFolder::look(reel.folder).image(reel.frames[frame])), grid.width,
                       grid.height);
        });
        if (stopped) return false;
        render::Image page;
        if (named) {
            page = contact_sheet(tiles, names, grid.columns);
        } else {
            page = render::plain_image(grid.columns * grid.width, grid.rows * grid.height, {{250, 250, 250}});
            for (std::size_t i = 0; i < tiles.size(); ++i)
                render::paste(page, tiles[i], static_cast<int>(i) % grid.columns * grid.width,
                              static_cast<int>(i) / grid.columns * grid.height);
        }
        if (!movie)
            movie.emplace(folder.sheet(), page.width, page.height,
                          VideoOptions{playback_rate(first), first.output.quality, 0, options.stop});
        movie->add(page);
        if (options.progress) {
            SweepProgress progress;
            progress.cells = std::ssize(results.rows);
            progress.sheet = true;
            progress.sheet_frame = static_cast<std::int64_t>(frame) + 1;
            progress.sheet_frames = static_cast<std::int64_t>(longest);
            options.progress(progress);
        }
    }
    movie->finish();
    folder.write_sheet_key(key);
    return true;
}

}  // namespace cloth::pipeline
