#include "sim/stepping/obstacle.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/contact/contact_set.h"
#include "sim/energies/membrane.h"
#include "sim/model.h"
#include "sim/scene/schema.h"
#include "sim/shapes/shapes.h"

namespace cloth {
namespace {

/// The cloth that vertex or triangle `i` of all belongs to.
int cloth_of(const Model& model, int i, int ClothRange::*first) {
    int cloth = 0;
    while (cloth + 1 < static_cast<int>(model.cloths.size()) && model.cloths[cloth + 1].*first <= i) ++cloth;
    return cloth;
}

// ---------------------------------------------------------------- strain limits

/// The triangle nearest its limit, or farthest beyond it; `share` of the way there from rest.
std::optional<Obstacle> nearest_its_limit(const Model& model, const VecX& x, double share) {
    std::optional<Obstacle> found;
    double most = share;
    for (int t = 0; t < model.triangle_count(); ++t) {
        const int cloth = cloth_of(model, t, &ClothRange::first_triangle);
        const auto& limit = model.scene.cloths[cloth].fabric.strain_limit;
        if (!limit) continue;
        Vec9 q;
        for (int k = 0; k < 3; ++k) q.segment<3>(3 * k) = x.segment<3>(3 * model.triangles(t, k));
        const double stretch = membrane_stretch(model.triangle_rest[t], q);
        const double part = (stretch - 1.0) / (*limit - 1.0);
        if (!(part > most)) continue;
        most = part;
        found.emplace();
        found->kind = Obstacle::Kind::strain_limit;
        found->cloth = cloth;
        found->element = t - model.cloths[cloth].first_triangle;
        found->place = q.reshaped(3, 3).rowwise().mean();
        found->stretch = stretch;
        found->limit = *limit;
    }
    return found;
}

// ---------------------------------------------------------------- contact

/// From where contact with a collider begins to p, with the collider at the stage's end, and the way out
/// there.
SurfacePoint surface_at_end(const Model& model, const ContactSet& set, int collider, const Vec3& p) {
    const ColliderDesc& desc = model.scene.colliders[collider];
    const Placement& end = set.colliders().target(collider);
    const Vec3 at_rest = end.rotation.transpose() * (p - end.translation);
    const double offset = desc.contact_radius ? *desc.contact_radius - desc.radius : desc.contact_offset;
    const SurfacePoint found = make_shape(desc, end)->distance(at_rest);
    return {found.distance - offset, end.rotation * found.normal};
}

/// Between two colliders at the stage's end: least within `reach` of p, as projections on one and the other
/// find it.
double room_between(const Model& model, const ContactSet& set, int a, int b, const Vec3& p, double reach) {
    const double here = surface_at_end(model, set, a, p).distance + surface_at_end(model, set, b, p).distance;
    Vec3 between = p;
    for (int k = 0; k < 50; ++k) {
        for (int collider : {a, b}) {
            const SurfacePoint at = surface_at_end(model, set, collider, between);
            between -= at.distance * at.normal;
        }
        if (!((between - p).norm() < reach)) return here;
    }
    return std::min(here, surface_at_end(model, set, a, between).distance);
}

/// The longest edge at a vertex of all [m].
double longest_edge(const Model& model, const VecX& x, int vertex) {
    double longest = 0.0;
    for (int t = 0; t < model.triangle_count(); ++t) {
        if (!(model.triangles.row(t).array() == vertex).any()) continue;
        for (int k = 0; k < 3; ++k) {
            const Vec3 edge = x.segment<3>(3 * model.triangles(t, k)) - x.segment<3>(3 * vertex);
            longest = std::max(longest, edge.norm());
        }
    }
    return longest;
}

/// A contact with a collider: out of that towards the cloth.
Vec3 outward(const ContactSet& set, const Contact& c) {
    return set.system().is_cloth(c.points[0]) ? c.normal : Vec3(-c.normal);
}

/// The cloth's vertex that has most of the contact; -1: no cloth on that side.
int cloth_vertex(const ContactSet& set, const Contact& c, int from, int to) {
    int vertex = -1;
    double most = -1.0;
    for (int i = from; i < to; ++i) {
        const int v = c.points[i];
        if (v < 0 || !set.system().is_cloth(v) || !(std::abs(c.nearest.weights[i]) > most)) continue;
        most = std::abs(c.nearest.weights[i]);
        vertex = v;
    }
    return vertex;
}

class TightestContact {
  public:
    TightestContact(const Model& model, const ContactSet& set, const std::vector<Pin>& pins, const VecX& x)
        : model_(model), set_(set), pins_(pins), x_(x), contacts_(set.contacts(x, memory_)) {}

