#pragma once
// What a run tells of itself, and report.json, which keeps it.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
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
    std::string host;                                   ///< that simulated it
    double simulate = 0, store = 0, draw = 0, png = 0;  ///< time that it took [s]
};

/// Time that each stage was busy [s]; they overlap, so `wall` is less than their sum.
struct StageTimes {
    double simulate = 0, store = 0, draw = 0, png = 0, encode = 0, wall = 0;
};

struct RunSummary {
    std::string scene;
    std::int64_t frames = 0;                        ///< asked for
    std::int64_t states = 0;                        ///< written
    std::int64_t images = 0;                        ///< written
    std::int64_t kept_states = 0, kept_images = 0;  ///< of an earlier run, and still good
    bool kept_movie = false;
    int width = 0, height = 0;  ///< of the pictures [pixel]; 0 without
    double playback_rate = 0;   ///< [1/s]
    bool interrupted = false;
    std::vector<FrameRecord> records;  ///< of all states that are there, kept ones too
    StageTimes times;
    std::string renderer, encoder;  ///< versions; empty where not used
    std::filesystem::path movie;    ///< empty where none was made
};

/// The report of a simulation. `outcome`: "complete", "interrupted", or the line that tells of a failure.
void write_report(const RunFolder& folder, const SceneFile& file, const Model& model,
                  const RunSummary& summary, const std::string& outcome);

/// Redrawing adds to the report of the simulation, under "redrawn".
void amend_report(const RunFolder& folder, const RunSummary& summary);

/// Times in the report.
nlohmann::ordered_json times_json(const StageTimes& times);

/// One frame as report.json, certificate.json and the ledger have it: every counter, its unit in the name.
nlohmann::ordered_json frame_json(const FrameRecord& record);
/// And read again. Throws std::exception where it is none.
FrameRecord frame_record(const nlohmann::ordered_json& json);

/// What the ledger tells of the frames; nothing where there is none that can be read.
FrameReports read_frame_reports(const RunFolder& folder);

}  // namespace cloth::pipeline
