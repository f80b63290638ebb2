#pragma once
// Bending: the curvature of each triangle with its neighbours, quadratic or by the angles of its hinges.
//
// Curvature. Across edge i of a triangle of area A lies a neighbour; h_t and h_n are the two triangles'
// heights over the edge, n_i its normal in the rest plane. The slope across the edge is the one that a
// quadratic surface through both triangles has there, (h_n slope_t + h_t slope_n)/(h_t + h_n), and both
// triangles use it: this is Morley's plate element with its edge slopes eliminated. With f_i the fold across
// the edge (difference of the two slopes) the curvature is
//
//   κ = Σ_i 2 f_i / (h_t + h_n)  (n_i n_iᵀ),   (κ11, κ12, κ22) in the rest frame whose first axis is the warp
//
// At the rim the slope is free and takes the value of least energy, which is the natural condition there (no
// moment). Because the two sides share the slope, a state of constant moment is in balance on every mesh; and
// the curvature of a quadratic surface is exact where the line between the two far corners crosses the edge
// at its middle: on every grid with all diagonals in one direction, and on equilateral triangles. On a grid
// with alternating diagonals a twist counts double. A sum of separate hinges is exact on neither: on a grid
// of right triangles the cotangent form of Bergou et al. 2006 (A Quadratic Bending Model for Inextensible
// Surfaces) gives three times the energy of a cylinder along the grid.
//
// Energy, an orthotropic plate without Poisson coupling:
//
//   E = ½ ∫ D_warp κ11² + D_weft κ22² + 2 H κ12² dA,    D(45°) = D_bias = (D_warp + D_weft + 2H)/4
//
// Quadratic: f_i h_n is the amount by which the far corner lies off the triangle's plane, taken in the rest
// configuration: linear in the positions, so κ is a vector in space (curvature times normal for an isometric
// deformation) and the Hessian is constant. It vanishes under any affine map; the rest shape counts as flat.
//
// Hinges: f_i = 2 tan(θ_i/2) - the same at rest, θ_i the angle between the two triangles' normals: for curved
// rest shapes, sharp folds and creases. Of its Hessian Σ K_ij ∇f_i ∇f_jᵀ + Σ (Kf)_i ∇²f_i the projection
// keeps the first part.

#include <optional>
#include <vector>

#include "sim/energies/elements.h"
#include "sim/energies/energy.h"

namespace cloth {

/// A triangle's corners, then the far corner of the neighbour across the edge opposite to each corner. Where
/// there is no neighbour, the corner itself stands in, with weight 0.
struct BendingPatch {
    std::array<int, 6> vertices;
    double area;                          ///< of the triangle at rest [m²]
    Mat3 fold_weights;                    ///< column i: κ11, κ12, κ22 per fold f_i [1/m]; 0 at the rim
    Mat3 rim;                             ///< columns: κ that the free slope of rim edge i adds; 0 inside
    Eigen::Matrix<double, 3, 6> offsets;  ///< row i: f_i of flat positions, linear [1/m]
    Vec3 rest_folds;                      ///< 2 tan(θ_i/2) at rest
};

/// Patches of all triangles; `corners`: each one's own rest shape, see rest_corners(). A curved rest shape is
/// unfolded across each edge; one that neighbours do not share, at a seam, is laid edge to edge, middle to
/// middle, and rests flat there. `warp`: see make_rest_frame().
std::vector<BendingPatch> make_bending_patches(const Points& corners, const Triangles& triangles,
                                               const Vec3& warp);

/// Rigidity over (κ11, κ12, κ22): diag(D_warp, 2H, D_weft) [N m]. Without a bias of its own H = √(D_warp
/// D_weft).
Mat3 bending_rigidity(double warp, double weft, std::optional<double> bias);

/// Stiffness over the folds f: E = ½ fᵀ K f, rim slopes eliminated. Shape (3, 3) [N m].
Mat3 fold_stiffness(const BendingPatch& patch, const Mat3& rigidity);

class BendingEnergy final : public Energy {
  public:
    /// One rigidity per patch.
    BendingEnergy(const std::vector<BendingPatch>& patches, const std::vector<Mat3>& rigidity);