    std::optional<Obstacle> find() const {
        const Contact* tightest = tightest_of([](const Contact&) { return true; });
        if (!tightest) return std::nullopt;
        const int v = cloth_vertex(set_, *tightest, 0, 4);
        const int cloth = cloth_of(model_, v, &ClothRange::first_vertex);
        Obstacle o;
        o.cloth = cloth;
        o.element = v - model_.cloths[cloth].first_vertex;
        o.place = x_.segment<3>(3 * v);
        o.needed = *model_.scene.cloths[cloth].contact_thickness;
        const Contact* with_collider = tightest;
        if (tightest->collider < 0) {
            const int first = cloth_vertex(set_, *tightest, 0, tightest->split());
            const int w = first == v ? cloth_vertex(set_, *tightest, tightest->split(), 4) : first;
            const int other = cloth_of(model_, w, &ClothRange::first_vertex);
            o.other = {{other, w - model_.cloths[other].first_vertex}};
            with_collider = tightest_of([&](const Contact& c) { return c.collider >= 0 && near(c, o); });
        }
        if (!with_collider) return o;
        o.colliders.push_back(with_collider->collider);
        // Another one that presses against the first.
        const Vec3 out = outward(set_, *with_collider);
        const Contact* against = tightest_of([&](const Contact& c) {
            return c.collider >= 0 && c.collider != with_collider->collider && near(c, o) &&
                   outward(set_, c).dot(out) < -0.2;
        });
        hold(o, *tightest);
        if (against) {
            o.colliders.push_back(against->collider);
            o.room = room_between(model_, set_, o.colliders[0], o.colliders[1], o.place,
                                  longest_edge(model_, x_, v));
            o.certain = o.room < o.needed;
        } else if (o.pin && !o.other) {
            o.needed *= 0.5;
            o.certain = o.room < o.needed;
        }
        return o;
    }

  private:
    template <class Wanted>
    const Contact* tightest_of(const Wanted& wanted) const {
        const Contact* found = nullptr;
        double least = 0.5;  // of the activation distance: what is farther holds nothing up
        for (const Contact& c : contacts_) {
            if (!(c.gap < least * c.activation) || !wanted(c)) continue;
            least = c.gap / c.activation;
            found = &c;
        }
        return found;
    }
    bool near(const Contact& c, const Obstacle& o) const {
        const int v = cloth_vertex(set_, c, 0, 4);
        const double reach =
            4.0 * (*model_.scene.cloths[o.cloth].contact_thickness + set_.system().activation);
        return (x_.segment<3>(3 * v) - o.place).norm() < reach;
    }
    /// Where a pin holds a vertex of the contact, the pin that the collider leaves least room is the one to
    /// name.
    void hold(Obstacle& o, const Contact& c) const {
        const auto in_contact = [&](const Pin& pin) {
            return std::find(c.points.begin(), c.points.end(), pin.vertex) != c.points.end();
        };
        if (std::none_of(pins_.begin(), pins_.end(), in_contact)) return;
        o.room = std::numeric_limits<double>::infinity();
        for (const Pin& pin : pins_) {
            const double room = surface_at_end(model_, set_, o.colliders.front(), pin.position).distance;
            if (!(room < o.room)) continue;
            o.room = room;
            o.cloth = cloth_of(model_, pin.vertex, &ClothRange::first_vertex);
            o.element = pin.vertex - model_.cloths[o.cloth].first_vertex;
            o.place = pin.position;
            o.pin = pin_of(pin.vertex);
        }
    }
    /// The first that holds the vertex, as pins_of_step() has it; -1: it is held from outside.
    int pin_of(int vertex) const {
        const auto group =
            std::find_if(model_.pin_groups.begin(), model_.pin_groups.end(), [&](const PinGroup& g) {
                return std::find(g.vertices.begin(), g.vertices.end(), vertex) != g.vertices.end();
            });
        return group == model_.pin_groups.end() ? -1 : static_cast<int>(group - model_.pin_groups.begin());
    }

