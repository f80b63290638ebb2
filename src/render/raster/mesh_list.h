#pragma once
// All surfaces of a frame as one list of vertices and triangles, in the form in which the rasterizer draws
// them.
//
// Of each sample only the number of its triangle is kept (Burns and Hunt 2013, The Visibility Buffer). A
// triangle is numbered by one of its vertices, its owner, which is its last corner, so that a flat output
// carries the number; where there are more triangles than vertices, vertices are doubled.

#include <cstdint>
#include <span>
#include <vector>

#include "render/frame.h"

namespace cloth::render {

/// What depends on a surface's triangles alone. Kept while they are the same.
struct SurfaceTopology {
    std::vector<std::uint32_t> triangles;  ///< as given, to tell whether they changed
    std::size_t vertices = 0;
    std::vector<std::uint32_t> indices;  ///< turned so that the last corner owns; may name doubled vertices
    std::vector<std::uint32_t> doubled;  ///< vertex that each vertex beyond `vertices` repeats
    std::vector<std::uint32_t> corners;  ///< a b c of the triangle that each vertex owns, or 0 0 0

    // Spreads values from a few vertices over the others; see ambient_field.h.
    std::vector<std::uint32_t> anchors;        ///< vertices that are computed
    std::vector<std::uint32_t> order;          ///< the others, each behind those that it is taken from
    std::vector<std::uint32_t> source_starts;  ///< place in `sources` per entry of `order`, and one more
    std::vector<std::uint32_t> sources;        ///< the vertex is their mean
};

/// Brings `topology` up to date; true where it changed.
bool update(SurfaceTopology& topology, std::span<const std::uint32_t> triangles, std::size_t vertices);

/// Sets the values of the vertices in `order`, four a vertex, from those of the anchors.
void spread(const SurfaceTopology& topology, std::span<float> values);
/// Moves each vertex's four values half of the way to the mean over its triangles' other corners, `passes`
/// times.
void even_out(const SurfaceTopology& topology, int passes, std::span<float> values);

/// Whether counter-clockwise triangles show the side that the normals point to.
bool winding_follows_normals(const Surface& surface);

struct MeshList {
    std::vector<SurfaceTopology> topologies;
    std::vector<std::uint32_t> first_vertex;  ///< of each surface, and one more
    std::vector<std::uint32_t> first_index;   ///< likewise; surfaces that cast shadows come first
    std::vector<std::uint32_t> indices;
    std::vector<std::uint32_t> corners;  ///< a b c and number of the surface, per vertex
    /// Four words per vertex: bits of x y z, the normal as two halves of its octahedral image
    std::vector<std::uint32_t> vertices;
    std::vector<std::uint32_t> ambient;  ///< four bytes per vertex
    std::vector<float> coordinates;      ///< u v per vertex, or zeros; empty where no material needs them
    std::vector<float> colors;           ///< r g b and 1, or zeros; empty where no surface has colours
    std::size_t casting_indices = 0;     ///< of the surfaces that cast shadows

    /// True where indices or corners changed. Leaves ambient light open.
    bool assemble(std::span<const Surface> surfaces);
    /// Shares 0 … 1 of light from above and below, on the front and on the back, of all vertices of a
    /// surface.
    void set_ambient(std::size_t surface, std::span<const float> values);
};

}  // namespace cloth::render
