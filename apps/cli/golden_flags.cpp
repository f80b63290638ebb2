#include "apps/cli/golden_flags.h"

namespace cloth::cli {

void GoldenFlags::add(Flags& flags) {
    flags.text({"scene", "SCENE", "Scene, by name or TOML file", true}, scene.scene);
    flags.text({"--golden", "DIR", "Folder with a folder of goldens for each scene (default: golden)"},
               golden);
    flags.text({"--out", "DIR", "Folder of the report (default: out/NAME)"}, scene.out);
    work.add_threads(flags);
    work.add_gl(flags);
}

std::filesystem::path GoldenFlags::folder(const pipeline::SceneFile& file) const {
    return std::filesystem::path(golden) / file.name;
}

}  // namespace cloth::cli
