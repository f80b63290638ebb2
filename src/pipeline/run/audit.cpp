#include "pipeline/run/audit.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <random>

#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/state_store.h"
#include "sim/simulation.h"

namespace cloth::pipeline {

AuditResult audit_run(const std::filesystem::path& out, const AuditOptions& audit,
                      const RunOptions& options) {
    const KeptRun run = open_run(out);
    const Manifest manifest = run.folder.read_manifest();
    if (manifest.build != maker())
        throw Error(ExitCode::other,
                    fmt::format("{}: made by another build ({}); only the same one ({}) makes "
                                "the same bits",
                                out.string(), manifest.build, maker()));
    const std::vector<std::int64_t> kept = run.folder.kept_states();
    const LedgerEntries ledger = read_ledger(run.folder.ledger());
    AuditResult result;
    std::map<std::int64_t, std::string> faults;
    for (const std::int64_t frame : kept) {
        const auto entry = ledger.states.find(frame);
        ++result.read;
        if (entry == ledger.states.end())
            faults[frame] = "has no line in the ledger";
        else if (file_fingerprint(run.folder.state(frame)) != entry->second.file)
            faults[frame] = "is not the file that its line in the ledger tells of";
    }

    // Frames that can be made from a kept one before them. Up to where a branch begins they are another
    // run's.
    std::vector<std::int64_t> checkable;
    for (const std::int64_t frame : kept)
        if (frame > 0 && std::binary_search(kept.begin(), kept.end(), frame - 1) &&
            frame >= std::ssize(manifest.trunk))
            checkable.push_back(frame);
    if (checkable.empty())
        throw Error(ExitCode::other,
                    fmt::format("{}: keeps no two successive states to audit", out.string()));
    Simulation simulation(run.file.scene, options.threads);
    simulation.stop_on(options.stop);
    const StateReader read = state_reader(run.folder, run.model);
    const auto whole = [&](std::int64_t frame) { return !faults.contains(frame); };
    if (kept.front() == 0 && whole(0) && manifest.trunk.empty() &&
        state_bytes(read_kept(read, 0)) != state_bytes(simulation.state()))
        faults[0] = "is not the scene's start";

    std::mt19937 random(audit.seed);
    const auto length = std::min<std::int64_t>(audit.length, std::ssize(checkable));
    std::uniform_int_distribution<std::int64_t> begin(0, std::ssize(checkable) - length);
    for (int w = 0; w < audit.windows; ++w) {
        const std::int64_t first = begin(random);
        result.windows.push_back({checkable[static_cast<std::size_t>(first)],
                                  checkable[static_cast<std::size_t>(first + length - 1)] + 1});
        for (std::int64_t i = first; i < first + length; ++i) {
            if (options.stopping()) throw Error(ExitCode::interrupted, "interrupted: the audit is not done");
            const std::int64_t frame = checkable[static_cast<std::size_t>(i)];
            if (!whole(frame) || !whole(frame - 1)) continue;
            simulation.restore(read_kept(read, frame - 1));
            const FrameReport report = simulation.advance_frame();
            ++result.simulated;
            if (!report.converged) {
                faults[frame] = "does not converge from the frame before it";
                continue;
            }
            if (state_bytes(simulation.state()) != state_bytes(read_kept(read, frame)))
                faults[frame] = "is not what the frame before it leads to";
        }
    }
    for (const auto& [frame, fault] : faults) {
        const auto entry = ledger.states.find(frame);
        result.findings.push_back(
            {frame, entry == ledger.states.end() ? "" : entry->second.record.host, fault});
    }
    return result;
}

}  // namespace cloth::pipeline
