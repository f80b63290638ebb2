#include <fmt/format.h>

#include <algorithm>
#include <system_error>

#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

void write_meshes(const fs::path& out, const std::vector<std::int64_t>& frames, Exporter& exporter,
                  const RunOptions& options) {
    const KeptRun run = open_run(out);
    const double frame_rate = run.file.scene.simulation.frame_rate;
    const Topology topology = read_topology(run.folder.topology());
    const StateReader read = state_reader(run.folder, run.model);
    Progress progress{.frames = static_cast<std::int64_t>(frames.size())};
    exporter.begin(topology, frame_rate);
    for (const std::int64_t frame : frames) {
        if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: no mesh was written");
        const State state = read_kept(read, frame);
        exporter.frame(frame, static_cast<double>(frame) / frame_rate,
                       Eigen::Map<const Points>(state.positions.data(), topology.rest_positions.rows(), 3));
        ++progress.simulated;
        if (options.progress) options.progress(progress);
    }
    exporter.end();
}

}  // namespace

void export_frame(const fs::path& out, std::int64_t frame, const ExportFormat& format, const fs::path& file) {
    const auto kept = RunFolder::open(out).kept_states();
    if (!std::binary_search(kept.begin(), kept.end(), frame))
        throw Error(ExitCode::usage, fmt::format("--frame {}: its state is not kept in {}; kept: {}", frame,
                                                 out.string(), span_text(kept)));
    write_meshes(out, {frame}, *format.make(file, FrameNames::as_given), {});
}

void export_frames(const fs::path& out, const FrameSpan& span, const ExportFormat& format,
                   const fs::path& file, const RunOptions& options) {
    std::error_code ignored;
    if (!file.has_filename() || fs::is_directory(file, ignored))
        throw Error(ExitCode::usage,
                    fmt::format("--file {}: is a folder; give a name in it, as in {}", file.string(),
                                (file / fmt::format("sheet{}", format.extension)).string()));
    write_meshes(out, kept_frames(RunFolder::open(out), span), *format.make(file, FrameNames::numbered),
                 options);
}

}  // namespace cloth::pipeline
