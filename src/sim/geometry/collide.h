#pragma once
// Pure geometry of contact: nearest features, time of impact, crossing triangles. No state, no physics.
//
// A pair is four points, split into two sides:
//   vertex-face   points 0 | 1 2 3        edge-edge   points 0 1 | 2 3
// The vector between the nearest points is d(x) = Σ w_i x_i with Σ w_i = 0: weights of side A are positive
// and sum to 1, those of side B negative and sum to -1. A side with fewer corners (an edge or a point met by
// a vertex, a point met by an edge) repeats its last point; the functions take degenerate input as it comes.
//
// As the weights minimise |d|², the gradient of |d| at point i is w_i d/|d| whatever the nearest features
// are.

#include <array>

#include "sim/algebra/types.h"

namespace cloth {

using FourPoints = std::array<Vec3, 4>;

enum class PairKind : unsigned char { vertex_face, edge_edge };

/// Nearest points of a pair.
struct Nearest {
    double distance_squared = 0.0;  ///< [m²]
    std::array<double, 4> weights{};
    /// Directions in which the weights may slide freely (both nearest points inside their feature along it):
    /// two for vertex-face proper and edge-edge proper, one for vertex-edge, none for vertex-vertex.
    int slide_count = 0;
    std::array<std::array<double, 4>, 2> slides{};

    Vec3 difference(const FourPoints& x) const {
        return weights[0] * x[0] + weights[1] * x[1] + weights[2] * x[2] + weights[3] * x[3];
    }
};

/// Squared distances with weights. Where a needle or nearly parallel edges make the inner solution doubtful,
/// its distance and those of the boundary are compared and the least wins.
Nearest nearest_point_point(const Vec3& a, const Vec3& b);
Nearest nearest_vertex_face(const FourPoints& x);
Nearest nearest_edge_edge(const FourPoints& x);
inline Nearest nearest(PairKind kind, const FourPoints& x) {
    return kind == PairKind::vertex_face ? nearest_vertex_face(x) : nearest_edge_edge(x);
}

/// Whether the boxes around the two sides tell that they are farther apart than `reach`.
bool boxes_apart(PairKind kind, const FourPoints& x, double reach);

/// The largest share t ≤ 1 of the motion x → x + t·motion that certainly keeps every distance on the way
/// above `separation`, by additive continuous collision detection (Li et al. 2021, Codimensional incremental
/// potential contact, section 5): where the gap is g and closes no faster than l, an advance of less than g/l
/// is safe; advances are added up until only `slack` of the first gap is left, and never less than half of
/// that. 1 where there is no impact; 0 where the pair is not farther apart than `separation` at the start.
double safe_step(PairKind kind, const FourPoints& x, const FourPoints& motion, double separation,
                 double slack = 0.2);

/// Whether two triangles cross: an edge of one passes through the other's inside. Signs are those of
/// determinants in extended precision; touching and coplanar triangles do not count.
bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b);

}  // namespace cloth
