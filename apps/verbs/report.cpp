#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/golden/golden.h"
#include "pipeline/run/run_folder.h"
#include "pipeline/run/run_page.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string run, other, file, golden;
    bool json = false;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"run", "RUN", "Folder of a run", true}, values.run);
    flags.text({"other", "OTHER", "Another, to lay beside it"}, values.other);
    flags.text({"--file", "F", "The page of two runs (default: report.html here)"}, values.file);
    flags.text({"--golden", "DIR", "Folder with a folder of goldens for each scene: the run against its own"},
               values.golden);
    flags.yes("--json", values.json, "What two runs differ by as JSON");
    values.work.add_threads(flags);
    values.work.add_gl(flags);
}

cli::ExitCode compare_two(const Values& values, const pipeline::RunOptions& options) {
    const std::string file = values.file.empty() ? "report.html" : values.file;
    const pipeline::RunDifference d =
        pipeline::write_comparison_page(values.run, values.other, file, options);
    const std::string runs = fmt::format("{} and {}", values.run, values.other);
    if (values.json) {
        nlohmann::ordered_json json = {{"same", d.same()}, {"common_frames", d.common}};
        json["first_different_frame"] = d.first ? nlohmann::ordered_json(d.first->frame) : nullptr;
        json["distance_there_m"] = d.first ? nlohmann::ordered_json(d.first->largest) : nullptr;
        json["largest_distance_m"] = d.farthest.largest;
        json["largest_distance_frame"] = d.farthest.frame;
        json["largest_distance_of"] = d.farthest.vertex;
        json["rms_distance_there_m"] = d.farthest.rms;
        json["incomparable"] = d.incomparable;
        json["report"] = file;
        cli::print_json(json);
    } else if (d.same()) {
        fmt::print("{}: the same in {}: {}\n", runs, plural(d.common, "frame"), file);
    } else if (!d.first) {
        fmt::print("{}: no states to compare, {}: {}\n", runs,
                   d.incomparable.empty() ? "no frame is in both" : d.incomparable, file);
    } else {
        fmt::print("{}: part in frame {} by {:.3g} m, farthest in frame {}: {:.3g} m, rms {:.3g} m: {}\n",
                   runs, d.first->frame, d.first->largest, d.farthest.frame, d.farthest.largest,
                   d.farthest.rms, file);
    }
    return cli::ExitCode::good;
}

cli::ExitCode compare_with_goldens(const Values& values, const pipeline::RunOptions& options) {
    const pipeline::GoldenResult result = pipeline::compare_kept_run(values.run, values.golden, options);
    fmt::print("{}report: {}\n", golden_table(result), result.report.string());
    if (!result.passed)
        throw pipeline::Error(
            cli::ExitCode::golden_mismatch,
            fmt::format("{} differs from its goldens, see {}", values.run, result.report.string()));
    return cli::ExitCode::good;
}

cli::ExitCode work(const Values& values) {
    const cli::Watch watch(values.work, false, cli::OnSignal::finish);
    if (!values.other.empty()) {
        if (!values.golden.empty()) cli::refuse("--golden: belongs to the page of one run");
        return compare_two(values, watch.options());
    }
    for (const auto& [given, name] :
         {std::pair(!values.file.empty(), "--file"), std::pair(values.json, "--json")})
        if (given)
            cli::refuse(
                fmt::format("{}: belongs to two runs; that of one is report.html in its folder", name));
    if (!values.golden.empty()) return compare_with_goldens(values, watch.options());
    pipeline::write_run_page(values.run, watch.options());
    fmt::print("{}\n", pipeline::RunFolder::open(values.run).page().string());
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb report() {
    return cli::verb("report", "The page of a run anew, or one of two runs beside each other", add, work);
}

}  // namespace cloth::verbs
