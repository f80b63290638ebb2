#include "pipeline/scene_file/memory_need.h"

#include <algorithm>
#include <cmath>

#include "base/memory.h"
#include "pipeline/scene_file/tables.h"

namespace cloth::pipeline {
namespace {

double vertices_of(const ClothDesc& cloth) {
    if (cloth.mesh) return static_cast<double>(cloth.mesh->positions.rows());
    if (cloth.disc) return 1.0 + 3.0 * cloth.disc->rings * (cloth.disc->rings + 1.0);
    return static_cast<double>(cloth.grid.resolution[0]) * cloth.grid.resolution[1];
}

/// The key that says how fine the cloth of most vertices is.
std::string finest(const Scene& scene) {
    const auto most = std::max_element(
        scene.cloths.begin(), scene.cloths.end(),
        [](const ClothDesc& a, const ClothDesc& b) { return vertices_of(a) < vertices_of(b); });
    if (most == scene.cloths.end()) return "cloth";
    return entry("cloth", static_cast<std::size_t>(most - scene.cloths.begin())) + (most->mesh ? ".mesh"
                                                                                    : most->disc
                                                                                        ? ".rings"
                                                                                        : ".resolution");
}

double vertices_of(const Scene& scene) {
    double sum = 0.0;
    for (const ClothDesc& cloth : scene.cloths) sum += vertices_of(cloth);
    return sum;
}

}  // namespace

MemoryNeed reading_need(const Scene& scene) {
    return {finest(scene), 300.0 * vertices_of(scene)};
}

MemoryNeed simulation_need(const Scene& scene) {
    const double n = std::max(1000.0, vertices_of(scene));
    // The factor of a sheet's matrix grows as n log n.
    return {finest(scene), n * (1600.0 * std::log2(n) - 9000.0)};
}

MemoryNeed picture_need(const SceneFile& file) {
    const double pixels = 55.0 * file.output.size.width * file.output.size.height;
    MemoryNeed surfaces;
    double most = 0.0;
    for (std::size_t c = 0; c < file.scene.cloths.size(); ++c) {
        const int subdivisions = file.looks.cloths.at(c).subdivisions;
        const double bytes = 300.0 * 2.0 * vertices_of(file.scene.cloths[c]) * std::pow(4.0, subdivisions);
        surfaces.bytes += bytes;
        if (bytes <= most) continue;
        most = bytes;
        surfaces.key = subdivisions > 0 ? entry("cloth", c) + ".subdivisions" : finest(file.scene);
    }
    return {surfaces.bytes > pixels ? surfaces.key : "output.size", surfaces.bytes + pixels};
}

void require_memory(const MemoryNeed& need, std::size_t available) {
    if (need.bytes <= static_cast<double>(available)) return;
    throw SceneError(need.key, "needs about " + memory_text(need.bytes) + " of memory; " +
                                   memory_text(static_cast<double>(available)) + " are there");
}

}  // namespace cloth::pipeline
