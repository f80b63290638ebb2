#include <fmt/format.h>

#include <array>

#include "apps/verbs/verbs.h"
#include "pipeline/scene_file/fabric_list.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string what = "scenes", name;
    bool sources = false;
};

void add(cli::Flags& flags, Values& values) {
    flags.choice({"what", "WHAT", "scenes (the default), fabrics, or keys of scene files"}, values.what,
                 {"scenes", "fabrics", "keys"});
    flags.text({"name", "NAME", "One fabric with the sources of its values"}, values.name);
    flags.yes("--sources", values.sources, "Fabrics with the sources of all values");
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
    if (values.what == "fabrics") list_fabrics(values);
    if (values.what == "keys") fmt::print("{}", pipeline::key_reference());
    if (values.what == "scenes")
        for (const auto& [name, description] : pipeline::list_scenes())
            fmt::print("{:<16}{}\n", name, description);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb list() {
    return cli::verb("list", "The scenes, the fabrics, or the keys of scene files", add, work);
}

}  // namespace cloth::verbs
