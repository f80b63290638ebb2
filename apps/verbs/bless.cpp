#include <fmt/format.h>

#include "apps/cli/golden_flags.h"
#include "apps/verbs/verbs.h"
#include "pipeline/golden/golden.h"

namespace cloth::verbs {
namespace {

void add(cli::Flags& flags, cli::GoldenFlags& values) {
    values.add(flags);
}

cli::ExitCode work(const cli::GoldenFlags& values) {
    const pipeline::SceneFile file = values.scene.load();
    const std::filesystem::path golden = values.folder(file);
    const pipeline::GoldenResult result = pipeline::bless_golden(
        file, golden, values.scene.folder(file), values.work.threads, values.work.gl_library());
    if (result.rows.empty())
        fmt::print("{}: nothing to compare with\n", file.name);
    else
        fmt::print("old against new:\n{}", golden_table(result));
    fmt::print("{}: goldens written to {}\n", file.name, golden.string());
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb bless() {
    return cli::verb("bless", "Run a scene and renew its golden frames", add, work);
}

}  // namespace cloth::verbs
