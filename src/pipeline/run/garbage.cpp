#include "pipeline/run/garbage.h"

#include <algorithm>
#include <set>
#include <system_error>

#include "pipeline/run/draw.h"
#include "pipeline/run/kept_run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

std::vector<fs::path> runs_below(const fs::path& folder) {
    std::vector<fs::path> runs;
    std::error_code failure;
    if (RunFolder::look(folder).has_manifest()) runs.push_back(folder);
    for (fs::recursive_directory_iterator
             entry(folder, fs::directory_options::skip_permission_denied, failure),
         end;
         !failure && entry != end; entry.increment(failure)) {
        if (!entry->is_directory(failure) || entry->is_symlink(failure)) continue;
        if (RunFolder::look(entry->path()).has_manifest()) runs.push_back(entry->path());
    }
    std::sort(runs.begin(), runs.end());
    return runs;
}

std::vector<Garbage> garbage_of(const fs::path& out) {
    const KeptRun run = open_run(out);
    const Manifest manifest = run.folder.read_manifest();
    Wanted wanted{run.file, run.model, run.frames};
    wanted.trunk.keys = manifest.trunk;
    wanted.playback_rate = playback_rate(run.file);
    const RunPlan plan = plan_run(run.folder, wanted);
    std::vector<Garbage> garbage;
    std::set<fs::path> listed;
    const auto list = [&](const fs::path& file, const char* why) {
        std::error_code failure;
        const auto bytes = fs::file_size(file, failure);
        if (listed.insert(file).second) garbage.push_back({file, failure ? 0 : bytes, why});
    };
    for (const fs::path& file : plan.outdated) list(file, "damaged, or made from something else");
    for (const std::int64_t frame : run.folder.states_on_disk())
        if (frame >= run.frames) list(run.folder.state(frame), "behind the run's last frame");
    for (const std::int64_t frame : run.folder.images_on_disk())
        if (frame >= run.frames) list(run.folder.image(frame), "behind the run's last frame");
    for (const fs::path& file : run.folder.parts())
        list(file, "left unfinished by a program that was killed");
    return garbage;
}

}  // namespace cloth::pipeline
