#include "validation/validation.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "base/text.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/run/run_folder.h"
#include "sim/scene/fabrics.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string check, plots = "out/validation";
    double gamma = 0;  // 0 and the empty name: not given
    int resolution = 0;
    std::string fabric;
    bool markdown = false, quiet = false, json = false;
};

void add(cli::Flags& flags, Values& values) {
    std::vector<std::string> checks, fabrics;
    for (const validation::Check& check : validation::checks()) checks.push_back(check.name);
    for (const NamedFabric& named : named_fabrics()) fabrics.push_back(named.fabric.name);
    flags.choice({"check", "CHECK", "One check; all of them without"}, values.check, checks);
    flags.number({"--gamma", "G", "cantilever: this load alone"}, values.gamma, 1e-3, 1e5);
    flags.integer({"--resolution", "N", "Elements along the longest side"}, values.resolution, 4, 2000);
    flags.choice({"--fabric", "NAME", "drape: this fabric alone"}, values.fabric, fabrics);
    flags.text({"--plots", "DIR", "Folder for plots (default: out/validation)"}, values.plots);
    flags.yes("--markdown", values.markdown, "The table in Markdown");
    flags.yes("--json", values.json, "The table as JSON");
    flags.yes("--quiet", values.quiet, "No progress");
}

/// One check or all.
std::vector<validation::Check> wanted_checks(const Values& values) {
    std::vector<validation::Check> wanted;
    for (const validation::Check& check : validation::checks())
        if (values.check.empty() || values.check == check.name) wanted.push_back(check);
    return wanted;
}

/// Throws Error(usage) where one is given that the check does not have.
validation::Parameters wanted_parameters(const Values& values, const validation::Check& check) {
    const auto require = [&](const std::string& parameter) {
        if (values.check.empty())
            cli::refuse(
                fmt::format("--{0}: give the check that it belongs to, as in render_cloth validate "
                            "CHECK --{0} …",
                            parameter));
        if (std::find(check.parameters.begin(), check.parameters.end(), parameter) == check.parameters.end())
            cli::refuse(fmt::format("validate {}: has no --{}", check.name, parameter));
    };
    validation::Parameters parameters;
    if (values.gamma != 0) require("gamma"), parameters.gamma = values.gamma;
    if (values.resolution != 0) require("resolution"), parameters.resolution = values.resolution;
    if (!values.fabric.empty()) require("fabric"), parameters.fabric = values.fabric;
    return parameters;
}

validation::Outcome outcome_of(const validation::Check& check, const validation::Parameters& parameters,
                               bool quiet) {
    const bool told = !quiet && isatty(STDERR_FILENO);
    if (told) std::fputs(fmt::format("\r{} …\033[K", check.name).c_str(), stderr);
    validation::Outcome outcome;
    try {
        outcome = check.run(parameters);
    } catch (const std::exception& e) {
        throw pipeline::Error(cli::ExitCode::not_converged,
                              fmt::format("validate {}: {}", check.name, e.what()));
    }
    if (told) std::fputs("\r\033[K", stderr);
    return outcome;
}

nlohmann::ordered_json finding_json(const validation::Finding& f) {
    return {{"check", f.check},       {"quantity", f.quantity},   {"measured", f.measured},
            {"expected", f.expected}, {"tolerance", f.tolerance}, {"unit", f.unit},
            {"good", f.good()},       {"source", f.source}};
}

cli::ExitCode work(const Values& values) {
    if (values.json && values.markdown) cli::refuse("--json, --markdown: give one of the two");
    const std::vector<validation::Check> wanted = wanted_checks(values);
    const validation::Parameters parameters = wanted_parameters(values, wanted.front());
    const std::filesystem::path plots = values.plots;
    pipeline::require_own_folder(plots, "--plots");
    int bad = 0, plots_written = 0;
    nlohmann::ordered_json all = nlohmann::ordered_json::array();
    if (!values.json) fmt::print("{}", validation::table_head(values.markdown));
    for (const validation::Check& check : wanted) {
        const validation::Outcome outcome = outcome_of(check, parameters, values.quiet);
        for (const validation::Finding& finding : outcome.findings) {
            all.push_back(finding_json(finding));
            if (!values.json) fmt::print("{}", validation::table_line(finding, values.markdown));
            bad += !finding.good();
        }
        std::fflush(stdout);
        for (const Plot& plot : outcome.plots) {
            std::filesystem::create_directories(plots);
            pipeline::write_file(plots / (plot.name + ".svg"),
                                 std::string(pipeline::own_mark) + "\n" + to_svg(plot));
            ++plots_written;
        }
    }
    if (values.json) cli::print_json(all);
    if (plots_written > 0 && !values.markdown && !values.json) fmt::print("plots: {}\n", plots.string());
    if (bad > 0)
        throw pipeline::Error(cli::ExitCode::other,
                              fmt::format("validate: {} outside of tolerance", plural(bad, "finding")));
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb validate() {
    return cli::verb("validate", "Check the physics against theory: a table and plots", add, work);
}

}  // namespace cloth::verbs
