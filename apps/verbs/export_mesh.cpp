#include <fmt/format.h>

#include <limits>

#include "apps/verbs/verbs.h"
#include "pipeline/run/run.h"

namespace cloth::verbs {
namespace {

struct Values {
    std::string out, format, file;
    int frame = 0;
};

void add(cli::Flags& flags, Values& values) {
    flags.text({"--out", "DIR", "Folder of the run", true}, values.out);
    flags.integer({"--frame", "K", "Number of the frame", true}, values.frame, 0,
                  std::numeric_limits<int>::max());
    flags.choice({"--format", "NAME", "Kind of mesh file", true}, values.format, {"obj", "ply"});
    flags.text({"--file", "F", "Mesh file to write", true}, values.file);
}

cli::ExitCode work(const Values& values) {
    export_frame(values.out, values.frame,
                 values.format == "obj" ? pipeline::MeshFormat::obj : pipeline::MeshFormat::ply, values.file);
    fmt::print("frame {} as {}: {}\n", values.frame, values.format, values.file);
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb export_mesh() {
    return cli::verb("export", "A kept frame's state as a mesh file", add, work);
}

}  // namespace cloth::verbs
