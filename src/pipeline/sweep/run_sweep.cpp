#include "pipeline/sweep/run_sweep.h"

#include <fcntl.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <list>
#include <new>
#include <optional>
#include <system_error>
#include <thread>

#include <fmt/format.h>

#include "base/child.h"
#include "base/stopwatch.h"
#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/video.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/sweep/index_page.h"
#include "pipeline/sweep/run_cell.h"
#include "pipeline/sweep/sheet_movie.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// What the processes of a sweep's cells and this one see alike.
struct alignas(64) Shared {
    std::atomic<bool> stop;
    struct Slot {
        std::atomic<std::int64_t> frame, frames;
    };
    Slot* slots() { return reinterpret_cast<Slot*>(this + 1); }
};
static_assert(std::atomic<bool>::is_always_lock_free && std::atomic<std::int64_t>::is_always_lock_free);

/// The file of a cell's log, with what is known of the cell before it runs.
int open_log(const SweepFile& sweep, const SweepFolder& folder, const Cell& cell) {
    const fs::path path = folder.log(cell.name);
    const int file =
        ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0666);
    if (file < 0)
        throw Error(ExitCode::other, fmt::format("cannot write {}: {}", path.string(), std::strerror(errno)));
    std::string head = fmt::format("cell {} of {}\n", cell.name, sweep.path.string());
    if (cell.sample >= 0) head += fmt::format("sample {}, seed {}\n", cell.sample, sweep.seed);
    head += "render_cloth --scene " + sweep.scene;
    for (const Override& each : cell.overrides) head += " --set '" + each.setting + "'";
    head += "\n";
    [[maybe_unused]] const ssize_t written = ::write(file, head.data(), head.size());
    return file;
}

class SweepRun {
  public:
    SweepRun(const SweepFile& sweep, const SweepFolder& folder, const SweepResults& before,
             const SweepOptions& options)
        : sweep_(sweep),
          folder_(folder),
          options_(options),
          cores_(std::max(1, static_cast<int>(std::thread::hardware_concurrency()))),
          workers_(options.workers > 0 ? options.workers : cores_),
          memory_(sizeof(Shared) + static_cast<std::size_t>(workers_) * sizeof(Shared::Slot)),
          shared_(new (memory_.data()) Shared) {
        for (int i = 0; i < workers_; ++i) free_.push_back(i);
        progress_.cells = std::ssize(before.rows);
        for (const ResultRow& row : before.rows) {
            if (row.record && is_kept(row)) {
                ++progress_.kept;
                ++progress_.done;
            } else if (row.record && row.record->status == CellStatus::failed && !options.retry) {
                ++progress_.failed;
                if (first_failure_.empty()) first_failure_ = row.cell->name + ": " + row.record->reason;
            } else {
                waiting_.push_back(row.cell);
            }
        }
        std::reverse(waiting_.begin(), waiting_.end());
    }

    SweepSummary run() {
        Stopwatch told;
        bool tell = true;
        while (!at_work_.empty() || (!waiting_.empty() && !stopping())) {
            shared_->stop = stopping();
            while (!waiting_.empty() && !free_.empty() && !stopping()) {
                start(*waiting_.back());
                waiting_.pop_back();
            }
            const bool some_ended = wait();
            if (some_ended || tell || told.seconds() > 0.2) {
                report();
                told = Stopwatch();
                tell = false;
            }
        }
        SweepSummary summary;
        summary.cells = progress_.cells;
        summary.kept = progress_.kept;
        summary.done = progress_.done;
        summary.failed = progress_.failed;
        summary.left = progress_.cells - progress_.done - progress_.failed;
        summary.first_failure = first_failure_;
        summary.cells_wall = cells_wall_;
        summary.workers = workers_;
        summary.interrupted = stopping() && summary.left > 0;
        return summary;
    }

  private:
    struct Worker {
        const Cell* cell;
        int slot;
        Child child;
    };

    bool stopping() const { return options_.stop && options_.stop->load(); }

    /// Whether a cell's results are there, and the files that belong to them.
    bool is_kept(const ResultRow& row) const {
        if (row.record->status == CellStatus::failed) return false;
        const fs::path folder = folder_.cell(row.cell->name);
        std::error_code missing;
        const RunFolder run = RunFolder::look(folder);
        const bool wants_movie =
            options_.movie && sweep_.results.movies && sweep_.results.pictures == CellPictures::all;
        return fs::exists(run.certificate(), missing) &&
               (!wants_movie || fs::exists(run.movie(fs::path(sweep_.scene).stem().string()), missing)) &&
               (row.record->picture.empty() || fs::exists(folder / row.record->picture, missing));
    }

