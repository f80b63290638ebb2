#include "pipeline/run/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <system_error>

#include "base/text.h"
#include "pipeline/formats/build_info.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/fingerprint.h"
#include "pipeline/formats/state_store.h"
#include "pipeline/run/kept_run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

constexpr const char* damaged = "damaged or cut short";
constexpr const char* unmade = "not made yet";
constexpr const char* missing = "gone";
constexpr const char* otherwise = "drawn with other keys since";
constexpr const char* unrecorded = "no record of how it was made";

/// What has changed since the run in the folder was made.
struct Changes {
    std::string physics, look;  ///< empty: nothing that is known
};

std::string named(const std::vector<std::string>& keys) {
    constexpr std::size_t most = 3;
    if (keys.empty()) return {};
    const std::vector<std::string> first(
        keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(std::min(keys.size(), most)));
    return join(first) + (keys.size() > most ? fmt::format(" and {} more", keys.size() - most) : "") +
           " changed";
}

Changes changes(const RunFolder& folder, const Manifest& manifest, const Wanted& wanted) {
    if (manifest.build != maker()) return {"made by another build", "made by another build"};
    Changes result;
    try {
        const SceneFile kept = load_run_scene(folder.root());
        SceneFile a = physics_of(kept), b = physics_of(wanted.file);
        a.scene.events = kept.scene.events;
        b.scene.events = wanted.file.scene.events;
        result.physics = named(differences(a, b));
        result.look = named(differences(look_of(kept), look_of(wanted.file)));
    } catch (const std::exception&) {
        result.physics = result.look = "its scene.toml cannot be read";
    }
    if (manifest.trunk != wanted.trunk.keys && result.physics.empty())
        result.physics = wanted.trunk.empty() ? "it was a branch of another run" : "it branches elsewhere";
    if (result.look.empty() && manifest.frames != wanted.frames)
        result.look = fmt::format("{} frames instead of {}", wanted.frames, manifest.frames);
    return result;
}

using Reasons = std::map<std::string, std::int64_t>;  ///< things for each

std::string part_line(const char* part, std::int64_t kept, const char* to_do, const Reasons& reasons) {
    std::int64_t rest = 0;
    std::string why;
    for (const auto& [reason, count] : reasons) {
        rest += count;
        why += fmt::format("{}{}: {}", why.empty() ? "" : ", ", reason, count);
    }
    return rest == 0 ? fmt::format("{}: {} kept", part, kept)
                     : fmt::format("{}: {} kept, {} to {} ({})", part, kept, rest, to_do, why);
}

}  // namespace

std::string maker() {
    return fmt::format("{}; sources {}", build_fingerprint(), physics_sources());
}

std::int64_t RunPlan::kept_states() const {
    return std::distance(kept.states.begin(), kept.states.lower_bound(frames));
}
std::int64_t RunPlan::kept_pictures() const {
    return std::distance(kept.pictures.begin(), kept.pictures.lower_bound(frames));
}

