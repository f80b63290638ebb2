#include "render/raster/mesh_list.h"

#include <algorithm>
#include <bit>

#include "render/vector_math.h"

namespace cloth::render {
namespace {

constexpr std::uint32_t none = 0xffffffff;
// About so many vertices of a surface are computed, as long as they are not further apart than so many edges.
constexpr std::size_t wanted_anchors = 2500;
constexpr int furthest_anchor = 4;

void find_owners(SurfaceTopology& t) {
    std::vector<bool> owned(t.vertices, false);
    t.indices.assign(t.triangles.begin(), t.triangles.end());
    t.doubled.clear();
    t.corners.assign(3 * t.vertices, 0);
    for (std::size_t i = 0; i + 2 < t.indices.size(); i += 3) {
        std::uint32_t* corner = t.indices.data() + i;
        int owner = -1;
        for (int k = 2; k >= 0 && owner < 0; --k)
            if (!owned[corner[k]]) owner = k;
        std::rotate(corner, corner + (owner < 0 ? 3 : owner + 1) % 3, corner + 3);
        if (owner >= 0) {
            owned[corner[2]] = true;
            std::copy_n(corner, 3, t.corners.begin() + 3 * std::ptrdiff_t{corner[2]});
        } else {
            t.corners.insert(t.corners.end(), corner, corner + 3);
            t.doubled.push_back(corner[2]);
            corner[2] = static_cast<std::uint32_t>(t.vertices + t.doubled.size() - 1);
        }
    }
}

void find_anchors(SurfaceTopology& t) {
    // Neighbours of each vertex; an edge of two triangles counts twice, which is as good.
    std::vector<std::uint32_t> starts(t.vertices + 1, 0), neighbours(2 * t.triangles.size());
    for (const std::uint32_t v : t.triangles) starts[v + 1] += 2;
    for (std::size_t v = 0; v < t.vertices; ++v) starts[v + 1] += starts[v];
    std::vector<std::uint32_t> next(starts.begin(), starts.end() - 1);
    for (std::size_t i = 0; i + 2 < t.triangles.size(); i += 3)
        for (int k = 0; k < 3; ++k) {
            const std::uint32_t v = t.triangles[i + k];
            neighbours[next[v]++] = t.triangles[i + (k + 1) % 3];
            neighbours[next[v]++] = t.triangles[i + (k + 2) % 3];
        }
    const auto around = [&](std::uint32_t v) {
        return std::span(neighbours).subspan(starts[v], starts[v + 1] - starts[v]);
    };

    int reach = 1;
    while (reach < furthest_anchor &&
           t.vertices / static_cast<std::size_t>(2 * reach * (reach + 1)) > wanted_anchors)
        ++reach;
    // In order of their numbers, each vertex without an anchor within reach becomes one.
    std::vector<std::uint8_t> covered(t.vertices, 0);
    std::vector<std::uint32_t> ring, wider;
    t.anchors.clear();
    for (std::uint32_t v = 0; v < t.vertices; ++v) {
        if (covered[v]) continue;
        t.anchors.push_back(v);
        covered[v] = 1;
        ring.assign(1, v);
        std::vector<std::uint32_t> seen{v};
        for (int step = 0; step < reach; ++step) {
            wider.clear();
            for (const std::uint32_t u : ring)
                for (const std::uint32_t w : around(u)) {
                    if (std::find(seen.begin(), seen.end(), w) != seen.end()) continue;
                    seen.push_back(w);
                    covered[w] = 1;
                    wider.push_back(w);
                }
            ring.swap(wider);
        }
    }
    // The others are means of neighbours that lie nearer to an anchor.
    std::vector<std::uint32_t> distance(t.vertices, none);
    t.order.clear();
    t.sources.clear();
    t.source_starts.assign(1, 0);
    for (const std::uint32_t v : t.anchors) distance[v] = 0;
    ring = t.anchors;
    for (std::uint32_t step = 1; !ring.empty(); ++step) {
        wider.clear();
        for (const std::uint32_t u : ring)
            for (const std::uint32_t w : around(u))
                if (distance[w] == none) {
                    distance[w] = step;
                    wider.push_back(w);
                }
        std::sort(wider.begin(), wider.end());
        for (const std::uint32_t w : wider) {
            for (const std::uint32_t u : around(w))
                if (distance[u] < step) t.sources.push_back(u);
            t.order.push_back(w);
            t.source_starts.push_back(static_cast<std::uint32_t>(t.sources.size()));
        }
        ring.swap(wider);
    }
}

/// Cigolle et al. 2014, A Survey of Efficient Representations for Independent Unit Vectors.
std::uint32_t octahedral(const Float3& n) {
    const float sum = std::abs(n[0]) + std::abs(n[1]) + std::abs(n[2]);
    float x = sum > 0 ? n[0] / sum : 0, y = sum > 0 ? n[1] / sum : 0;
    if (n[2] < 0) {
        const float folded = (1 - std::abs(y)) * (x >= 0 ? 1.0f : -1.0f);
        y = (1 - std::abs(x)) * (y >= 0 ? 1.0f : -1.0f);
        x = folded;
    }
    const auto half = [](float value) {
        const float scaled = 32767 * value;  // rounded to nearest
        return static_cast<std::uint32_t>(static_cast<std::int32_t>(scaled + (scaled >= 0 ? 0.5f : -0.5f))) &
               0xffffu;
    };
    return half(x) | half(y) << 16;
}

}  // namespace

bool update(SurfaceTopology& t, std::span<const std::uint32_t> triangles, std::size_t vertices) {
    if (t.vertices == vertices && std::ranges::equal(t.triangles, triangles)) return false;
    t.vertices = vertices;
    t.triangles.assign(triangles.begin(), triangles.end());
    find_owners(t);
    find_anchors(t);
    return true;
}

void spread(const SurfaceTopology& t, std::span<float> values) {
    for (std::size_t i = 0; i < t.order.size(); ++i) {
        std::array<float, 4> sum{};
        for (std::uint32_t s = t.source_starts[i]; s < t.source_starts[i + 1]; ++s)
            for (int k = 0; k < 4; ++k) sum[k] += values[4 * std::size_t{t.sources[s]} + k];
        const float share = 1 / static_cast<float>(t.source_starts[i + 1] - t.source_starts[i]);
        for (int k = 0; k < 4; ++k) values[4 * std::size_t{t.order[i]} + k] = share * sum[k];
    }
}

void even_out(const SurfaceTopology& t, int passes, std::span<float> values) {
    std::vector<std::array<float, 5>> sums;  // four values and the count
    for (int pass = 0; pass < passes; ++pass) {
        sums.assign(t.vertices, {});
        for (std::size_t i = 0; i + 2 < t.triangles.size(); i += 3) {
            std::array<float, 4> all{};
            for (std::size_t c = 0; c < 3; ++c)
                for (std::size_t k = 0; k < 4; ++k) all[k] += values[4 * std::size_t{t.triangles[i + c]} + k];
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t v = t.triangles[i + c];
                for (std::size_t k = 0; k < 4; ++k) sums[v][k] += all[k] - values[4 * v + k];
                sums[v][4] += 2;
            }
        }
        for (std::size_t v = 0; v < t.vertices; ++v) {
            if (sums[v][4] == 0) continue;
            for (std::size_t k = 0; k < 4; ++k)
                values[4 * v + k] = 0.5f * (values[4 * v + k] + sums[v][k] / sums[v][4]);
        }
    }
}

