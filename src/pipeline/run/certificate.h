#pragma once
// certificate.json: what a run is worth. Per frame its measures, for the run its scene, build and hosts, and
// whether what the scene expects of it holds.

#include <optional>
#include <string>
#include <vector>

#include "pipeline/run/report.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

/// One limit of the scene's [expect], and what the run made of it.
struct Promise {
    std::string key, unit;
    double limit = 0;
    std::optional<double> worst;  ///< of all frames; none: never measured
    std::int64_t worst_frame = 0;
    std::optional<std::int64_t> first_broken;  ///< frame
    double broken_by = 0;                      ///< its value there
};

/// Every limit that the scene sets, over these frames.
std::vector<Promise> promises(const ExpectDesc& expect, const std::vector<FrameRecord>& records);

/// "expect.max_stretch = 1.02 is broken: frame 3 has 1.07, frame 9 the worst, 1.2"; empty: all hold.
std::string broken_promises(const std::vector<Promise>& promises);

/// `key` of the last state stands for the scene; `outcome` as in write_report().
void write_certificate(const RunFolder& folder, const SceneFile& file, const RunSummary& summary,
                       const std::string& key, const std::string& outcome);

}  // namespace cloth::pipeline
