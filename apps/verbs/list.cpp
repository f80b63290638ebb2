#include <fmt/format.h>

#include "apps/verbs/verbs.h"
#include "pipeline/scene_file/fabric_list.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string what = "scenes", name;
    bool sources = false, markdown = false;
};

void add(cli::Flags& flags, Values& values) {
    flags.choice(
        {"what", "WHAT",
         "scenes (the default), fabrics, keys of scene files, or schema: their JSON Schema, for editors"},
        values.what, {"scenes", "fabrics", "keys", "schema"});
    flags.text({"name", "NAME", "One fabric with the sources of its values"}, values.name);
    flags.yes("--sources", values.sources, "Fabrics with the sources of all values");
    flags.yes("--markdown", values.markdown, "Scenes or fabrics as a table of Markdown");
}

void list_fabrics(const Values& values) {
    if (values.name.empty()) fmt::print("{}", pipeline::fabric_table());
    if (values.sources && values.name.empty()) fmt::print("\n");
    if (values.sources || !values.name.empty()) fmt::print("{}", pipeline::fabric_sources(values.name));
    if (!values.sources && values.name.empty())
        fmt::print(
            "\nwhere each number comes from: render_cloth list fabrics --sources, or list fabrics NAME\n");
}

cli::ExitCode work(const Values& values) {
    if (values.what != "fabrics" && (!values.name.empty() || values.sources))
        cli::refuse(fmt::format("list {} takes no name and no --sources; fabrics do", values.what));
    if (values.markdown && values.what != "scenes" && values.what != "fabrics")
        cli::refuse(fmt::format("list {} takes no --markdown; scenes and fabrics do", values.what));
    if (values.what == "keys") fmt::print("{}", pipeline::key_reference());
    if (values.what == "schema") fmt::print("{}", pipeline::json_schema());
    if (values.what == "fabrics" && values.markdown) fmt::print("{}", pipeline::fabric_rows());
    if (values.what == "fabrics" && !values.markdown) list_fabrics(values);
    if (values.what == "scenes" && values.markdown) fmt::print("{}", pipeline::scene_rows());
    if (values.what == "scenes" && !values.markdown)
        for (const auto& [name, description] : pipeline::list_scenes())
            fmt::print("{:<16}{}\n", name, description);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb list() {
    return cli::verb("list", "The scenes, the fabrics, or the keys of scene files and their JSON Schema", add,
                     work);
}

}  // namespace cloth::verbs
