#pragma once
// Pairs that may come near: found along the ways of all points, kept while what is asked stays near those
// ways.

#include <array>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/contact/broad_phase.h"
#include "sim/contact/contact_system.h"
#include "sim/contact/moving_colliders.h"

namespace cloth {

/// A pair with what its contact needs (barrier.h). Stiffness κ = m_p ĝ (|gravity| + ĝ/dt²), m_p: the lighter
/// side's mean vertex mass: a vertex rests at its own weight between ĝ/2 and ĝ, and the stiffness there is of
/// the order of m_p/dt². μ: geometric mean of both sides' coefficients.
struct Candidate {
    PairKind kind;
    std::array<int, 4> points;
    double offset, activation, stiffness, mollifier, friction;  ///< t, ĝ [m], κ [J], c₀ [m⁴], μ
};

class Candidates {
  public:
    /// `system` must outlive this.
    explicit Candidates(const ContactSystem& system);

    /// Every pair that comes within its activation distance of the thickness as cloth goes straight from x by
    /// d, and others; of two lists, what both contain stands in the same order. Colliders that are on stay
    /// where they are, or go the rest of their way where `colliders_move`.
    std::vector<Candidate> find(const MovingColliders& colliders, const VecX& x, const VecX& d,
                                bool colliders_move) const;

    /// Makes list() such a list.
    void cover(const MovingColliders& colliders, const VecX& x, const VecX& d, bool colliders_move);
    /// Whether list() is one.
    bool covers(const MovingColliders& colliders, const VecX& x, const VecX& d, bool colliders_move) const;
    const std::vector<Candidate>& list() const { return list_; }

    const BroadPhase& broad_phase() const { return broad_phase_; }
    int detections() const { return detections_; }  ///< times that cover() had to search

  private:
    /// Where every point is and the straight way that it goes, shape (3N) each [m].
    struct Ways {
        VecX from, way;
    };
    Ways ways_of(const MovingColliders& colliders, const VecX& x, const VecX& d, bool colliders_move) const;
    std::vector<Candidate> find(const Ways& ways, const MovingColliders& colliders) const;
    bool covers(const Ways& ways, const MovingColliders& colliders) const;
    Candidate make(const PairCandidate& pair) const;

    const ContactSystem& system_;
    BroadPhase broad_phase_;
    std::vector<Candidate> list_;
    Ways covered_;                  ///< that the list was found for; empty: none
    std::vector<std::uint8_t> on_;  ///< colliders that were
    int detections_ = 0;
};

}  // namespace cloth
