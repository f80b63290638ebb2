#pragma once
// Contact that cannot fail: a barrier between all vertex-face and edge-edge pairs of cloth with itself, with
// other cloth and with colliders, and Coulomb friction (Li et al. 2020, Incremental potential contact; Li et
// al. 2021, Codimensional incremental potential contact).
//
//   gap           g = d - t; d: distance of the pair's simplices, t: sum of both sides' radii (half of a
//                 cloth's contact thickness, a collider's radius or offset)
//   barrier       E = m κ B(g), B = y³/(1-y), y = 1 - g/ĝ for 0 < g < ĝ; 0 beyond, infinite at g ≤ 0
//                 dE/dg = -m κ/ĝ · y²(3-2y)/(1-y)²; twice differentiable at ĝ; a quotient, so that its last
//                 bit is the same everywhere, where a logarithm's is not
//   stiffness     κ = m_p ĝ (|gravity| + ĝ/dt²), m_p: the lighter side's mean vertex mass: a vertex rests at
//                 its own weight between ĝ/2 and ĝ, and the stiffness there is of the order of m_p/dt²
//   edges         m = (2 - c/c₀) c/c₀ where c = |e₁ x e₂|² < c₀ = 10⁻³ |ē₁|²|ē₂|², else 1: between parallel
//                 edges d has a kink, so they leave the work to the vertices at their ends
//   curvature     with w the weights of collide.h, u_k the changes of w that shift the nearest points by unit
//                 tangents t_k, n = d/|d|:
//                   ∇²d = 1/d [w wᵀ ⊗ (1 - nnᵀ) - Σ_k (d u_k⊗n + w⊗t_k)(d u_k⊗n + w⊗t_k)ᵀ]
//                 Projection: E'' ∇d ∇dᵀ stays; of -E' [d aaᵀ + acᵀ + caᵀ], a = u_k⊗n, c = w⊗t_k, a rank-two
//                 form for each k, its one positive eigenvalue stays; the rest of ∇²d, times E' < 0, is
//                 negative. Mollified pairs are projected by their eigenvalues.
//   friction      D = Σ μ f φ(|u|), f = -dE/dg, weights and normal those of the stage's start, u: tangential
//                 way of the two sides against each other during the stage; φ(u) = u²/ε - u³/(3ε²) below the
//                 way ε = sliding_speed · h, u - ε/3 above: static below, full force above. μ: geometric
//                 mean of both sides' coefficients.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/contact/broad_phase.h"
#include "sim/energies/energy.h"
#include "sim/geometry/collide.h"
#include "sim/motion/placement.h"

namespace cloth {

/// Everything that can touch. Constant in a run.
struct ContactSystem {
    /// A half-space; cloth vertices stay `radius` plus their own radius above it.
    struct Plane {
        int collider = 0;
        Vec3 point = Vec3::Zero(), normal = Vec3::UnitY();  ///< at the start
        double radius = 0.0, friction = 0.0;
    };
    ContactMesh mesh;              ///< cloth first
    int cloth_vertices = 0;        ///< n; the extended positions have those of colliders behind them
    VecX rest;                     ///< cloth: rest shape; colliders: as placed at the start, shape (3N) [m]
    std::vector<double> mass;      ///< of cloth vertices, shape (n) [kg]
    std::vector<double> friction;  ///< Coulomb coefficient, one per body
    std::vector<Plane> planes;
    double activation = 1e-3;     ///< ĝ [m]
    double sliding_speed = 1e-5;  ///< [m/s]
    double acceleration = 10.0;   ///< |gravity| + ĝ/dt² [m/s²]
};

/// Blocks outside the fixed pattern, (i, j) with i < j, ascending.
struct ExtraBlocks {
    std::vector<std::array<int, 2>> where;
    std::vector<Mat3> blocks;

    /// y += A x for these blocks and their transposes.
    void add_product(const VecX& x, VecX& y) const;
};

struct Overlap {
    std::array<int, 2> faces{-1, -1};            ///< two triangles that cross, in ContactMesh numbers; or
    std::array<int, 4> points{-1, -1, -1, -1};   ///< a pair nearer than its thickness; a plane: one vertex
    double gap = 0.0;                            ///< [m]
    int body_a = -1, body_b = -1;                ///< body_b = -1 - p: plane p
    std::vector<std::array<Vec3, 3>> corners{};  ///< of `faces`, as they stand [m]
};

class BarrierContact final : public Energy {
  public:
    explicit BarrierContact(ContactSystem system);

    const ContactSystem& system() const { return system_; }

    /// Starts a stage: colliders move from `from` to `to` (one per scene collider), `on` says which are
    /// there. Friction's weights and forces are those at `x` with the colliders at `from`; ways count from
    /// `slide_from`. The colliders stand at `from` until place() has moved them.
    void begin(const VecX& x, const VecX& slide_from, double h, const std::vector<Placement>& from,
               const std::vector<Placement>& to, const std::vector<std::uint8_t>& on);