RunPlan plan_run(const RunFolder& folder, const Wanted& wanted) {
    RunPlan plan;
    plan.frames = wanted.frames;
    const std::vector<std::int64_t> states = folder.states_on_disk(), images = folder.images_on_disk();
    std::int64_t all = wanted.frames;
    for (const auto* frames : {&states, &images})
        if (!frames->empty()) all = std::max(all, frames->back() + 1);
    plan.states = state_keys(wanted.file, wanted.model, all, wanted.trunk);
    plan.pictures = picture_keys(wanted.file, plan.states, wanted.frames);
    plan.movie_key = movie_key(wanted.file, plan.pictures, wanted.frames, wanted.playback_rate);

    Changes changed;
    std::string movie_name, own_movie = folder.movie(wanted.file.name).filename().string();
    if (folder.has_manifest()) {
        const Manifest manifest = folder.read_manifest();
        if (manifest.format > state_format)
            throw Error(
                ExitCode::other,
                fmt::format("{}: made by a newer program: its states are of format {}, this one knows "
                            "{}; use that program, give another folder, or replace it with --fresh",
                            folder.root().string(), manifest.format, state_format));
        movie_name = folder.movie(manifest.scene).filename().string();
        changed = changes(folder, manifest, wanted);
    }
    const LedgerEntries ledger = read_ledger(folder.ledger());
    std::map<std::string, std::map<std::string, std::int64_t>> lost;  // by reason, by kind
    const auto lose = [&](const fs::path& path, const std::string& why, const char* kind) {
        plan.outdated.push_back(path);
        if (why == damaged)
            plan.warnings.push_back(fmt::format("{}: {}; it is made again", path.string(), why));
        else if (path != folder.state(0) || states.size() > 1)  // a start pose alone is no loss
            ++lost[why][kind];
    };
    const auto or_unrecorded = [](const std::string& why) { return why.empty() ? unrecorded : why; };

    // ---- states
    std::map<std::int64_t, std::string> why_state;
    for (const std::int64_t frame : states) {
        const auto entry = ledger.states.find(frame);
        std::string why;
        if (entry == ledger.states.end())
            why = or_unrecorded(changed.physics);
        else if (entry->second.key != plan.states[static_cast<std::size_t>(frame)])
            why = or_unrecorded(changed.physics);
        else if (file_fingerprint(folder.state(frame)) != entry->second.file)
            why = damaged;
        if (why.empty()) {
            plan.kept.states.insert(*entry);
        } else {
            lose(folder.state(frame), why, "state");
            why_state[frame] = why;
        }
    }
    Reasons reasons;
    for (std::int64_t frame = 0; frame < wanted.frames; ++frame) {
        if (plan.has_state(frame)) continue;
        const auto why = why_state.find(frame);
        ++reasons[why != why_state.end() ? why->second : ledger.states.contains(frame) ? missing : unmade];
    }
    plan.parts.push_back(part_line("states", plan.kept_states(), "simulate", reasons));

    // ---- pictures
    reasons.clear();
    std::map<std::int64_t, std::string> why_picture;
    for (const std::int64_t frame : images) {
        const auto entry = ledger.pictures.find(frame);
        std::string why;
        if (entry == ledger.pictures.end())
            why = or_unrecorded(changed.look);
        else if (entry->second.key != plan.pictures[static_cast<std::size_t>(frame)])
            why = why_state.contains(frame) && why_state[frame] != damaged ? why_state[frame]
                  : changed.look.empty() && !changed.physics.empty()
                      ? changed.physics
                      : (changed.look.empty() ? otherwise : changed.look);
        else if (!wanted.renderer.empty() && entry->second.renderer != wanted.renderer)
            why = "drawn by another renderer";
        else if (file_fingerprint(folder.image(frame)) != entry->second.file)
            why = damaged;
        if (why.empty()) {
            plan.kept.pictures.insert(*entry);
        } else {
            lose(folder.image(frame), why, "picture");
            why_picture[frame] = why;
        }
    }
    if (wanted.pictures) {
        for (std::int64_t frame = 0; frame < wanted.frames; ++frame) {
            if (plan.has_picture(frame)) continue;
            const auto why = why_picture.find(frame);
            ++reasons[why != why_picture.end()          ? why->second
                      : ledger.pictures.contains(frame) ? missing
                                                        : unmade];
        }
        plan.parts.push_back(part_line("pictures", plan.kept_pictures(), "draw", reasons));
    }

    // ---- movie
    std::error_code ignored;
    std::string why_movie = unmade;
    for (const std::string& name : {movie_name, own_movie}) {
        if (name.empty() || !fs::exists(folder.root() / name, ignored) || plan.has_movie) continue;
        const auto entry = ledger.movies.find(name);
        const bool ours = name == movie_name;
        if (entry != ledger.movies.end() && name == own_movie && entry->second.key == plan.movie_key) {
            if (file_fingerprint(folder.root() / name) == entry->second.file) {
                plan.has_movie = true;
                plan.kept.movies.insert(*entry);
                break;
            }
            why_movie = damaged;
        } else {
            why_movie = !changed.look.empty()          ? changed.look
                        : !changed.physics.empty()     ? changed.physics
                        : entry == ledger.movies.end() ? unrecorded
                        : !reasons.empty()             ? "its pictures change"
                                                       : "its rate, quality or frames changed";
        }
        if (ours) lose(folder.root() / name, why_movie, "movie");
        if (movie_name == own_movie) break;
    }
    if (wanted.movie)
        plan.parts.push_back(plan.has_movie ? "movie: kept"
                                            : fmt::format("movie: to encode ({})", why_movie));

    for (const auto& [why, kinds] : lost) {
        std::vector<std::string> things;
        for (const char* kind : {"state", "picture"})
            if (const auto found = kinds.find(kind); found != kinds.end())
                things.push_back(plural(found->second, kind));
        if (kinds.contains("movie")) things.emplace_back("the movie");
        plan.warnings.push_back(
            fmt::format("{}: {} in {} replaced", why, join(things), folder.root().string()));
    }
    return plan;
}

}  // namespace cloth::pipeline
