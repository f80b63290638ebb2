#include "render/raster/vertex_light.h"

#include <algorithm>
#include <array>
#include <span>
#include <thread>
#include <vector>

namespace cloth::render {
namespace {

/// What hides sky or floor returns a part of their light: more than half is left where 0.4 of it comes
/// straight.
AmbientLight with_reflections(const AmbientLight& light, const AmbientLight& open) {
    const auto returned = [](float share, float all) {
        return all > 0 ? share * (1.7f - 0.7f * std::min(share / all, 1.0f)) : 0.0f;
    };
    return {returned(light.from_above, open.from_above), returned(light.from_below, open.from_below)};
}

}  // namespace

void light_vertices(const Shot& shot, const AmbientOcclusion& occlusion, std::size_t threads,
                    MeshList& list) {
    std::vector<float> ambient(4 * std::size_t{list.first_vertex.back()});
    for (std::size_t i = 0; i < shot.frame.surfaces.size(); ++i) {
        const Surface& surface = shot.frame.surfaces[i];
        const SurfaceTopology& topology = list.topologies[i];
        const std::span<float> values =
            std::span(ambient).subspan(4 * std::size_t{list.first_vertex[i]}, 4 * topology.vertices);
        const auto compute = [&](std::size_t v) {
            const Float3 p{surface.positions[3 * v], surface.positions[3 * v + 1],
                           surface.positions[3 * v + 2]};
            const Float3 n{surface.normals[3 * v], surface.normals[3 * v + 1], surface.normals[3 * v + 2]};
            AmbientLight front{0.5f * (1 + n[1]), 0.5f * (1 - n[1])};
            AmbientLight back{front.from_below, front.from_above};
            if (shot.occlusion) {
                front = with_reflections(occlusion.at(p, n), front);
                if (surface.two_sided) back = with_reflections(occlusion.at(p, -1.0f * n), back);
            }
            const std::array<float, 4> value{front.from_above, front.from_below, back.from_above,
                                             back.from_below};
            std::copy(value.begin(), value.end(), values.begin() + static_cast<std::ptrdiff_t>(4 * v));
        };
        if (!shot.occlusion) {
            for (std::size_t v = 0; v < topology.vertices; ++v) compute(v);
            list.set_ambient(i, values);
            continue;
        }
        // Each anchor stands alone, so how they are shared out changes nothing.
        const auto compute_anchors = [&](std::size_t first, std::size_t last) {
            for (std::size_t a = first; a < last; ++a) compute(topology.anchors[a]);
        };
        constexpr std::size_t anchors_per_thread = 1000;
        const std::size_t count = topology.anchors.size();
        const std::size_t parts = std::clamp<std::size_t>(count / anchors_per_thread, 1, threads);
        std::vector<std::jthread> helpers;
        for (std::size_t part = 1; part < parts; ++part)
            helpers.emplace_back(compute_anchors, count * part / parts, count * (part + 1) / parts);
        compute_anchors(0, count / parts);
        helpers.clear();
        spread(topology, values);
        // Where a layer lies nearer than a cell, neighbours see it differently: seen as teeth along folds.
        constexpr int passes = 4;
        even_out(topology, passes, values);
        list.set_ambient(i, values);
    }
}

}  // namespace cloth::render
