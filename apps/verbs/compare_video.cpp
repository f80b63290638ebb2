#include <fmt/format.h>

#include <array>

#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/run/sheet.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::vector<std::string> runs;
    std::string file, labels;
    cli::KeyFlags keys;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.words({"runs", "A B", "Folders of two runs", true}, values.runs, 2);
    flags.text({"--file", "F", "The MP4", true}, values.file);
    flags.text({"--labels", "A,B", "Texts at the top (default: the folders)"}, values.labels);
    values.keys.add_size(flags);
    values.keys.add_fps(flags);
    values.keys.add_set(flags);
    values.work.add(flags);
    values.keys.add_annotation(flags);
}

cli::ExitCode work(const Values& values) {
    if (std::filesystem::path(values.file).extension() != ".mp4")
        cli::refuse(fmt::format("--file {}: give a name.mp4", values.file));
    const auto labels = values.labels.empty() ? values.runs : split(values.labels, ',');
    if (labels.size() != 2)
        cli::refuse(fmt::format("--labels {}: give two texts, as in before,after", values.labels));
    const auto made = pipeline::write_comparison({values.runs[0], values.runs[1]}, values.file,
                                                 {labels[0], labels[1]}, values.keys.redraw_overrides(),
                                                 cli::Watch(values.work, true, cli::OnSignal::end).options());
    fmt::print("{} of {}x{} at {:g} frames/s: {}\n", plural(made.frames, "frame"), made.width, made.height,
               made.playback_rate, values.file);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb compare_video() {
    return cli::verb("compare-video", "Two runs beside each other in one movie", add, work);
}

}  // namespace cloth::verbs