    /// Whether the colliders have reached the stage's end.
    bool placed() const { return way_left_ == 0.0; }
    /// Moves colliders by `share` of what is left of their way.
    void place(double share);
    /// Adds minus the forces' change, to first order, as the colliders go the rest of their way [N].
    void add_placing_gradient(const VecX& x, VecX& g) const;
    /// The share of d, and of the colliders' remaining way together with it, that is free for certain.
    double largest_share_placing(const VecX& x, const VecX& d) const;

    /// The way d with each vertex stopped where its own pairs come near, so that x + result is allowed. For
    /// first guesses only: it is no direction of descent.
    VecX truncated(const VecX& x, const VecX& d) const;

    std::string_view name() const override { return "barrier contact"; }
    double value(const VecX& x) const override;
    void add_gradient(const VecX& x, VecX& g) const override;
    void add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const override;
    /// The same with what the pattern cannot take of the blocks that couple two sides in `extra`, which is
    /// overwritten; what H gets of the projected Hessian is positive semi-definite by itself. `slides`: that
    /// of friction, which is nowhere indefinite. Projected, it keeps a fifth of the secant's stiffness along
    /// the slide: with none, as the exact one has it, long Newton steps turn slides around, and again.
    void add_hessian(const VecX& x, HessianKind kind, HessianKind slides, BlockMatrix& H,
                     ExtraBlocks& extra) const;
    void append_pairs(std::vector<std::array<int, 2>>& pairs) const override;
    void bind(const BlockPattern& pattern) override { pattern_ = &pattern; }
    double largest_share(const VecX& x, const VecX& d) const;

    int contact_count(const VecX& x) const;
    int candidate_count() const { return static_cast<int>(candidates_.size()); }
    int detections() const { return detections_; }
    /// Smallest gap among pairs nearer than the activation distance; `activation` where there is none [m].
    double smallest_gap(const VecX& x) const;
    /// Pairs nearer than their thickness, and triangles that cross, at x; at most `most`.
    std::vector<Overlap> overlaps(const VecX& x, std::size_t most) const;

  private:
    struct Candidate {
        PairKind kind;
        std::array<int, 4> points;
        double offset, activation, stiffness, mollifier, friction;  ///< t, ĝ, κ, c₀, μ
    };
    struct Contact {
        std::array<int, 4> points;  ///< -1: none
        Nearest nearest;
        Vec3 normal;
        double distance, gap, activation, stiffness, mollifier, friction;
        bool flat = false;  ///< a plane: d is linear
        bool edges = false;
        int collider = -1;
    };
    struct Friction {
        std::array<int, 4> points;
        std::array<double, 4> weights;
        Vec3 normal, start;  ///< start: Σ w x of the cloth's points, and the collider's way, at u = 0
        double force;        ///< μ f [N]
        int split;           ///< points before this one are side A's
    };
    using Vec12 = Eigen::Matrix<double, 12, 1>;
    using Mat12 = Eigen::Matrix<double, 12, 12>;

    Vec3 point(const VecX& x, int v) const {
        if (v < system_.cloth_vertices) return x.segment<3>(3 * v);
        return colliders_.segment<3>(3 * (v - system_.cloth_vertices));
    }
    void detect() const;
    /// Makes candidates_ hold every pair that may come within its activation distance of the thickness on the
    /// straight ways from x to x + d.
    void cover(const VecX& x, const VecX& d, bool colliders_move) const;
    const std::vector<Contact>& contacts(const VecX& x) const;
    Candidate make_candidate(const PairCandidate& pair) const;
    static Vec12 contact_gradient(const Contact& c, const FourPoints& x);
    static Mat12 contact_hessian(const Contact& c, const FourPoints& x, HessianKind kind);
    FourPoints gather(const VecX& x, const std::array<int, 4>& points) const;
    template <class F>
    double search_share(const VecX& x, const VecX& d, bool colliders_move, const F& pair) const;
    double plane_share(const VecX& x, const VecX& d, bool colliders_move) const;

    ContactSystem system_;
    mutable BroadPhase broad_phase_;
    std::vector<int> collider_of_body_;  ///< -1: cloth
    std::vector<Placement> from_, to_;
    std::vector<std::uint8_t> on_, body_on_;
    VecX colliders_, collider_target_;  ///< shape (3 (N-n))
    std::vector<Vec3> plane_points_, plane_normals_, plane_point_targets_, plane_normal_targets_;
    double way_left_ = 0.0;
    double sliding_way_ = 0.0;
    std::vector<Friction> friction_;
    const BlockPattern* pattern_ = nullptr;

    // What was found last; results do not depend on it, only their cost does.
    mutable std::vector<Candidate> candidates_;
    mutable VecX covered_from_, covered_way_;  ///< of all points, shape (3N)
    mutable bool covered_ = false;
    mutable VecX contacts_at_;
    mutable bool contacts_known_ = false;
    mutable std::vector<Contact> contacts_;
    mutable std::vector<Mat12> contact_hessians_;  ///< memory of add_hessian()
    mutable int detections_ = 0;
};

}  // namespace cloth
