#include "pipeline/run/audit.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string out;
    int seed = 1;
    bool json = false;
    pipeline::AuditOptions audit;
    cli::WorkFlags work;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"out", "OUT", "Folder of the run", true}, values.out);
    flags.integer({"--windows", "N", "Parts to simulate again (default: 3)"}, values.audit.windows, 1,
                  100'000);
    flags.integer({"--length", "N", "Frames of each (default: 5)"}, values.audit.length, 1, 100'000);
    flags.integer({"--seed", "N", "Of where they lie (default: 1)"}, values.seed, 0, 2'000'000'000);
    flags.yes("--json", values.json, "What was found as JSON");
    values.work.add_threads(flags);
}

void print_as_json(const std::string& out, const pipeline::AuditResult& result) {
    nlohmann::ordered_json json = {{"out", out},
                                   {"good", result.findings.empty()},
                                   {"states_read", result.read},
                                   {"states_simulated_again", result.simulated},
                                   {"windows", nlohmann::ordered_json::array()},
                                   {"findings", nlohmann::ordered_json::array()}};
    for (const pipeline::FrameSpan& window : result.windows)
        json["windows"].push_back({{"first", window.first}, {"last", window.last - 1}});
    for (const pipeline::AuditFinding& bad : result.findings)
        json["findings"].push_back({{"frame", bad.frame}, {"fault", bad.fault}, {"host", bad.host}});
    cli::print_json(json);
}

void print_as_text(const pipeline::AuditResult& result) {
    for (const pipeline::FrameSpan& window : result.windows)
        fmt::print("frames {} to {} simulated again\n", window.first, window.last - 1);
    for (const pipeline::AuditFinding& bad : result.findings)
        fmt::print("frame {} {}{}\n", bad.frame, bad.fault,
                   bad.host.empty() ? std::string() : ", made by the host " + bad.host);
}

cli::ExitCode work(const Values& values) {
    pipeline::AuditOptions audit = values.audit;
    audit.seed = static_cast<std::uint32_t>(values.seed);
    const cli::Watch watch(values.work, false, cli::OnSignal::finish);
    const pipeline::AuditResult result = pipeline::audit_run(values.out, audit, watch.options());
    if (values.json) {
        print_as_json(values.out, result);
    } else {
        print_as_text(result);
    }
    if (!result.findings.empty())
        throw pipeline::Error(
            cli::ExitCode::broken_promise,
            fmt::format("{}: {} of {} states are bad, the first is that of frame {}", values.out,
                        result.findings.size(), result.read, result.findings.front().frame));
    if (!values.json)
        fmt::print("{}: {} states are whole, {} of them simulated again to the same bits\n", values.out,
                   result.read, result.simulated);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb audit() {
    return cli::verb("audit", "Simulate parts of a kept run again and compare the bits", add, work);
}

}  // namespace cloth::verbs
