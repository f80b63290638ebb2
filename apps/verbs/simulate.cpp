#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"

namespace cloth::verbs {
namespace {

struct Values {
    cli::SceneFlags scene;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    values.scene.add(flags);
    values.work.add(flags);
    values.work.add_reuse(flags);
}

cli::ExitCode work(const Values& values) {
    cli::run_scene(values.scene, values.work, false);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb simulate() {
    return cli::verb("simulate", "States only; the same flags", add, work);
}

}  // namespace cloth::verbs
