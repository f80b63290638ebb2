#include <fmt/format.h>

#include <algorithm>

#include "pipeline/formats/error.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

void export_frame(const fs::path& out, std::int64_t frame, MeshFormat format, const fs::path& file) {
    const RunFolder folder = RunFolder::open(out);
    const auto kept = folder.kept_states();
    if (!std::binary_search(kept.begin(), kept.end(), frame))
        throw Error(ExitCode::usage, fmt::format("--frame {}: its state is not kept in {}; kept: {}", frame,
                                                 out.string(), span_text(kept)));
    const Topology topology = read_topology(folder.topology());
    const State state = read_state(folder.state(frame));
    if (state.positions.size() != topology.rest_positions.size())
        throw Error(ExitCode::other,
                    folder.state(frame).string() + ": does not fit " + folder.topology().string());
    MeshData mesh;
    mesh.positions = Eigen::Map<const Points>(state.positions.data(), topology.rest_positions.rows(), 3);
    mesh.triangles = topology.triangles;
    write_mesh(mesh, format, file);
}

}  // namespace cloth::pipeline
