#pragma once
// What barrier contact knows of a stage: where colliders are, what may touch, what does, how it slides.
// Energy (barrier_contact.h), free ways (ccd.h) and overlaps (overlap.h) are told from it.
//
// What is not const looks around and remembers what it found; what is const changes nothing, so that threads
// may share it. What was found last decides how long an answer takes, not what it is.

#include <cstdint>
#include <vector>

#include "sim/contact/barrier.h"
#include "sim/contact/candidates.h"
#include "sim/contact/friction.h"
#include "sim/contact/moving_colliders.h"

namespace cloth {

class ContactSet {
  public:
    explicit ContactSet(ContactSystem system);
    ContactSet(const ContactSet&) = delete;

    /// Starts a stage of h seconds: colliders move from `from` to `to` (one per scene collider), `on` says
    /// which are there. Friction's weights and forces are those at `x` with the colliders at `from`; ways
    /// count from `slide_from`. The colliders stand at `from` until place() has moved them.
    void begin(const VecX& x, const VecX& slide_from, double h, const std::vector<Placement>& from,
               const std::vector<Placement>& to, const std::vector<std::uint8_t>& on);
    /// Whether the colliders have reached the stage's end.
    bool placed() const { return colliders_.placed(); }
    /// Moves colliders by `share` of what is left of their way.
    void place(double share);

    /// Finds the contacts at x.
    void find(const VecX& x);
    /// Finds the candidates for the way from x by d (candidates.h).
    void cover(const VecX& x, const VecX& d, bool colliders_move) {
        candidates_.cover(colliders_, x, d, colliders_move);
    }

    const ContactSystem& system() const { return system_; }
    const MovingColliders& colliders() const { return colliders_; }
    const Candidates& candidates() const { return candidates_; }
    const FrictionList& friction() const { return friction_; }
    /// Contacts at x: of vertices and edges in the order of the candidates, then with half-spaces. Those that
    /// find() found, if it was asked for the same x last; else found anew and left in `memory`.
    const std::vector<Contact>& contacts(const VecX& x, std::vector<Contact>& memory) const;

  private:
    std::vector<Contact> contacts_among(const std::vector<Candidate>& candidates, const VecX& x) const;
    Friction friction_of(const Contact& c, double force, const VecX& x, const VecX& slide_from) const;

    const ContactSystem system_;
    MovingColliders colliders_;
    Candidates candidates_;
    FrictionList friction_;
    bool found_ = false;
    VecX found_at_;
    std::vector<Contact> contacts_;  ///< at found_at_
};

/// Pairs repelled at x.
int contact_count(const ContactSet& set, const VecX& x);
/// Smallest gap among them; the activation distance where there is none [m].
double smallest_gap(const ContactSet& set, const VecX& x);

}  // namespace cloth
