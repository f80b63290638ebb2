#pragma once
// Flags of the verbs that work on golden states and pictures.

#include <filesystem>
#include <string>

#include "apps/cli/scene_flags.h"
#include "apps/cli/work.h"

namespace cloth::cli {

struct GoldenFlags {
    std::string golden = "golden";
    SceneFlags scene;
    WorkFlags work;

    void add(Flags& flags);
    /// The scene's own in the folder of goldens.
    std::filesystem::path folder(const pipeline::SceneFile& file) const;
};

}  // namespace cloth::cli
