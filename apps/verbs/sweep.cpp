#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <map>
#include <optional>

#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/sweep/run_sweep.h"

namespace cloth::verbs {
namespace {

namespace fs = std::filesystem;
using pipeline::SweepProgress;

struct Values {
    std::string file, out;
    int workers = 0;
    bool dry_run = false, retry = false;
    std::vector<std::string> plot;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"sweep", "FILE", "The sweep, a TOML file", true}, values.file);
    flags.text({"--out", "DIR", "Folder of the results (default: out/NAME)"}, values.out);
    flags.integer({"--workers", "N", "Cells at a time (default: one a core)"}, values.workers, 1, 1024);
    flags.yes("--dry-run", values.dry_run, "Print the cells; run nothing");
    flags.yes("--retry", values.retry, "Run cells that failed again");
    flags.words({"--plot", "X:Y FILE", "Plot of two columns of the results, an SVG"}, values.plot, 2);
    values.work.add_gl(flags);
    flags.yes("--quiet", values.work.quiet, "No progress");
    flags.yes("--no-video", values.work.no_video, "No movies");
}

/// The table of a sweep's cells on standard error: drawn over itself on a terminal, a line every few seconds
/// elsewhere.
class LiveTable {
  public:
    explicit LiveTable(bool quiet) : quiet_(quiet) {}
    ~LiveTable() { clear(); }
    LiveTable(const LiveTable&) = delete;
    LiveTable& operator=(const LiveTable&) = delete;

    void show(const SweepProgress& progress) {
        if (quiet_) return;
        const bool first = !shown_;
        const bool end = progress.done + progress.failed == progress.cells && !progress.sheet;
        if (!first && !end && since_.seconds() < (terminal_ ? 0.1 : 10.0)) return;
        if (end && !terminal_ && ended_) return;
        ended_ = end;
        shown_ = true;
        since_ = Stopwatch();
        std::string text = head(progress);
        if (terminal_) {
            for (const SweepProgress::Running& each : progress.running) {
                text += "\n  " + bar(each.frame, each.frames) +
                        (each.frames > 0 ? fmt::format(" {:>4}/{:<4} ", each.frame, each.frames)
                                         : std::string("   begins  ")) +
                        each.cell.substr(0, 60);
            }
            clear();
            lines_ = static_cast<int>(std::count(text.begin(), text.end(), '\n')) + 1;
        }
        std::fputs((text + "\n").c_str(), stderr);
        std::fflush(stderr);
    }

    void tell(const std::string& line) {
        clear();
        std::fputs(("render_cloth: note: " + one_line(line) + "\n").c_str(), stderr);
    }

  private:
    static std::string bar(std::int64_t done, std::int64_t all) {
        constexpr std::int64_t width = 24;
        const auto full = static_cast<std::size_t>(all > 0 ? std::min(width, width * done / all) : 0);
        return "[" + std::string(full, '#') + std::string(width - full, '.') + "]";
    }
    std::string head(const SweepProgress& progress) const {
        if (progress.sheet)
            return fmt::format("the movie of all cells: {}/{} frames", progress.sheet_frame,
                               progress.sheet_frames);
        const std::int64_t ended = progress.done + progress.failed;
        std::string text = fmt::format("{}/{} cells done, {} running, {} failed", progress.done,
                                       progress.cells, progress.running.size(), progress.failed);
        const std::int64_t made = ended - std::min(ended, progress.kept + failed_before_.value_or(0));
        if (!failed_before_) failed_before_ = progress.failed;
        if (made > 0 && progress.seconds > 0) {
            const double rate = static_cast<double>(made) / progress.seconds;
            text += fmt::format(", {:.2f} cells/s, {} left", rate,
                                cli::clock_text(static_cast<double>(progress.cells - ended) / rate));
        }
        return terminal_ ? bar(ended, progress.cells) + " " + text : text;
    }
    void clear() {
        if (lines_ > 0) std::fputs(fmt::format("\033[{}A\r\033[J", lines_).c_str(), stderr);
        lines_ = 0;
    }

