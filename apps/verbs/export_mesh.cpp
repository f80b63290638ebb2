#include <fmt/format.h>

#include <limits>

#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/formats/exporters.h"
#include "pipeline/run/run.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string out, format, file, cloth;
    int frame = -1;  ///< -1: not given
    cli::KeyFlags keys;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"--out", "DIR", "Folder of the run", true}, values.out);
    flags.choice({"--format", "NAME", "As list formats has it (default: by the extension of --file)"},
                 values.format, pipeline::export_format_names());
    values.keys.add_frames(flags, "A:B", "The frames A to B-1 (default: all that are kept)");
    flags.integer({"--frame", "K", "One frame alone"}, values.frame, 0, std::numeric_limits<int>::max());
    flags.text({"--cloth", "NAME", "One cloth alone"}, values.cloth);
    flags.text({"--file", "F",
                "What is written; where a format has a file per frame, sheet.obj of a sequence is "
                "sheet_000000.obj …",
                true},
               values.file);
    flags.yes("--quiet", values.work.quiet, "No progress");
}

cli::ExitCode work(const Values& values) {
    pipeline::ExportChoice choice{.frames = values.keys.span(), .cloth = values.cloth};
    if (choice.frames && values.frame >= 0)
        cli::refuse("export: give either --frame K, for one frame, or --frames A:B, for a sequence");
    const bool one = values.frame >= 0;
    if (one) choice.frames = {values.frame, std::int64_t{values.frame} + 1};
    const pipeline::ExportFormat& format = pipeline::export_format(values.format, values.file);
    const auto frames =
        pipeline::export_frames(values.out, choice, format, values.file,
                                one ? pipeline::FrameNames::as_given : pipeline::FrameNames::numbered,
                                cli::Watch(values.work, false, cli::OnSignal::end).options());
    if (one) {
        fmt::print("frame {} as {}: {}\n", values.frame, format.name, values.file);
        return cli::ExitCode::good;
    }
    std::string made = values.file;
    if (format.files == pipeline::SequenceFiles::one_per_frame)
        made = fmt::format("{} to {}", pipeline::numbered_file(made, frames.front()).string(),
                           pipeline::numbered_file(made, frames.back()).string());
    fmt::print("{} as {}: {}\n", plural(static_cast<std::int64_t>(frames.size()), "frame"), format.name,
               made);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb export_mesh() {
    return cli::verb("export", "A kept run in a format of other programs: all of it, a part, or one frame",
                     add, work);
}

}  // namespace cloth::verbs
