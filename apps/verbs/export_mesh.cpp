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
    std::string out, format, file;
    int frame = -1;  ///< -1: not given
    cli::KeyFlags keys;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"--out", "DIR", "Folder of the run", true}, values.out);
    flags.integer({"--frame", "K", "The frame, for one mesh"}, values.frame, 0,
                  std::numeric_limits<int>::max());
    values.keys.add_frames(flags, "A:B", "The frames A to B-1, for a sequence");
    flags.choice({"--format", "NAME", "As list formats has it (default: by the extension of --file)"},
                 values.format, pipeline::export_format_names());
    flags.text({"--file", "F", "Mesh file; sheet.obj of a sequence is sheet_000000.obj …", true},
               values.file);
    flags.yes("--quiet", values.work.quiet, "No progress");
}

/// One mesh under the name that was given.
void one(const Values& values, const pipeline::ExportFormat& format) {
    pipeline::export_frame(values.out, values.frame, format, values.file);
    fmt::print("frame {} as {}: {}\n", values.frame, format.name, values.file);
}

void sequence(const Values& values, const pipeline::ExportFormat& format, const pipeline::FrameSpan& span) {
    pipeline::export_frames(values.out, span, format, values.file,
                            cli::Watch(values.work, false, cli::OnSignal::end).options());
    std::string made = values.file;
    if (format.files == pipeline::SequenceFiles::one_per_frame)
        made = fmt::format("{} to {}", pipeline::numbered_file(made, span.first).string(),
                           pipeline::numbered_file(made, span.last - 1).string());
    fmt::print("{} as {}: {}\n", plural(span.last - span.first, "frame"), format.name, made);
}

cli::ExitCode work(const Values& values) {
    const auto span = values.keys.span();
    if (span.has_value() == (values.frame >= 0))
        cli::refuse("export: give either --frame K, for one mesh, or --frames A:B, for a sequence");
    const pipeline::ExportFormat& format = pipeline::export_format(values.format, values.file);
    if (span) {
        sequence(values, format, *span);
    } else {
        one(values, format);
    }
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb export_mesh() {
    return cli::verb("export", "Kept states as mesh files: one frame, or a sequence", add, work);
}

}  // namespace cloth::verbs
