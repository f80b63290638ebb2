#pragma once
// What of a kept run is still good for what is asked for, what is not, and why.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/run/fingerprints.h"
#include "pipeline/run/ledger.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/model.h"

namespace cloth::pipeline {

struct Wanted {
    const SceneFile& file;
    const Model& model;
    std::int64_t frames = 0;
    bool pictures = true, movie = true;
    std::string renderer;  ///< pictures of another are drawn anew; empty: of any
    Trunk trunk;           ///< of a branch
    double playback_rate = 0;
};

struct RunPlan {
    std::int64_t frames = 0;
    std::vector<std::string> states, pictures;  ///< keys, of all frames that are wanted or kept
    std::string movie_key;
    LedgerEntries kept;                           ///< of files that are whole and what is wanted
    std::vector<std::filesystem::path> outdated;  ///< files of the run that are not, to be removed
    std::vector<std::string> warnings;  ///< a line each: what is damaged, what finished things go and why
    std::vector<std::string> parts;  ///< a line each for states, pictures and movie: what is reused, why not

    bool has_state(std::int64_t frame) const { return kept.states.contains(frame); }
    bool has_picture(std::int64_t frame) const { return kept.pictures.contains(frame); }
    bool has_movie = false;
    std::int64_t kept_states() const;    ///< among the frames wanted
    std::int64_t kept_pictures() const;  ///< the same
};

/// Reads every kept file of the run, and changes nothing. Throws Error(other) where a newer program made it.
RunPlan plan_run(const RunFolder& folder, const Wanted& wanted);

/// What stands in manifests for the program that makes states.
std::string maker();

}  // namespace cloth::pipeline