    bool quiet_, terminal_ = ::isatty(STDERR_FILENO) == 1;
    bool shown_ = false, ended_ = false;
    int lines_ = 0;  ///< that stand on the terminal
    mutable std::optional<std::int64_t> failed_before_;
    Stopwatch since_;
};

void print_cells(const pipeline::SweepResults& results) {
    const pipeline::SweepCells& cells = results.cells;
    std::size_t widest = 4;
    for (const pipeline::Cell& cell : cells.cells) widest = std::max(widest, cell.name.size());
    std::map<std::string, int> by_status;
    for (const pipeline::ResultRow& row : results.rows) {
        std::string line = fmt::format("{:<{}}  {:<7}", row.cell->name, widest, row.status());
        for (const pipeline::CellValue& each : row.cell->values)
            line += fmt::format("  {} = {}", each.key, each.text);
        fmt::print("{}\n", one_line(line));
        ++by_status[row.status()];
    }
    std::string line = plural(std::ssize(cells.cells), "cell");
    for (const auto& [status, count] : by_status) line += fmt::format(", {} {}", count, status);
    if (cells.left_out > 0) line += fmt::format("; {} left out by constraints", cells.left_out);
    fmt::print("{}\n", line);
}

cli::ExitCode work(const Values& values) {
    const pipeline::SweepFile sweep = pipeline::load_sweep(values.file);
    const fs::path out = values.out.empty() ? fs::path("out") / sweep.name : fs::path(values.out);
    if (values.dry_run) {
        print_cells(pipeline::kept_results(sweep, out));
        return cli::ExitCode::good;
    }
    std::string plot_x, plot_y;
    if (!values.plot.empty()) {
        const auto names = split(values.plot[0], ':');
        if (names.size() != 2)
            cli::refuse("--plot " + values.plot[0] + ": give two columns, as in friction:drape_coefficient");
        plot_x = names[0];
        plot_y = names[1];
        pipeline::plot_of(pipeline::kept_results(sweep, out), plot_x,
                          plot_y);  // refused before anything runs
    }
    pipeline::SweepSummary summary;
    {
        const cli::StopRequest request;
        LiveTable table(values.work.quiet);
        pipeline::SweepOptions options;
        options.workers = values.workers;
        options.retry = values.retry;
        options.movie = !values.work.no_video;
        options.gl = values.work.gl_library();
        options.stop = request.flag();
        options.progress = [&](const SweepProgress& progress) { table.show(progress); };
        options.tell = [&](const std::string& line) { table.tell(line); };
        summary = pipeline::run_sweep(sweep, out, options);
    }
    if (!plot_x.empty())
        pipeline::write_file(values.plot[1], std::string(pipeline::own_mark) + "\n" +
                                                 to_svg(pipeline::plot_of(pipeline::kept_results(sweep, out),
                                                                          plot_x, plot_y)));
    if (summary.interrupted)
        throw pipeline::Error(
            cli::ExitCode::interrupted,
            fmt::format("interrupted: {} of {} cells are done in {}; the same command again "
                        "continues",
                        summary.done, summary.cells, out.string()));
    std::string line = fmt::format("{}: {}", sweep.name, plural(summary.cells, "cell"));
    if (summary.kept > 0) line += fmt::format(", {} kept", summary.kept);
    if (summary.cells_wall > 0)
        line += fmt::format(" (wall {:.1f} s, cells {:.1f} s on {}, overhead {:.1f} %)", summary.wall,
                            summary.cells_wall, plural(summary.workers, "worker"), 100 * summary.overhead());
    fmt::print("{}: {}\n", line, (out / "index.html").string());
    if (summary.failed > 0)
        throw pipeline::Error(cli::ExitCode::other,
                              fmt::format("{} of {} cells failed, the first: {}; --retry runs them again",
                                          summary.failed, summary.cells, summary.first_failure));
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb sweep() {
    return cli::verb("sweep", "One scene in many variants: numbers, pictures, a page of results", add, work);
}

}  // namespace cloth::verbs
