#pragma once
// A kept run as pages show it (pipeline/page). Internal to this room.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/page/view_data.h"
#include "pipeline/run/kept_run.h"
#include "pipeline/run/run_options.h"

namespace cloth::pipeline {

/// What a page may hold of movies and of frames in three dimensions, as text [byte]. With its libraries,
/// curves, scenes and goldens it stays below 30 MB: it is to be opened from a mail, too.
inline constexpr std::size_t most_movie = 15'000'000, most_view = 7'000'000;

/// A curve of the page, by its name in frame_json(); in "seconds" where that has a part so called.
struct PageMeasure {
    const char *key, *label, *unit;
    bool log = false;
    const char *worst = "", *worst_label = "";  ///< "most" or "least" is worst; "": neither
    const char* expect = "";                    ///< the limit of [expect] that is drawn in it
    bool aside = false;                         ///< folded away
};
nlohmann::ordered_json measure_json(const PageMeasure& measure);
/// Of the frames of every run.
nlohmann::ordered_json frame_measures();

struct ShownRun {
    nlohmann::ordered_json run;  ///< its part of the page
    nlohmann::ordered_json report, certificate;
    SceneFile file;
    std::vector<std::int64_t> frames;  ///< that are kept
};

struct Showing {
    std::string label;                   ///< of the run
    std::filesystem::path page;          ///< from which a movie that is too large is linked
    std::size_t runs = 1;                ///< that share the page
    std::optional<ViewField> more = {};  ///< what its vertices can be coloured by beside view_fields()
};
/// Throws Error(other) where `out` holds no run or no states, Error(interrupted).
ShownRun shown_run(const std::filesystem::path& out, const Showing& showing, const RunOptions& options);

/// What runs were made from: [name, [text of each run]] …
nlohmann::ordered_json facts_of(const std::vector<const ShownRun*>& runs);

/// Adds the outcome where it is no success: the first thing to be read.
void add_fault(nlohmann::ordered_json& page, const ShownRun& run, const std::string& label);

}  // namespace cloth::pipeline
