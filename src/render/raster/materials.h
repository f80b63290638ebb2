#pragma once
// Materials in the form in which the shader reads them.

#include <compare>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "render/frame.h"
#include "render/image/image.h"

namespace cloth::render {

/// What a frame's surfaces need of the shading program.
struct Features {
    bool patterns = false, weave = false, colors = false;
    int images = 0;
    auto operator<=>(const Features&) const = default;

    std::string defines() const {
        std::string text;
        if (patterns) text += "#define PATTERNS\n";
        if (weave) text += "#define WEAVE\n";
        if (colors) text += "#define COLORS\n";
        if (images > 0) text += "#define IMAGES " + std::to_string(images) + "\n";
        return text;
    }
};

struct MaterialTexels {
    Features features;
    std::vector<std::shared_ptr<const Image>> images;  ///< that patterns show, each once
    std::vector<float> texels;                         ///< seven of r g b a per surface
};
/// Throws std::invalid_argument for more than `most_images` different images.
MaterialTexels material_texels(std::span<const Surface> surfaces, int most_images);

}  // namespace cloth::render
