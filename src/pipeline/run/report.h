#pragma once
// What a run tells of itself, and report.json, which keeps it: written and read here alone.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "pipeline/picture/survey.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"
#include "sim/stepping/step_report.h"

namespace cloth::pipeline {

/// What is known of one simulated frame.
struct FrameRecord {
    FrameReport report;
    std::string state_hash;
};

/// Time that each stage was busy [s]; they overlap, so `wall` is less than their sum.
struct StageTimes {
    double simulate = 0, store = 0, draw = 0, png = 0, encode = 0, wall = 0;
};

struct RunSummary {
    std::string scene;
    std::int64_t frames = 0;    ///< asked for
    std::int64_t states = 0;    ///< written
    std::int64_t images = 0;    ///< written
    int width = 0, height = 0;  ///< of the pictures [pixel]; 0 without
    double playback_rate = 0;   ///< [1/s]
    bool interrupted = false;
    std::vector<FrameRecord> records;
    StageTimes times;
    std::string renderer, encoder;  ///< versions; empty where not used
    std::filesystem::path movie;    ///< empty where none was made
};

/// The report of a simulation. `outcome`: "complete", "interrupted", or the line that tells of a failure.
void write_report(const RunFolder& folder, const SceneFile& file, const Model& model,
                  const RunSummary& summary, const std::string& outcome);

/// Redrawing adds to the report of the simulation, under "redrawn".
void amend_report(const RunFolder& folder, const RunSummary& summary);

/// What report.json tells of its frames; nothing where there is none that can be read: a run that was killed
/// has none.
FrameReports read_frame_reports(const RunFolder& folder);

}  // namespace cloth::pipeline