    const Model& model_;
    const ContactSet& set_;
    const std::vector<Pin>& pins_;
    const VecX& x_;
    std::vector<Contact> memory_;
    const std::vector<Contact>& contacts_;
};

std::string holder(int pin) {
    return pin < 0 ? "who holds it" : "pin[" + std::to_string(pin) + "]";
}

std::string millimetres(double length) {
    return number_text(1e3 * std::round(length * 1e8) / 1e8) + " mm";
}

}  // namespace

std::optional<Obstacle> obstacle_of_placing(const Model& model, const ContactSet* contact,
                                            const std::vector<Pin>& pins, const VecX& x, const VecX* guess) {
    std::optional<Obstacle> met;
    if (contact) met = TightestContact(model, *contact, pins, x).find();
    if (guess && !(met && met->certain)) {
        auto found = nearest_its_limit(model, *guess, 1.0);
        constexpr double credible = 10.0;  // a linear guess that is farther beyond tells nothing
        if (found && found->stretch - 1.0 < credible * (found->limit - 1.0)) {
            found->asked = true;
            const int t = found->element + model.cloths[found->cloth].first_triangle;
            found->place.setZero();
            for (int k = 0; k < 3; ++k) found->place += x.segment<3>(3 * model.triangles(t, k)) / 3.0;
        } else {
            found = nearest_its_limit(model, x, 0.5);
        }
        if (found) return found;
    }
    return met;
}

std::optional<Obstacle> strain_at(const Model& model, const VecX& x) {
    return nearest_its_limit(model, x, 0.95);
}

bool same_obstacle(const Model& model, const Obstacle& a, const Obstacle& b) {
    if (a.kind == Obstacle::Kind::strain_limit) return b.kind == a.kind && b.cloth == a.cloth;
    const double near = 30.0 * *model.scene.cloths[a.cloth].contact_thickness;
    return a.kind == b.kind && a.cloth == b.cloth && a.colliders == b.colliders &&
           a.other.has_value() == b.other.has_value() && (a.place - b.place).norm() < near;
}

std::string words(const Model& model, const Obstacle& o) {
    const auto place = [&] {
        return "(" + number_text(o.place.x()) + ", " + number_text(o.place.y()) + ", " +
               number_text(o.place.z()) + ")";
    };
    const auto cloth = [&](int c) { return "cloth " + model.cloths[c].name; };
    const auto collider = [&](int c) { return "collider " + model.scene.colliders[c].name; };
    if (o.kind == Obstacle::Kind::strain_limit) {
        const bool at_it = !o.asked && o.stretch > o.limit - 1e-3 * (o.limit - 1.0);
        return "triangle " + std::to_string(o.element) + " of " + cloth(o.cloth) + " at " + place() +
               (at_it ? " is stretched to its"
                      : (o.asked ? " would be stretched to " : " is stretched to ") + number_text(o.stretch) +
                            ",") +
               " strain limit" + (at_it ? ", " : " ") + number_text(o.limit);
    }
    const std::string vertex =
        "vertex " + std::to_string(o.element) + " of " + cloth(o.cloth) + " at " + place();
    if (o.colliders.size() == 2) {
        return collider(o.colliders[0]) + " and " + collider(o.colliders[1]) + " close on " + vertex + ": " +
               millimetres(std::max(0.0, o.room)) + " between them " + (o.certain ? "would be" : "is") +
               " left there, the cloth needs " + millimetres(o.needed);
    }
    if (o.pin && o.certain) {
        return holder(*o.pin) + " and " + collider(o.colliders[0]) + " meet at " + vertex +
               ": they would be " + millimetres(o.needed - o.room) + " nearer than contact lets them";
    }
    std::string met;
    if (o.other) {
        met = " meets " + ((*o.other)[0] == o.cloth ? std::string("itself") : cloth((*o.other)[0])) +
              " at vertex " + std::to_string((*o.other)[1]);
    }
    if (!o.colliders.empty()) met += (met.empty() ? " meets " : " and ") + collider(o.colliders[0]);
    return vertex + (o.pin ? ", held by " + holder(*o.pin) + "," : "") + met;
}

}  // namespace cloth
