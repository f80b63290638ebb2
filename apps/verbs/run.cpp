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
    values.scene.keys.add_annotation(flags);
}

cli::ExitCode work(const Values& values) {
    const pipeline::SceneFile file = values.scene.load();
    const std::filesystem::path out = values.scene.folder(file);
    const auto summary = pipeline::run_scene(file, out, cli::Watch(values.work, true).options());
    cli::conclude(summary, out);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb run() {
    return cli::verb("run", "Simulate, draw and encode (the default)", add, work);
}

}  // namespace cloth::verbs
