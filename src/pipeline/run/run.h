#pragma once
// A whole run: simulate, draw, write pictures, encode; and what can be made again from a run that is kept.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/formats/exporters.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/report.h"
#include "pipeline/run/run_options.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

struct Branch;

/// Runs `file` for its output.frames frames into the folder `out`, and leaves a report and a certificate
/// there. What a run there has kept that would become the same bits is used again (plan.h), the rest goes,
/// and `options.tell` is told before. `branch`: what it goes on from (branch.h). What can be refused is
/// refused before anything there is touched: a folder that is no place for it (require_place()), SceneError,
/// Error(encoder) without ffmpeg. Throws Error(not_converged) at the first state with a fault, naming frame,
/// vertex and last good frame, once the good frames are drawn; Error(encoder) where only the movie failed,
/// once all is drawn; Error(broken_promise) where all is made and a limit of [expect] does not hold.
RunSummary run_scene(const SceneFile& file, const std::filesystem::path& out, const RunOptions& options,
                     const Branch* branch = nullptr);

/// What run_scene() would use again and what it would make, and why: a line each. Changes nothing.
std::vector<std::string> explain_run(const SceneFile& file, const std::filesystem::path& out,
                                     const RunOptions& options);

/// Goes on from frame `from` of the run in `source` as `file`, its scene with other keys, in the folder
/// `out`. What both have in common is shared, not copied. Throws as branch_of() and run_scene().
RunSummary resume_run(const std::filesystem::path& source, std::int64_t from, const SceneFile& file,
                      const std::filesystem::path& out, const RunOptions& options);

/// Draws the kept states of the run in `out`, and makes the movie where the pictures of all of them are there
/// in the end. Throws Error(other) where a state between them is missing. `overrides` change the scene that
/// is drawn, not the kept one. Throws Error(usage) for a span with frames that have no state.
RunSummary render_run(const std::filesystem::path& out, const std::optional<FrameSpan>& span,
                      const Overrides& overrides, const RunOptions& options);

/// Makes the movie again from the kept pictures (movie_frames()), which must be of one size.
RunSummary encode_run(const std::filesystem::path& out, const Overrides& overrides,
                      const RunOptions& options);

/// What of a run is exported.
struct ExportChoice {
    std::optional<FrameSpan> frames = {};  ///< default: all that are kept
    std::string cloth = {};                ///< this one alone; empty: all
};
/// Gives every `every`th kept frame of a run, from its first on, to an exporter. Throws Error(other);
/// Error(interrupted) where it is stopped.
void record_frames(const std::filesystem::path& out, int every, Exporter& exporter,
                   const RunOptions& options);
/// Writes kept states in a format of meshes: with FrameNames::numbered sheet_000000.obj … for the file
/// sheet.obj in a format of one file per frame, else that one file. Throws Error(usage) where a frame is not
/// kept, there is no such cloth, `file` is a folder, or the format cannot hold what is asked;
/// Error(interrupted) where it is stopped; no file is left then. Returns the frames.
std::vector<std::int64_t> export_frames(const std::filesystem::path& out, const ExportChoice& choice,
                                        const ExportFormat& format, const std::filesystem::path& file,
                                        FrameNames names, const RunOptions& options);

}  // namespace cloth::pipeline
