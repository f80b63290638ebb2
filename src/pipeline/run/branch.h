#pragma once
// A run that goes on from a frame of another, with other keys. Internal to this room.

#include <cstdint>

#include "pipeline/run/kept_run.h"
#include "pipeline/run/ledger.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

struct Branch {
    RunFolder source;
    LedgerEntries entries;  ///< of the source
    std::int64_t from = 0;  ///< the frame where it begins
    Trunk trunk;            ///< keys of the frames up to it
    State start;            ///< that of `from`, as the branch's scene has it
    FrameRecord record;     ///< of `from`
};

/// The branch of the kept run in `out` at `from`, to be run as `file`. Throws Error(usage) where that frame
/// is not kept, Error(other) where a state up to it is damaged, Error(invalid_scene) where `file` has other
/// cloth, colliders, drags or another frame rate.
Branch branch_of(const std::filesystem::path& out, std::int64_t from, const SceneFile& file);

/// Puts the common past where it is missing: states and pictures before `from` by hard links, or copies where
/// those fail, and the state of `from`.
void share_past(const Branch& branch, StartedRun& started);

}  // namespace cloth::pipeline
