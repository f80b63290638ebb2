#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/run_page.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string run, other, file;
    bool json = false;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"run", "RUN", "Folder of a run", true}, values.run);
    flags.text({"other", "OTHER", "Another, to lay beside it"}, values.other);
    flags.text({"--file", "F", "The page of two runs (default: report.html here)"}, values.file);
    flags.yes("--json", values.json, "What two runs differ by as JSON");
    values.work.add_threads(flags);
}

cli::ExitCode compare_two(const Values& values, const pipeline::RunOptions& options) {
    const std::string file = values.file.empty() ? "report.html" : values.file;
    const pipeline::RunDifference d =
        pipeline::write_comparison_page(values.run, values.other, file, options);
    const bool same = d.comparable && !d.first && d.common > 0;
    if (values.json) {
        cli::print_json({{"same", same},
                         {"common_frames", d.common},
                         {"first_different_frame", d.first ? nlohmann::ordered_json(*d.first) : nullptr},
                         {"largest_distance_m", d.largest},
                         {"largest_distance_frame", d.largest_frame},
                         {"report", file}});
    } else if (same) {
        fmt::print("{} and {}: the same in {} frames: {}\n", values.run, values.other, d.common, file);
    } else if (!d.comparable || d.common == 0) {
        fmt::print("{} and {}: no states to compare, {}: {}\n", values.run, values.other,
                   d.comparable ? "no frame is in both" : "their numbers of vertices differ", file);
    } else {
        fmt::print("{} and {}: part in frame {}, farthest in frame {}, {:.3g} m: {}\n", values.run,
                   values.other, *d.first, d.largest_frame, d.largest, file);
    }
    return cli::ExitCode::good;
}

cli::ExitCode work(const Values& values) {
    const cli::Watch watch(values.work, false, cli::OnSignal::finish);
    if (!values.other.empty()) return compare_two(values, watch.options());
    for (const auto& [given, name] :
         {std::pair(!values.file.empty(), "--file"), std::pair(values.json, "--json")})
        if (given)
            cli::refuse(
                fmt::format("{}: belongs to two runs; that of one is report.html in its folder", name));
    pipeline::write_run_page(values.run, watch.options());
    fmt::print("{}\n", pipeline::RunFolder::open(values.run).page().string());
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb report() {
    return cli::verb("report", "The page of a run anew, or one of two runs beside each other", add, work);
}

}  // namespace cloth::verbs
