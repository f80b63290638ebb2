#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/golden_flags.h"
#include "apps/cli/json_out.h"
#include "apps/verbs/verbs.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/golden/golden.h"
#include "pipeline/golden/golden_verdict.h"

namespace cloth::verbs {
namespace {

struct Values : cli::GoldenFlags {
    bool json = false;
    std::string junit;
};

void add(cli::Flags& flags, Values& values) {
    values.add(flags);
    values.scene.keys.add_set(flags);
    flags.yes("--json", values.json, "The verdict as JSON instead of a table");
    flags.text({"--junit", "FILE", "The verdict as JUnit's XML too, a test case for each state and picture"},
               values.junit);
}

cli::ExitCode work(const Values& values) {
    const pipeline::SceneFile file = values.scene.load();
    const pipeline::GoldenResult result = pipeline::compare_golden(
        file, values.folder(file), values.scene.folder(file), values.work.threads, values.work.gl_library());
    if (!values.junit.empty()) pipeline::write_file(values.junit, golden_junit(result));
    if (values.json) {
        cli::print_json(golden_json(result));
    } else {
        fmt::print("{}report: {}\n", golden_table(result), result.report.string());
    }
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