bool winding_follows_normals(const Surface& s) {
    double sum = 0;
    const auto vector = [](std::span<const float> a, std::uint32_t i) {
        return Float3{a[3 * std::size_t{i}], a[3 * std::size_t{i} + 1], a[3 * std::size_t{i} + 2]};
    };
    for (std::size_t t = 0; t + 2 < s.triangles.size(); t += 3) {
        const Float3 a = vector(s.positions, s.triangles[t]);
        const Float3 area =
            cross(vector(s.positions, s.triangles[t + 1]) - a, vector(s.positions, s.triangles[t + 2]) - a);
        sum += dot(area, vector(s.normals, s.triangles[t]));
    }
    return sum >= 0;
}

bool MeshList::assemble(std::span<const Surface> surfaces) {
    bool changed = topologies.size() != surfaces.size();
    topologies.resize(surfaces.size());
    std::vector<std::uint32_t> casting;
    first_vertex.assign(1, 0);
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const Surface& surface = surfaces[i];
        changed = update(topologies[i], surface.triangles, surface.positions.size() / 3) || changed;
        first_vertex.push_back(first_vertex[i] + static_cast<std::uint32_t>(topologies[i].vertices +
                                                                            topologies[i].doubled.size()));
    }
    std::vector<std::size_t> sequence;
    for (const bool casts : {true, false})
        for (std::size_t i = 0; i < surfaces.size(); ++i)
            if (surfaces[i].casts_shadow == casts) sequence.push_back(i);
    std::vector<std::uint32_t> starts(surfaces.size() + 1, 0);
    std::uint32_t start = 0;
    for (const std::size_t i : sequence) {
        starts[i] = start;
        start += static_cast<std::uint32_t>(topologies[i].indices.size());
        if (surfaces[i].casts_shadow) casting_indices = start;
    }
    if (sequence.empty() || !surfaces[sequence.front()].casts_shadow) casting_indices = 0;
    starts.back() = start;
    changed = changed || starts != first_index;
    first_index = starts;

    const std::size_t count = first_vertex.back();
    if (changed) {
        indices.clear();
        corners.assign(4 * count, 0);
        for (const std::size_t i : sequence) {
            const SurfaceTopology& t = topologies[i];
            const std::uint32_t first = first_vertex[i];
            for (const std::uint32_t index : t.indices) indices.push_back(first + index);
            for (std::size_t v = 0; 3 * v < t.corners.size(); ++v) {
                for (int k = 0; k < 3; ++k) corners[4 * (first + v) + k] = first + t.corners[3 * v + k];
                corners[4 * (first + v) + 3] = static_cast<std::uint32_t>(i);
            }
        }
    }
    vertices.resize(4 * count);
    ambient.resize(count);
    colors.clear();
    coordinates.clear();
    if (std::ranges::any_of(surfaces, [](const Surface& s) { return !s.colors.empty(); }))
        colors.resize(4 * count);
    if (std::ranges::any_of(surfaces, [](const Surface& s) {
            return s.material.pattern != Pattern::plain || s.material.weave > 0;
        }))
        coordinates.resize(2 * count);
    for (std::size_t i = 0; i < surfaces.size(); ++i) {
        const Surface& s = surfaces[i];
        const SurfaceTopology& t = topologies[i];
        const std::size_t first = first_vertex[i];
        std::uint32_t* words = vertices.data() + 4 * first;
        for (std::size_t v = 0; v < t.vertices; ++v) {
            std::uint32_t* w = words + 4 * v;
            for (int k = 0; k < 3; ++k) w[k] = std::bit_cast<std::uint32_t>(s.positions[3 * v + k]);
            w[3] = octahedral({s.normals[3 * v], s.normals[3 * v + 1], s.normals[3 * v + 2]});
        }
        // Doubled vertices are drawn, but all else is looked up at the vertex itself.
        for (std::size_t d = 0; d < t.doubled.size(); ++d)
            std::copy_n(words + 4 * std::size_t{t.doubled[d]}, 4, words + 4 * (t.vertices + d));
        if (!coordinates.empty())
            std::ranges::copy(s.coordinates, coordinates.begin() + static_cast<std::ptrdiff_t>(2 * first));
        if (s.colors.empty()) continue;
        float* color = colors.data() + 4 * std::size_t{first_vertex[i]};
        for (std::size_t v = 0; v < t.vertices; ++v) {
            std::copy_n(s.colors.data() + 3 * v, 3, color + 4 * v);
            color[4 * v + 3] = 1;
        }
    }
    return changed;
}

void MeshList::set_ambient(std::size_t surface, std::span<const float> values) {
    std::uint32_t* words = ambient.data() + first_vertex[surface];
    for (std::size_t v = 0; 4 * v < values.size(); ++v) {
        std::uint32_t packed = 0;
        for (int k = 0; k < 4; ++k)
            packed |= static_cast<std::uint32_t>(255 * std::clamp(values[4 * v + k], 0.0f, 1.0f) + 0.5f)
                      << 8 * k;
        words[v] = packed;
    }
}

}  // namespace cloth::render
