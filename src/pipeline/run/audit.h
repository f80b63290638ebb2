#pragma once
// Whether kept states are what the program makes: windows of frames are simulated again and compared bit by
// bit.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/run/kept_run.h"
#include "pipeline/run/run_options.h"

namespace cloth::pipeline {

struct AuditOptions {
    int windows = 3;         ///< parts of the run that are simulated again
    int length = 5;          ///< frames of each
    std::uint32_t seed = 1;  ///< of where they lie
};

struct AuditFinding {
    std::int64_t frame = 0;
    std::string host;   ///< that made it; empty: unknown
    std::string fault;  ///< empty: it is good
};

struct AuditResult {
    std::vector<FrameSpan> windows;      ///< frames that were simulated again
    std::vector<AuditFinding> findings;  ///< of the bad frames, in order
    std::int64_t read = 0, simulated = 0;
};

/// Reads every kept state against its line in the ledger, and simulates windows again, each frame from the
/// kept one before it. Throws Error(other) where another build made the run, or it keeps no two states.
AuditResult audit_run(const std::filesystem::path& out, const AuditOptions& audit, const RunOptions& options);

}  // namespace cloth::pipeline
