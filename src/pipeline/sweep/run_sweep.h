#pragma once
// A whole sweep on this machine: its cells side by side, each in a process of its own, then their results.

#include <array>
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "pipeline/sweep/cells.h"
#include "pipeline/sweep/results.h"
#include "pipeline/sweep/sweep_folder.h"
#include "render/gl/gl_library.h"

namespace cloth::pipeline {

/// How far a sweep is.
struct SweepProgress {
    struct Running {
        std::string cell;
        std::int64_t frame = 0, frames = 0;  ///< finished, and to be made; 0: not known yet
    };
    std::int64_t cells = 0;
    std::int64_t kept = 0;    ///< done before this began
    std::int64_t done = 0;    ///< with those that were kept
    std::int64_t failed = 0;  ///< the same
    std::vector<Running> running;
    double seconds = 0;  ///< since the first cell began
    bool sheet = false;  ///< the movie of all cells is made: `sheet_frame` of `sheet_frames`
    std::int64_t sheet_frame = 0, sheet_frames = 0;
};

struct SweepOptions {
    int workers = 0;     ///< cells at a time; ≤ 0: one a core
    bool retry = false;  ///< cells that failed are run again
    bool movie = true;   ///< the movie of all cells, and those of cells, where the sweep asks for them
    render::GlLibrary gl = render::GlLibrary::automatic;
    std::function<void(const SweepProgress&)> progress;  ///< several times a second
    std::function<void(const std::string& line)> tell;   ///< what a user is to know, a cell's failure too
    const std::atomic<bool>* stop = nullptr;             ///< true: no further cell begins, running ones stop
};

struct SweepSummary {
    std::int64_t cells = 0, done = 0, kept = 0, failed = 0,
                 left = 0;      ///< `left`: not run, or not to their end
    std::string first_failure;  ///< "NAME: reason"
    double wall = 0;            ///< of all [s]
    double cells_wall = 0;      ///< sum of what the cells that were run took [s]
    int workers = 0;
    bool interrupted = false;
    bool sheet = false;  ///< there is a movie of all cells
    /// Share of the workers' time that went into something else than cells.
    double overhead() const { return wall > 0 && workers > 0 ? 1.0 - cells_wall / (wall * workers) : 0.0; }
};

/// What is missing of the sweep into the folder `out`, then its results. Throws as cells_of() and
/// SweepFolder::create() before anything is run. A cell that fails stops no other.
SweepSummary run_sweep(const SweepFile& sweep, const std::filesystem::path& out, const SweepOptions& options);

/// The results of a sweep as they stand in its folder. Throws as SweepFolder::look().
SweepResults kept_results(const SweepFile& sweep, const std::filesystem::path& out);

}  // namespace cloth::pipeline
