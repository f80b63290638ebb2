#include "pipeline/run/branch.h"

#include <fmt/format.h>

#include <stdexcept>
#include <system_error>

#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

/// One file under a second name.
void share(const fs::path& from, const fs::path& to) {
    std::error_code failure;
    fs::remove(to, failure);
    fs::create_hard_link(from, to, failure);
    if (failure) write_file(to, read_file(from));
}

/// The state as the branch's scene would have it at its time: what the scene says otherwise than before holds
/// from now on.
State branched(State state, const Scene& before, const Scene& now, const Model& model) {
    state.step = state.frame * model.steps_per_frame;
    state.time = static_cast<double>(state.step) * model.time_step;
    state.events_done = events_before(model, state.frame);
    if (now.simulation.integrator != before.simulation.integrator) {
        state.integrator = now.simulation.integrator;
        state.indefinite = false;
    }
    for (std::size_t c = 0; c < now.colliders.size(); ++c)
        if (now.colliders[c].enabled != before.colliders[c].enabled)
            state.collider_on[c] = now.colliders[c].enabled;
    return state;
}

}  // namespace

Branch branch_of(const fs::path& out, std::int64_t from, const SceneFile& file) {
    const KeptRun run = open_run(out);
    if (from < 0 || from >= run.frames || !fs::exists(run.folder.state(from)))
        throw Error(ExitCode::usage, fmt::format("--from {}: its state is not kept in {}; kept: {}", from,
                                                 out.string(), span_text(run.folder.kept_states())));
    const auto refuse = [&](const std::string& what) {
        throw Error(ExitCode::invalid_scene,
                    fmt::format("a branch of {} {}; that needs a run of its own", out.string(), what));
    };
    if (file.scene.simulation.frame_rate != run.file.scene.simulation.frame_rate)
        refuse("cannot change simulation.frame_rate: its frames stand at other times");
    if (file.scene.colliders.size() != run.file.scene.colliders.size() ||
        file.scene.drags.size() != run.file.scene.drags.size())
        refuse("cannot have other colliders or drags");
    const Model model = build_model(file.scene);
    if (!same_topology(read_topology(run.folder.topology()), model))
        refuse("cannot change the cloth's rest shape");

    Branch branch{run.folder, read_ledger(run.folder.ledger()), from, {}, {}, {}};
    for (std::int64_t frame = 0; frame <= from; ++frame) {
        const auto entry = branch.entries.states.find(frame);
        const fs::path path = run.folder.state(frame);
        if (entry == branch.entries.states.end() || file_fingerprint(path) != entry->second.file)
            throw Error(ExitCode::other,
                        fmt::format("{}: damaged, gone or without a line in {}; run the scene into {} again "
                                    "first",
                                    path.string(), run.folder.ledger().filename().string(), out.string()));
        branch.trunk.keys.push_back(entry->second.key);
        branch.record = entry->second.record;
    }
    branch.trunk.keys.back() = branch_key(file, branch.trunk.keys.back());
    branch.start =
        branched(read_kept(state_reader(run.folder, run.model), from), run.file.scene, file.scene, model);
    if (branch.start.rest_folds.size() != start_state(model).rest_folds.size())
        refuse("cannot change which folds can crease");
    return branch;
}

void share_past(const Branch& branch, StartedRun& started) {
    RunPlan& plan = started.plan;
    for (std::int64_t frame = 0; frame < std::min(branch.from, plan.frames); ++frame) {
        if (!plan.has_state(frame)) {
            const StateEntry& entry = branch.entries.states.at(frame);
            share(branch.source.state(frame), started.folder.state(frame));
            started.ledger->add_state(frame, entry);
            plan.kept.states[frame] = entry;
        }
        const auto picture = branch.entries.pictures.find(frame);
        if (picture == branch.entries.pictures.end() || plan.has_picture(frame) ||
            picture->second.key != plan.pictures.at(static_cast<std::size_t>(frame)) ||
            file_fingerprint(branch.source.image(frame)) != picture->second.file)
            continue;
        share(branch.source.image(frame), started.folder.image(frame));
        started.ledger->add_picture(frame, picture->second);
        plan.kept.pictures[frame] = picture->second;
    }
    if (branch.from >= plan.frames || plan.has_state(branch.from)) return;
    const std::string bytes =
        write_state(branch.start, started.folder.state(branch.from), Compression::fast, Sync::yes);
    const StateEntry entry{branch.trunk.keys.back(), bytes, branch.record};
    started.ledger->add_state(branch.from, entry);
    plan.kept.states[branch.from] = entry;
}

RunSummary resume_run(const fs::path& source, std::int64_t from, const SceneFile& file, const fs::path& out,
                      const RunOptions& options) {
    std::error_code failure;
    if (fs::equivalent(source, out, failure))
        throw Error(ExitCode::usage,
                    fmt::format("--out {}: is the run itself; give a folder for the branch", out.string()));
    if (file.output.frames <= from)
        throw Error(ExitCode::usage, fmt::format("--frames {}: a branch from frame {} needs more than that",
                                                 file.output.frames, from));
    require_place(out, file);
    const Branch branch = branch_of(source, from, file);
    return run_scene(file, out, options, &branch);
}

}  // namespace cloth::pipeline
