#include <fmt/format.h>
#include <unistd.h>

#include <cstdio>
#include <exception>
#include <nlohmann/json.hpp>

#include "apps/cli/command_line.h"
#include "apps/cli/json_out.h"
#include "apps/verbs/verbs.h"
#include "base/memory.h"
#include "base/text.h"
#include "pipeline/run/garbage.h"
#include "pipeline/run/run_folder.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string folder = "out";
    bool yes = false, json = false;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"folder", "DIR", "A run, or a folder of runs (default: out)"}, values.folder);
    flags.yes("--yes", values.yes, "Remove without asking");
    flags.yes("--json", values.json, "The list as JSON; nothing is asked, and removed with --yes alone");
}

bool agreed() {
    if (::isatty(STDIN_FILENO) == 0) return false;
    fmt::print("Remove them? [y/N] ");
    std::fflush(stdout);
    const int answer = std::getchar();
    return answer == 'y' || answer == 'Y';
}

cli::ExitCode work(const Values& values) {
    const auto runs = pipeline::runs_below(values.folder);
    if (runs.empty()) throw pipeline::Error(cli::ExitCode::other, values.folder + ": there is no run in it");
    std::vector<pipeline::RunFolder> held;  // until the end: what was listed is what is removed
    std::vector<std::pair<std::size_t, pipeline::Garbage>> all;
    double bytes = 0;
    for (const auto& run : runs) {
        try {
            held.push_back(pipeline::RunFolder::create(run));
            for (auto& each : pipeline::garbage_of(run)) {
                bytes += static_cast<double>(each.bytes);
                if (!values.json)
                    fmt::print("{}  {}  {}\n", one_line(each.file.string()),
                               memory_text(static_cast<double>(each.bytes)), each.why);
                all.emplace_back(held.size() - 1, std::move(each));
            }
        } catch (const std::exception& e) {
            fmt::print(stderr, "render_cloth: note: skipped: {}\n", one_line(e.what()));
        }
    }
    const std::string what = fmt::format("{} in {} ({})", plural(std::ssize(all), "file"),
                                         plural(std::ssize(runs), "run"), memory_text(bytes));
    if (values.json) {
        nlohmann::ordered_json files = nlohmann::ordered_json::array();
        for (const auto& [run, each] : all) {
            files.push_back({{"file", each.file.string()}, {"bytes", each.bytes}, {"why", each.why}});
            if (values.yes) held[run].remove(each.file);
        }
        cli::print_json({{"runs", runs.size()}, {"removed", values.yes}, {"files", std::move(files)}});
    } else if (all.empty()) {
        fmt::print("nothing that no run needs in {}\n", plural(std::ssize(runs), "run"));
    } else if (values.yes || agreed()) {
        for (const auto& [run, each] : all) held[run].remove(each.file);
        fmt::print("removed {}\n", what);
    } else {
        fmt::print("{} that no run needs; --yes removes them\n", what);
    }
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb gc() {
    return cli::verb("gc", "List and remove what no kept run needs", add, work);
}

}  // namespace cloth::verbs
