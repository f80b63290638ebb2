#include "pipeline/run/run_page.h"

#include <fmt/format.h>

#include <system_error>

#include "pipeline/formats/file_io.h"
#include "pipeline/page/page.h"
#include "pipeline/run/shown_run.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

using Json = nlohmann::ordered_json;

/// Good, broken or unfinished, as the certificate says.
Json verdict(const ShownRun& run) {
    const std::string word = run.certificate.value("verdict", std::string());
    const bool expects = !run.certificate.value("expect", Json::array()).empty();
    if (word == "good")
        return {{"text", expects ? "complete, all limits hold" : "complete"}, {"tone", "good"}};
    if (word == "broken") return {{"text", "a limit is broken"}, {"tone", "bad"}};
    return {{"text", word.empty() ? "not certified" : word}, {"tone", "warn"}};
}

Json page_of_run(const fs::path& out, const RunFolder& folder, const RunOptions& options) {
    const ShownRun run = shown_run(
        out, {.label = fs::absolute(out).lexically_normal().filename().string(), .page = folder.page()},
        options);
    Json data;
    data["mark"] = own_mark;
    data["title"] = run.file.name;
    data["verdict"] = verdict(run);
    data["lines"] = Json::array();
    if (!run.file.description.empty()) data["lines"].push_back(run.file.description);
    data["faults"] = Json::array();
    add_fault(data, run, "");
    std::error_code ignored;
    if (fs::exists(folder.overlap(), ignored))
        data["picture"] = {{"url", picture_url(read_file(folder.overlap()))},
                           {"text", "What overlaps, in red."}};
    data["measures"] = frame_measures();
    data["facts"] = facts_of({&run});
    data["notes"] = run.report.value("notes", Json::array());
    data["runs"] = Json::array({run.run});
    return data;
}

}  // namespace

void write_run_page(const fs::path& out, const RunOptions& options, const Json* golden) {
    const RunFolder folder = RunFolder::open(out);
    Json data = page_of_run(out, folder, options);
    if (golden != nullptr) data["golden"] = *golden;
    write_if_changed(folder.page(), page_text(data));
}

void leave_run_page(const fs::path& out, const RunOptions& options) {
    if (!options.page) return;
    try {
        write_run_page(out, options);
    } catch (const std::exception& e) {
        if (options.tell) options.tell(fmt::format("no report.html: {}", e.what()));
    }
}

}  // namespace cloth::pipeline
