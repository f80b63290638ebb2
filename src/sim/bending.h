#pragma once
// Bending of sheets that are flat at rest: a quadratic energy, so its Hessian is constant.
//
// Each triangle sees the quadratic surface through its own corners and the far corners of its (up to three)
// neighbours. Its second derivatives κ11, κ12, κ22 in the rest frame are linear in the positions, κ_ab = Σ
// w_ab,i x_i, and are vectors in space; for an isometric deformation they are the curvatures times the
// normal. The energy is that of a plate without Poisson coupling,
//
//   E = ½ D ∫ κ11² + 2 κ12² + κ22² dA        (D = bending rigidity)
//
// It vanishes under any affine map, and it is exact for constant curvature in every direction, on every mesh.
// A sum of separate hinges is not: on a grid of right triangles the cotangent form of Bergou et al. 2006 (A
// Quadratic Bending Model for Inextensible Surfaces) gives three times the energy of a cylinder along the
// grid. The four- triangle patch is that of rotation-free plate elements (Oñate and Zárate 2000). Where the
// rim leaves a neighbour out, the curvatures of least norm are taken.

#include <vector>

#include "sim/elements.h"
#include "sim/energy.h"

namespace cloth {

/// A triangle's corners, then the far corner of the neighbour across the edge opposite to each corner. Where
/// there is no neighbour, the corner itself stands in, with weight 0.
struct BendingPatch {
    std::array<int, 6> vertices;
    Eigen::Matrix<double, 3, 6> weights;  ///< rows: κ11, κ12, κ22 [1/m²]
    double area;                          ///< of the triangle at rest [m²]
};

/// Patches of all triangles. A curved rest shape is unfolded across each edge.
std::vector<BendingPatch> make_bending_patches(const Points& rest, const Triangles& triangles);

class BendingEnergy final : public Energy {
  public:
    /// `rigidity` D per patch [N m].
    BendingEnergy(const std::vector<BendingPatch>& patches, const std::vector<double>& rigidity);

    std::string_view name() const override { return "bending"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override { patches_.append_pairs(pairs); }
    void bind(const BlockPattern& pattern) override;

  private:
    Elements<6> patches_;
    std::vector<Eigen::Matrix<double, 6, 6>> stiffness_;  ///< D A Σ w_abᵀ w_ab, the same for x, y and z [N/m]
    ScalarBlockMatrix hessian_;                           ///< their sum over the pattern
};

}  // namespace cloth