    std::string_view name() const override { return "bending"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    bool constant_hessian() const override { return true; }
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override { patches_.append_pairs(pairs); }
    void bind(const BlockPattern& pattern) override;

  private:
    Elements<6> patches_;
    std::vector<Eigen::Matrix<double, 3, 6>> offsets_;  ///< of each patch
    std::vector<Mat3> stiffness_;                       ///< fold_stiffness(), the same for x, y and z
    ScalarBlockMatrix hessian_;                         ///< their sum over the pattern
};

/// Fold 2 tan(θ/2) between the triangles (x0, x1, x2) and (x1, x0, x3), positive where x3 lies on the side
/// that the first one's normal points to; with its derivatives by (x0, x1, x2, x3).
double hinge_fold(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3);
struct FoldDerivatives {
    double fold;
    Eigen::Matrix<double, 12, 1> gradient;  ///< [1/m]
    Eigen::Matrix<double, 12, 12> hessian;  ///< [1/m²]; left alone unless asked for
};
FoldDerivatives hinge_fold_derivatives(const Vec3& x0, const Vec3& x1, const Vec3& x2, const Vec3& x3,
                                       bool with_hessian);

class HingeEnergy final : public StageEnergy {
  public:
    /// `yield_curvature` [1/m] per patch, 0: elastic.
    HingeEnergy(const std::vector<BendingPatch>& patches, const std::vector<Mat3>& rigidity,
                std::vector<double> yield_curvature);

    /// Takes over the state's rest folds, if it has any.
    void begin(const Stage& stage) override;
    bool conservative() const override { return true; }
    /// Creases: each fold whose elastic curvature is above the yield moves its rest fold until it is not.
    void finish(State& state) const override;

    std::string_view name() const override { return "bending"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override { patches_.append_pairs(pairs); }
    void bind(const BlockPattern& pattern) override { patches_.bind(pattern); }

    /// At the start, shape (3 patches).
    static VecX rest_folds(const std::vector<BendingPatch>& patches);

  private:
    Vec3 folds(const Eigen::Matrix<double, 18, 1>& q, int k) const;

    Elements<6> patches_;
    std::vector<Mat3> stiffness_;           ///< fold_stiffness()
    std::vector<Vec3> curvature_per_fold_;  ///< 2/(h_t + h_n) [1/m]; 0 at the rim
    std::vector<double> yield_;
    VecX rest_folds_;  ///< shape (3 patches)
};

/// Viscous bending: moment = τ · rigidity · rate of curvature, the rate measured along the triangle's normal
/// at the stage's base: a quadratic potential, without force under small rigid motion.
class BendingViscosity final : public StageEnergy {
  public:
    /// `rigidity` times τ per patch [N m s].
    BendingViscosity(const std::vector<BendingPatch>& patches, const std::vector<Mat3>& rigidity);

    void begin(const Stage& stage) override;
    std::string_view name() const override { return "bending viscosity"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    bool constant_hessian() const override { return true; }
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override { patches_.append_pairs(pairs); }
    void bind(const BlockPattern& pattern) override { patches_.bind(pattern); }

  private:
    Elements<6> patches_;
    std::vector<Eigen::Matrix<double, 6, 6>> viscosity_;  ///< [N s/m]
    std::vector<Vec3> normals_;                           ///< at the base
    VecX base_;
    double h_ = 1.0;
};

/// How far a fabric stands out before its weight bends it, (D / (ρ g))^(1/3) [m], with D the mean over all
/// directions: a quarter each of warp and weft, a half of bias.
double bending_length(const Fabric& fabric);

}  // namespace cloth
