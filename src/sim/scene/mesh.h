#pragma once
// Rest shapes: grids, checks, topology.

#include <string>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/scene/scene.h"

namespace cloth {

/// Vertices row by row from the lower left, x fastest: vertex (i, j) has index j * resolution[0] + i.
MeshData make_grid(const Grid& grid);

/// Ring k's vertices follow those of ring k - 1, counter-clockwise from the x axis. The triangles are nearly
/// equilateral.
MeshData make_disc(const Disc& disc);

/// The cloth's mesh, disc or grid [m].
MeshData rest_shape(const ClothDesc& cloth);

/// Refuses what is no cloth: no triangle, an index out of range, a triangle with a repeated corner or
/// (nearly) no area, the same three corners twice, an edge of more than two triangles, a non-finite
/// coordinate, a vertex of no triangle, neighbours that face opposite ways (repair_cloth_mesh() has turned
/// all that can be). Throws SceneError under `key`, naming the triangle or vertex (counted from 0).
void check_cloth_mesh(const MeshData& mesh, const std::string& key);

/// Start positions of a cloth: rest shape or pose, bump, then transform. Shape (n, 3) [m].
Points start_positions(const ClothDesc& cloth, const MeshData& rest);

/// A length that the cloth's size sets where nothing is said: `usual`, but at most a hundredth and at least a
/// ten-thousandth of the diagonal of the rest shape's box [m].
double usual_length(double usual, const MeshData& rest);

/// Gives each contact_thickness, uv_scale and contact_activation that is not said its value; `rest`: one per
/// cloth.
void settle_lengths(Scene& scene, const std::vector<MeshData>& rest);

/// Rotation about the fixed x, then y, then z axis by degrees; exact for multiples of 90.
Mat3 rotation_matrix(const Vec3& degrees);

}  // namespace cloth
