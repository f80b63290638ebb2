#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string out;
    cli::KeyFlags keys;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"--out", "DIR", "Folder of the run", true}, values.out);
    values.keys.add_fps(flags);
    values.keys.add_set(flags);
    values.work.add(flags);
}

cli::ExitCode work(const Values& values) {
    const auto summary = pipeline::encode_run(values.out, values.keys.redraw_overrides(),
                                              cli::Watch(values.work, true, cli::OnSignal::finish).options());
    cli::conclude(summary, values.out, values.work);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb encode() {
    return cli::verb("encode", "The movie from the kept pictures of a run", add, work);
}

}  // namespace cloth::verbs
