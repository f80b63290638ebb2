#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "pipeline/scene_file/picture_schema.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string run, out;
    int from = -1;
    cli::KeyFlags keys;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"run", "RUN", "Folder of the run to go on from", true}, values.run);
    flags.integer({"--from", "FRAME", "The last frame that both have in common", true}, values.from, 0,
                  pipeline::most_frames - 1);
    flags.text({"--out", "DIR", "Folder of the branch", true}, values.out);
    values.keys.add_frames(flags, "N", "Number of frames, the common ones too (default: as the run)");
    values.keys.add_size(flags);
    values.keys.add_fps(flags);
    values.keys.add_set(flags);
    values.work.add(flags);
    values.keys.add_annotation(flags);
}

cli::ExitCode work(const Values& values) {
    const pipeline::SceneFile file = values.keys.load_run(values.run);
    const cli::Watch watch(values.work, true, cli::OnSignal::finish);
    cli::conclude(pipeline::resume_run(values.run, values.from, file, values.out, watch.options()),
                  values.out, values.work);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb resume() {
    return cli::verb("resume", "Go on from a frame of a run with other keys, in a folder of its own", add,
                     work);
}

}  // namespace cloth::verbs
