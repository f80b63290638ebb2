#include "sim/contact/contact_set.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"
#include "sim/contact/mollifier.h"

namespace cloth {

ContactSet::ContactSet(ContactSystem system)
    : system_(std::move(system)), colliders_(system_), candidates_(system_) {}

void ContactSet::begin(const VecX& x, const VecX& slide_from, double h, const std::vector<Placement>& from,
                       const std::vector<Placement>& to, const std::vector<std::uint8_t>& on) {
    colliders_.begin(from, to, on);
    found_ = false;
    find(x);
    friction_.sliding_way = system_.sliding_speed * h;
    friction_.items.clear();
    for (const Contact& c : contacts_) {
        if (c.friction == 0.0) continue;
        double mollifier = 1.0;
        if (c.mollifier > 0.0) {
            mollifier = mollify(cross_squared(colliders_.points(x, c.points)), c.mollifier).value;
        }
        const double normal_force = -mollifier * barrier(c.gap, c.activation, c.stiffness).first;
        if (!(normal_force > 0.0)) continue;
        friction_.items.push_back(friction_of(c, c.friction * normal_force, x, slide_from));
    }
}

Friction ContactSet::friction_of(const Contact& c, double force, const VecX& x,
                                 const VecX& slide_from) const {
    Friction f{{-1, -1, -1, -1}, c.nearest.weights, c.normal, Vec3::Zero(), force, c.split()};
    Vec3 on_collider = Vec3::Zero();  // the nearest point of the collider's side
    double side = 0.0;
    double radius = 0.0;
    for (int i = 0; i < 4; ++i) {
        const int v = c.points[i];
        if (v < 0) continue;
        if (system_.is_cloth(v)) {
            f.points[i] = v;
            f.start += f.weights[i] * slide_from.segment<3>(3 * v);
        } else {
            side += f.weights[i];
            on_collider += f.weights[i] * colliders_.point(x, v);
            radius = system_.radius_of(v);
        }
    }
    if (c.collider < 0) return f;
    if (colliders_.bends(c.collider)) {
        // The colliders stand at the stage's start: what each vertex has left to go is all its way.
        for (int i = 0; i < 4; ++i)
            if (c.points[i] >= system_.cloth_vertices)
                f.start -= f.weights[i] * colliders_.way_of(c.points[i]);
        return f;
    }
    if (c.plane >= 0) {
        on_collider = Vec3(x.segment<3>(3 * c.points[0])) - c.distance * c.normal;
        side = -1.0;
    } else {
        on_collider = on_collider / side - (side * radius) * c.normal;
    }
    f.start -= side * colliders_.way_in_stage(c.collider, on_collider);
    return f;
}

void ContactSet::place(double share) {
    colliders_.place(share);
    found_ = false;
}

void ContactSet::find(const VecX& x) {
    if (found_ && found_at_ == x) return;
    candidates_.cover(colliders_, x, VecX::Zero(x.size()), false);
    contacts_ = contacts_among(candidates_.list(), x);
    found_at_ = x;
    found_ = true;
}

const std::vector<Contact>& ContactSet::contacts(const VecX& x, std::vector<Contact>& memory) const {
    if (found_ && found_at_ == x) return contacts_;
    const VecX nowhere = VecX::Zero(x.size());
    memory = candidates_.covers(colliders_, x, nowhere, false)
                 ? contacts_among(candidates_.list(), x)
                 : contacts_among(candidates_.find(colliders_, x, nowhere, false), x);
    return memory;
}

std::vector<Contact> ContactSet::contacts_among(const std::vector<Candidate>& candidates,
                                                const VecX& x) const {
    auto found =
        parallel_collect<Contact>(static_cast<int>(candidates.size()), [&](int i, std::vector<Contact>& out) {
            const Candidate& k = candidates[i];
            const FourPoints p = colliders_.points(x, k.points);
            const double far = k.offset + k.activation;
            if (boxes_apart(k.kind, p, far)) return;
            const Nearest n = nearest(k.kind, p);
            if (n.distance_squared >= far * far) return;
            Contact c;
            c.points = k.points;
            c.nearest = n;
            c.distance = std::sqrt(n.distance_squared);
            c.normal = c.distance > 0.0 ? Vec3(n.difference(p) / c.distance) : Vec3(Vec3::UnitY());
            c.gap = c.distance - k.offset;
            c.activation = k.activation;
            c.stiffness = k.stiffness;
            c.mollifier = k.mollifier;
            c.friction = k.friction;
            c.edges = k.kind == PairKind::edge_edge;
            for (int v : k.points) c.collider = std::max(c.collider, system_.collider_of(v));
            out.push_back(c);
        });
    for (std::size_t p = 0; p < system_.planes.size(); ++p) {
        const auto& plane = system_.planes[p];
        if (!colliders_.on(plane.collider)) continue;
        const auto& [point, normal] = colliders_.plane(p);
        const auto with_plane = parallel_collect<Contact>(
            system_.cloth_vertices, [&, &point = point, &normal = normal](int v, std::vector<Contact>& out) {
                Contact c;
                c.distance = normal.dot(x.segment<3>(3 * v) - point);
                c.gap = c.distance - plane.radius - system_.radius_of(v);
                if (c.gap >= system_.activation) return;
                c.points = {v, -1, -1, -1};
                c.nearest.weights = {1.0, 0.0, 0.0, 0.0};
                c.normal = normal;
                c.activation = system_.activation;
                c.stiffness = system_.mass[v] * system_.activation * system_.acceleration;
                c.mollifier = 0.0;
                c.friction = std::sqrt(plane.friction * system_.friction[system_.mesh.vertex_body[v]]);
                c.collider = plane.collider;
                c.plane = static_cast<int>(p);
                out.push_back(c);
            });
        found.insert(found.end(), with_plane.begin(), with_plane.end());
    }
    return found;
}

int contact_count(const ContactSet& set, const VecX& x) {
    std::vector<Contact> memory;
    return static_cast<int>(set.contacts(x, memory).size());
}

double smallest_gap(const ContactSet& set, const VecX& x) {
    std::vector<Contact> memory;
    double least = set.system().activation;
    for (const Contact& c : set.contacts(x, memory)) least = std::min(least, c.gap);
    return least;
}

}  // namespace cloth
