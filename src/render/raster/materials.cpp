#include "render/raster/materials.h"

#include <algorithm>
#include <stdexcept>

#include "render/raster/mesh_list.h"

namespace cloth::render {

MaterialTexels material_texels(std::span<const Surface> surfaces, int most_images) {
    MaterialTexels all;
    Features& features = all.features;
    for (const Surface& surface : surfaces) {
        const Material& m = surface.material;
        const float roughness = std::clamp(m.roughness, 0.05f, 1.0f);
        const bool patterned = m.pattern != Pattern::plain && m.pattern != Pattern::image;
        float number = 0;
        if (m.pattern == Pattern::image) {
            const auto place = std::find(all.images.begin(), all.images.end(), m.image);
            number = static_cast<float>(place - all.images.begin() + 1);
            if (place == all.images.end()) all.images.push_back(m.image);
        }
        features.patterns |= patterned;
        features.weave |= m.weave > 0;
        features.colors |= !surface.colors.empty();
        const auto add = [&](const Float3& rgb, float a) {
            all.texels.insert(all.texels.end(), {rgb[0], rgb[1], rgb[2], a});
        };
        add(m.front, roughness * roughness * roughness * roughness);
        add(m.back, 0.5f * roughness * roughness);
        add({m.specular, m.sheen, surface.two_sided ? 1.0f : 0.0f},
            winding_follows_normals(surface) ? 1.0f : -1.0f);
        add({patterned ? static_cast<float>(m.pattern) : 0.0f,
             m.pattern == Pattern::plain ? 0 : 1 / m.pattern_scale, m.weave > 0 ? 1 / m.weave : 0},
            m.weave_depth);
        add(m.pattern_colors[0], m.pattern_on_back ? 1.0f : 0.0f);
        add(m.pattern_colors[1], number);
        add(m.pattern_colors[2], 0);
    }
    features.images = static_cast<int>(all.images.size());
    if (features.images > most_images)
        throw std::invalid_argument("the surfaces show " + std::to_string(features.images) +
                                    " different images; at most " + std::to_string(most_images) +
                                    " can be drawn");
    return all;
}

}  // namespace cloth::render
