#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/cli/json_out.h"
#include "apps/cli/manual.h"
#include "apps/verbs/verbs.h"
#include "pipeline/formats/exporters.h"
#include "pipeline/scene_file/fabric_list.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/scene/fabrics.h"

namespace cloth::verbs {
namespace {

using Json = nlohmann::ordered_json;

struct Values {
    std::string what = "scenes", name;
    bool sources = false, markdown = false, json = false;
};

void print_scenes(const Values& values) {
    if (values.markdown) return fmt::print("{}", pipeline::scene_rows());
    if (values.json) {
        Json scenes = Json::array();
        for (const auto& [name, description] : pipeline::list_scenes())
            scenes.push_back({{"name", name}, {"description", description}});
        return cli::print_json(scenes);
    }
    for (const auto& [name, description] : pipeline::list_scenes())
        fmt::print("{:<16}{}\n", name, description);
}

void print_fabrics(const Values& values) {
    if (values.markdown) return fmt::print("{}", pipeline::fabric_rows());
    if (values.json) {
        if (!values.name.empty() && !find_fabric(values.name))
            cli::refuse(pipeline::unknown_fabric(values.name));
        Json fabrics = Json::array();
        for (const NamedFabric& named : named_fabrics()) {
            if (!values.name.empty() && values.name != named.fabric.name) continue;
            Json numbers = Json::array();
            for (const FabricValue& v : named.values)
                numbers.push_back(
                    {{"key", v.key}, {"value", v.value}, {"unit", v.unit}, {"source", v.source}});
            fabrics.push_back({{"name", named.fabric.name},
                               {"description", named.description},
                               {"values", std::move(numbers)}});
        }
        return cli::print_json(fabrics);
    }
    if (values.name.empty()) fmt::print("{}", pipeline::fabric_table());
    if (values.sources && values.name.empty()) fmt::print("\n");
    if (values.sources || !values.name.empty()) fmt::print("{}", pipeline::fabric_sources(values.name));
    if (!values.sources && values.name.empty())
        fmt::print(
            "\nwhere each number comes from: render_cloth list fabrics --sources, or list fabrics NAME\n");
}

void print_formats(const Values& values) {
    if (!values.json) return fmt::print("{}", pipeline::export_format_list());
    Json formats = Json::array();
    for (const pipeline::ExportFormat& format : pipeline::export_formats()) {
        Json extensions = Json::array();
        for (const std::string_view each : format.extensions)
            if (!each.empty()) extensions.push_back(each);
        formats.push_back({{"name", format.name}, {"extensions", extensions}, {"meaning", format.meaning}});
    }
    cli::print_json(formats);
}

/// What there is to be listed.
struct Listing {
    const char *what, *meaning;
    void (*print)(const Values&);
    bool has_names = false;     ///< takes a name, and --sources
    bool has_markdown = false;  ///< takes --markdown
    bool has_json = false;      ///< takes --json
};
constexpr Listing listings[] = {
    {"scenes", "the default", print_scenes, false, true, true},
    {"fabrics", "with what each is made of", print_fabrics, true, true, true},
    {"keys", "of scene files", [](const Values&) { fmt::print("{}", pipeline::key_reference()); }},
    {"schema", "of scene files, for editors",
     [](const Values&) { fmt::print("{}", pipeline::json_schema()); }},
    {"formats", "of meshes that are written", print_formats, false, false, true},
    {"manual", "of this program, for man",
     [](const Values&) { fmt::print("{}", cli::manual_page(cli::known_verbs(all()))); }},
    {"completion", "of its words, for bash",
     [](const Values&) { fmt::print("{}", cli::bash_completion(cli::known_verbs(all()))); }},
};

void add(cli::Flags& flags, Values& values) {
    std::vector<std::string> names;
    std::string help;
    for (const Listing& each : listings) {
        names.push_back(each.what);
        help += fmt::format("{}{} ({})", help.empty() ? "" : ", ", each.what, each.meaning);
    }
    flags.choice({"what", "WHAT", help}, values.what, names);
    flags.text({"name", "NAME", "One fabric with the sources of its values"}, values.name);
    flags.yes("--sources", values.sources, "Fabrics with the sources of all values");
    flags.yes("--markdown", values.markdown, "Scenes or fabrics as a table of Markdown");
    flags.yes("--json", values.json, "Scenes, fabrics with their values, or formats as JSON");
}

cli::ExitCode work(const Values& values) {
    for (const Listing& each : listings) {
        if (values.what != each.what) continue;
        if (!each.has_names && (!values.name.empty() || values.sources))
            cli::refuse(fmt::format("list {} takes no name and no --sources; fabrics do", values.what));
        if (!each.has_markdown && values.markdown)
            cli::refuse(fmt::format("list {} takes no --markdown; scenes and fabrics do", values.what));
        if (!each.has_json && values.json)
            cli::refuse(
                fmt::format("list {} takes no --json; scenes, fabrics and formats do, and the keys as "
                            "JSON are list schema",
                            values.what));
        each.print(values);
    }
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb list() {
    return cli::verb("list", "Scenes, fabrics, keys of scene files and their JSON Schema, formats of meshes",
                     add, work);
}

}  // namespace cloth::verbs
