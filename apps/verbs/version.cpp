#include <fmt/format.h>

#include <string>

#include "apps/cli/work.h"
#include "apps/verbs/verbs.h"
#include "pipeline/formats/build_info.h"
#include "pipeline/formats/video.h"
#include "render/raster/rasterizer.h"

namespace cloth::verbs {
namespace {

void add(cli::Flags& flags, cli::WorkFlags& values) {
    values.add_gl(flags);
}

template <class Ask>
std::string attempt(Ask ask) {
    try {
        return ask();
    } catch (const std::exception& e) {
        return std::string("not available: ") + e.what();
    }
}

cli::ExitCode work(const cli::WorkFlags& values) {
    fmt::print("render_cloth {}\ncompiler: {}\nbuild: {}\nrenderer: {}\nencoder: {}\n",
               pipeline::program_version(), pipeline::compiler(), pipeline::build_fingerprint(),
               attempt([&] { return cloth::render::Rasterizer(1, values.gl_library()).description(); }),
               attempt([] { return pipeline::ffmpeg_version(); }));
    return cli::ExitCode::good;
}

}  // namespace

cli::Verb version() {
    return cli::verb("version", "Version, compiler, build fingerprint, renderer and encoder", add, work);
}

}  // namespace cloth::verbs