    void start(const Cell& cell) {
        const int slot = free_.back();
        free_.pop_back();
        Shared::Slot& place = shared_->slots()[slot];
        place.frame = place.frames = 0;
        const int log = open_log(sweep_, folder_, cell);
        const auto work = [&] {
            return line_of(cell.name, run_cell(sweep_, folder_, cell, cell_options(slot)));
        };
        try {
            at_work_.push_back({&cell, slot, Child(work, {.seconds = 0}, log)});
        } catch (...) {
            ::close(log);
            throw;
        }
        ::close(log);
    }

    /// As a cell sees them, in its own process.
    RunOptions cell_options(int slot) const {
        RunOptions run;
        run.threads = std::max(1, cores_ / workers_);
        run.gl = options_.gl;
        run.movie = options_.movie;
        run.stop = &shared_->stop;
        run.progress = [&place = shared_->slots()[slot]](const Progress& progress) {
            place.frames = progress.frames;
            place.frame = std::max(progress.simulated, progress.written);
        };
        run.tell = [](const std::string& line) {
            const std::string text = one_line(line) + "\n";
            [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, text.data(), text.size());
        };
        return run;
    }

    /// Waits a moment for a cell to end, and takes all that have.
    bool wait() {
        std::vector<pollfd> pipes;
        for (const Worker& worker : at_work_) pipes.push_back({worker.child.pipe(), POLLIN, 0});
        if (::poll(pipes.data(), pipes.size(), 100) <= 0) return false;
        bool ended = false;
        std::size_t i = 0;
        for (auto worker = at_work_.begin(); worker != at_work_.end(); ++i) {
            if (pipes[i].revents == 0 || worker->child.receive()) {
                ++worker;
                continue;
            }
            end(*worker);
            worker = at_work_.erase(worker);
            ended = true;
        }
        return ended;
    }

    void end(Worker& worker) {
        free_.push_back(worker.slot);
        CellRecord record;
        try {
            record = record_of(worker.child.answer()).second;
        } catch (const std::exception& error) {  // it crashed, or was killed
            record.key = worker.cell->key;
            record.status = CellStatus::failed;
            record.reason = std::string("its process ") + error.what();
            record.frames = shared_->slots()[worker.slot].frames;
            const RunFolder run = RunFolder::look(folder_.cell(worker.cell->name));
            if (run.has_manifest() && !run.kept_states().empty())
                record.last_frame = run.kept_states().back();
        }
        cells_wall_ += record.wall;
        if (record.key.empty()) return;  // interrupted
        folder_.add_record(worker.cell->name, record);
        ++(record.status == CellStatus::failed ? progress_.failed : progress_.done);
        if (record.reason.empty()) return;
        if (options_.tell) options_.tell(fmt::format("cell {}: {}", worker.cell->name, record.reason));
        if (record.status == CellStatus::failed && first_failure_.empty())
            first_failure_ = worker.cell->name + ": " + record.reason;
    }

    void report() {
        if (!options_.progress) return;
        progress_.seconds = watch_.seconds();
        progress_.running.clear();
        for (const Worker& worker : at_work_) {
            const Shared::Slot& place = shared_->slots()[worker.slot];
            progress_.running.push_back({worker.cell->name, place.frame, place.frames});
        }
        options_.progress(progress_);
    }

    const SweepFile& sweep_;
    const SweepFolder& folder_;
    const SweepOptions& options_;
    int cores_, workers_;
    SharedMemory memory_;
    Shared* shared_;
    Stopwatch watch_;
    SweepProgress progress_;
    std::vector<const Cell*> waiting_;  ///< the next at the end
    std::vector<int> free_;             ///< slots
    std::list<Worker> at_work_;
    double cells_wall_ = 0;
    std::string first_failure_;
};

}  // namespace

SweepSummary run_sweep(const SweepFile& sweep, const fs::path& out, const SweepOptions& options) {
    const Stopwatch wall;
    SweepFolder::look(out, sweep);
    const bool wants_movie = options.movie && sweep.results.pictures == CellPictures::all &&
                             (sweep.results.sheet || sweep.results.movies);
    if (wants_movie) ffmpeg_version(options.stop);
    SweepCells cells = cells_of(sweep);
    const SweepFolder folder = SweepFolder::create(out, sweep);
    const SweepResults before = results_of(sweep, std::move(cells), folder.read_records());
    SweepSummary summary = SweepRun(sweep, folder, before, options).run();

    const SweepResults results = results_of(sweep, before.cells, folder.read_records());
    write_file(folder.csv(), results_csv(results));
    write_results_npz(results, folder.npz());
    if (wants_movie && sweep.results.sheet && !summary.interrupted)
        summary.sheet = write_sheet_movie(results, folder, options);
    write_index_page(results, folder);
    summary.wall = wall.seconds();
    return summary;
}

SweepResults kept_results(const SweepFile& sweep, const fs::path& out) {
    const SweepFolder folder = SweepFolder::look(out, sweep);
    return results_of(sweep, cells_of(sweep), folder.read_records());
}

}  // namespace cloth::pipeline
