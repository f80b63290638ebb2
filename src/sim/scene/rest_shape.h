#pragma once
// What each triangle of a cloth is like at rest: its corners, which neighbours need not share, and its
// fabric.

#include <string>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Refuses texture coordinates that are no rest shape: none, or of a triangle none, without area, or folded
/// over where two triangles that share an edge on the map lie on one side of it. Throws SceneError under
/// `key`, naming the triangle. Islands may lie on each other and be mirrored.
void check_uv(const MeshData& mesh, const std::string& key);

/// A unit of texture coordinates with which all triangles together have the area that they have on the mesh
/// [m]. Requires what check_uv() lets pass.
double natural_uv_scale(const MeshData& mesh);

/// Corner k of triangle t at rest in row 3t + k, shape (3m, 3) [m]: of RestShape::uv its texture coordinates
/// in the plane z = 0, else the vertices of `rest`.
Points rest_corners(const ClothDesc& cloth, const MeshData& rest);

/// The named part, or null.
const MeshPart* find_part(const MeshData& mesh, const std::string& name);
/// "has no part "sleeve"; its parts: body, collar".
std::string unknown_part(const MeshData& mesh, const std::string& name);

/// Of each triangle of a cloth the [[part]] whose fabric it is of, the last that holds it, or -1 for the
/// cloth's. Throws SceneError where a [[part]] names none of the mesh's.
std::vector<int> part_of_triangles(const Scene& scene, std::size_t cloth, const MeshData& rest);

}  // namespace cloth
