#include "pipeline/run/sheet.h"

#include <fmt/format.h>

#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/formats/state_store.h"

namespace cloth::verbs {
namespace {

namespace fs = std::filesystem;

struct Values {
    cli::SceneFlags scene;
    cli::WorkFlags work;
    pipeline::SheetOptions sheet;
    std::string file;
};

void add(cli::Flags& flags, Values& values) {
    values.scene.add(flags);
    values.work.add(flags);
    flags.integer({"--count", "N", "Number of pictures (default: 12)"}, values.sheet.count, 1, 1000);
    flags.integer({"--columns", "N", "Pictures a row"}, values.sheet.columns, 1, 1000);
    flags.text({"--file", "F", "The PNG (default: sheet.png in the run's folder)"}, values.file);
    values.scene.keys.add_annotation(flags);
}

cli::ExitCode work(const Values& values) {
    const cli::KeyFlags& keys = values.scene.keys;
    const bool kept = values.scene.scene.empty();
    if (kept && values.scene.out.empty())
        cli::refuse("--out is missing: give the folder of a run, or a scene to simulate with --scene");
    pipeline::SheetOptions sheet = values.sheet;
    sheet.own_size = keys.has_size();
    if (kept) sheet.span = keys.span();
    const fs::path out = kept ? fs::path(values.scene.out) : cli::run_scene(values.scene, values.work, false);
    const fs::path png = values.file.empty() ? pipeline::RunFolder::open(out).sheet() : fs::path(values.file);
    const auto overrides = kept ? keys.redraw_overrides() : pipeline::Overrides();
    const auto made = pipeline::write_sheet(out, png, sheet, overrides,
                                            cli::Watch(values.work, true, cli::OnSignal::end).options());
    fmt::print("{} in {}x{} pixels: {}\n", plural(made.pictures, "picture"), made.width, made.height,
               made.file.string());
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb sheet() {
    return cli::verb("sheet", "Pictures of a run, or of a scene, in one PNG", add, work);
}

}  // namespace cloth::verbs
