#include "render/raster/ground.h"

#include <algorithm>

namespace cloth::render {
namespace {

constexpr int caster_cells = 128;  // of the shadow map, along a side, that hold a caster or none

}  // namespace

GroundTiles ground_tiles(const Shot& shot, const GroundPatch& patch, bool shadow, int tile) {
    const View& view = shot.view;
    GroundTiles tiles{{(view.width + 1) / 2, (view.height + 1) / 2, tile},
                      {(view.width + 1) / 2, (view.height + 1) / 2, tile}};
    const ShadowView& s = shot.shadow_view;
    TileMask casters(caster_cells, caster_cells, 1);
    if (shadow)
        for (const Surface& surface : shot.frame.surfaces)
            if (surface.casts_shadow) casters.mark(surface, s.world_to_clip);
    const float reach = (s.largest_radius + 2 * s.texel) / s.width;
    // Where the rays through the tiles' corners meet the floor, and that point in the map
    struct Corner {
        bool on_floor;
        Float3 floor, map;
    };
    const Rays rays = make_rays(shot, 2 * tile);
    const int across = tiles.shadowed.columns() + 1;
    std::vector<Corner> corners_of_tiles;
    for (int row = 0; row <= tiles.shadowed.rows(); ++row)
        for (int column = 0; column < across; ++column) {
            const Float3 ray =
                rays.corner + static_cast<float>(column) * rays.x + static_cast<float>(row) * rays.y;
            const Float3 p = view.eye + ((patch.height - view.eye[1]) / std::min(ray[1], -1e-4f)) * ray;
            corners_of_tiles.push_back({ray[1] < -1e-4f, p, transformed(s.world_to_texture, p)});
        }
    for (int row = 0; row < tiles.shadowed.rows(); ++row)
        for (int column = 0; column < tiles.shadowed.columns(); ++column) {
            Bounds on_floor = nothing, on_map = nothing;
            int below = 0;  // the horizon
            for (const int corner : {0, 1, across, across + 1}) {
                const Corner& c = corners_of_tiles[static_cast<std::size_t>(row * across + column + corner)];
                below += c.on_floor;
                on_floor = merged(on_floor, {c.floor, c.floor});
                on_map = merged(on_map, {c.map, c.map});
            }
            if (below == 0) continue;
            const bool in_patch =
                below < 4 || (on_floor.low[0] < patch.high[0] && on_floor.high[0] > patch.low[0] &&
                              on_floor.low[2] < patch.high[1] && on_floor.high[2] > patch.low[1]);
            const bool in_shadow =
                shadow && (below < 4 || casters.any(on_map.low[0] - reach, on_map.low[1] - reach,
                                                    on_map.high[0] + reach, on_map.high[1] + reach));
            if (in_shadow)
                tiles.shadowed.mark(column, row);
            else if (in_patch)
                tiles.occluded.mark(column, row);
        }
    return tiles;
}

std::vector<float> ground_openness(const Shot& shot, const GroundPatch& patch,
                                   const AmbientOcclusion& occlusion, int size) {
    const auto texels = static_cast<float>(size);
    std::vector<float> open(static_cast<std::size_t>(size) * size, 1.0f);
    if (!shot.occlusion) return open;
    for (int j = 1; j < size - 1; ++j)  // the outermost texels hold 1, which clamping spreads outwards
        for (int i = 1; i < size - 1; ++i) {
            const float u = (static_cast<float>(i) + 0.5f) / texels,
                        v = (static_cast<float>(j) + 0.5f) / texels;
            const Float3 point{patch.low[0] + u * (patch.high[0] - patch.low[0]), patch.height,
                               patch.low[1] + v * (patch.high[1] - patch.low[1])};
            const float visible = occlusion.at(point, {0, 1, 0}, /*on_surface=*/false).from_above;
            const float edge = std::min({u, v, 1 - u, 1 - v}) - 1.0f / texels;
            const float fade = std::clamp(8 * edge, 0.0f, 1.0f);
            // What hides the sky returns a part of the floor's own light.
            open[static_cast<std::size_t>(size) * j + i] =
                1 - 0.55f * (1 - visible) * fade * fade * (3 - 2 * fade);
        }
    return open;
}

}  // namespace cloth::render
