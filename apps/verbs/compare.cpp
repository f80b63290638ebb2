#include <fmt/format.h>

#include "apps/cli/golden_flags.h"
#include "apps/verbs/verbs.h"
#include "pipeline/golden/golden.h"

namespace cloth::verbs {
namespace {

void add(cli::Flags& flags, cli::GoldenFlags& values) {
    values.add(flags);
    values.scene.keys.add_set(flags);
}

cli::ExitCode work(const cli::GoldenFlags& values) {
    const pipeline::SceneFile file = values.scene.load();
    const pipeline::GoldenResult result = pipeline::compare_golden(
        file, values.folder(file), values.scene.folder(file), values.work.threads, values.work.gl_library());
    fmt::print("{}report: {}\n", golden_table(result), result.report.string());
    if (!result.passed)
        throw pipeline::Error(
            cli::ExitCode::golden_mismatch,
            fmt::format("{} differs from its goldens, see {}; if the change is wanted: render_cloth bless {}",
                        file.name, result.report.string(), values.scene.scene));
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb compare() {
    return cli::verb("compare", "Run a scene and compare with its golden frames", add, work);
}

}  // namespace cloth::verbs
