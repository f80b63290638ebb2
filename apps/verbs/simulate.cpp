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
}

cli::ExitCode work(const Values& values) {
    const pipeline::SceneFile file = values.scene.load();
    const std::filesystem::path out = values.scene.folder(file);
    const auto summary = pipeline::run_scene(file, out, cli::Watch(values.work, false).options());
    cli::conclude(summary, out);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb simulate() {
    return cli::verb("simulate", "States only; the same flags", add, work);
}

}  // namespace cloth::verbs
