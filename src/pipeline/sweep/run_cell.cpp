#include "pipeline/sweep/run_cell.h"

#include <fcntl.h>
#include <unistd.h>

#include <exception>
#include <new>
#include <system_error>

#include <fmt/format.h>

#include "base/stopwatch.h"
#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/ledger.h"
#include "pipeline/run/run.h"
#include "pipeline/sweep/measures.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// All measures of a run that has a state of its last frame.
std::vector<double> measured(const SweepFile& sweep, const RunFolder& run, std::int64_t frames) {
    std::vector<FrameRecord> records;
    for (const auto& [frame, entry] : read_ledger(run.ledger()).states)
        if (frame < frames) records.push_back(entry.record);
    const Topology topology = read_topology(run.topology());
    const State last = read_state(run.state(frames - 1));
    const MeasuredRun seen{topology, last, records, sweep.results.pedestal_radius};
    std::vector<double> values;
    for (const Measure& measure : measures()) values.push_back(measure.of(seen));
    return values;
}

/// Until the disk has all that was written, so that no power cut leaves a cell done without its files.
void sync_disk_of(const fs::path& folder) {
    const int file = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    if (file < 0) return;
    ::syncfs(file);
    ::close(file);
}

/// The last frame whose state is kept; -1: none.
std::int64_t last_frame(const fs::path& folder) {
    const RunFolder run = RunFolder::look(folder);
    if (!run.has_manifest()) return -1;
    const auto states = run.kept_states();
    return states.empty() ? -1 : states.back();
}

/// The picture of the last frame that has one, relative to the run's folder.
std::string last_picture(const fs::path& folder) {
    const RunFolder run = RunFolder::look(folder);
    if (!run.has_manifest()) return {};
    const auto images = run.kept_images();
    if (!images.empty()) return run.image(images.back()).lexically_relative(folder).string();
    std::error_code missing;
    return fs::exists(run.overlap(), missing) ? run.overlap().lexically_relative(folder).string() : "";
}

}  // namespace

CellRecord run_cell(const SweepFile& sweep, const SweepFolder& folder, const Cell& cell,
                    const RunOptions& options) {
    const Stopwatch wall;
    CellRecord record;
    record.key = cell.key;
    const fs::path out = folder.cell(cell.name);
    const auto failed = [&](CellStatus status, const std::string& reason) {
        record.status = status;
        record.reason = one_line(reason);
        if (options.tell) options.tell(record.reason);
    };
    try {
        const SceneFile file = load_cell(sweep, cell);
        record.frames = file.output.frames;
        if (options.tell)
            for (const std::string& note : file.notes) options.tell(note);
        RunOptions own = options;
        own.sync = Sync::no;  // all at once, below
        const CellPictures pictures = sweep.results.pictures;
        own.pictures = pictures == CellPictures::all;
        own.movie = own.page =
            own.pictures && sweep.results.movies;  // a page is a megabyte, of a thousand cells
        bool interrupted = false;
        try {
            interrupted = run_scene(file, out, own).interrupted;
        } catch (const Error& error) {
            if (error.code != ExitCode::broken_promise) throw;
            failed(CellStatus::broken, error.what());
        }
        if (!interrupted && pictures == CellPictures::last) {
            own.movie = false;
            const std::int64_t last = file.output.frames - 1;
            interrupted = render_run(out, FrameSpan{last, last + 1}, {}, own).interrupted;
        }
        if (interrupted) {
            record.key.clear();
        } else {
            sync_disk_of(out);
            record.measures = measured(sweep, RunFolder::open(out), file.output.frames);
        }
    } catch (const Error& error) {
        if (error.code == ExitCode::interrupted) record.key.clear();
        failed(CellStatus::failed, error.what());
    } catch (const SceneError& error) {
        failed(CellStatus::failed, error.key.empty() ? error.what() : error.key + ": " + error.what());
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        failed(CellStatus::failed, error.what());
    }
    record.last_frame = last_frame(out);
    record.picture = sweep.results.pictures == CellPictures::none ? "" : last_picture(out);
    record.wall = wall.seconds();
    return record;
}

}  // namespace cloth::pipeline
