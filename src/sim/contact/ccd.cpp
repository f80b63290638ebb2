#include "sim/contact/ccd.h"

#include <algorithm>
#include <cmath>

#include "base/parallel.h"

namespace cloth {
namespace {

/// In activation distances: how far along a way collisions are looked for at first.
constexpr double first_piece = 3.0;
/// Share of a gap that a step must leave.
constexpr double slack = 0.2;

/// Least of find(i) ≤ 1, in parallel; a minimum has no order.
template <class F>
double least_share(int count, const F& find) {
    return parallel_reduce(count, 1.0, find, [](double a, double b) { return std::min(a, b); });
}

/// The first t > 0 with a t² + b t + c = 0, c > 0; at most 1.
double first_root(double a, double b, double c) {
    const double discriminant = b * b - 4.0 * a * c;
    if (discriminant < 0.0) return 1.0;
    const double root = std::sqrt(discriminant);
    // -b + root and -b - root over 2a, written without cancellation.
    const double q = -0.5 * (b + (b >= 0.0 ? root : -root));
    double first = 1.0;
    if (q != 0.0 && c / q > 0.0) first = std::min(first, c / q);
    if (a != 0.0 && q / a > 0.0) first = std::min(first, q / a);
    return first;
}

/// The share that is free of half-spaces.
double plane_share(const ContactSet& set, const VecX& x, const VecX& d, bool colliders_move) {
    const ContactSystem& system = set.system();
    const MovingColliders& colliders = set.colliders();
    double share = 1.0;
    for (std::size_t p = 0; p < system.planes.size(); ++p) {
        if (!colliders.on(system.planes[p].collider)) continue;
        const double radius = system.planes[p].radius;
        const Vec3 n = colliders.plane(p).normal, o = colliders.plane(p).point;
        const MovingColliders::Plane target = colliders.plane_target(p);
        const Vec3 dn = colliders_move ? Vec3(target.normal - n) : Vec3(Vec3::Zero());
        const Vec3 shift = colliders_move ? Vec3(target.point - o) : Vec3(Vec3::Zero());
        share = std::min(share, least_share(system.cloth_vertices, [&](int v) {
                             // Distance a t² + b t + c0; the normal between two unit normals is no longer
                             // than one, so that this understates it. Ends where `slack` of the gap is left.
                             const Vec3 y = x.segment<3>(3 * v) - o, dy = d.segment<3>(3 * v) - shift;
                             const double gap = n.dot(y) - (radius + system.radius_of(v));
                             if (!(gap > 0.0)) return 0.0;
                             return first_root(dn.dot(dy), n.dot(dy) + dn.dot(y), (1.0 - slack) * gap);
                         }));
    }
    return share;
}

/// The share that is free of pairs. pair(candidate, piece): share of the first `piece` of the ways that is
/// free between two sides.
template <class F>
double pair_share(ContactSet& set, const VecX& x, const VecX& d, bool colliders_move, const F& pair) {
    // Along the whole of a long way very many pairs may meet, most of them behind the first impact: look at a
    // short piece first and lengthen it while it is free.
    const Vec3 common = d.reshaped(3, d.size() / 3).rowwise().mean();
    double longest = 0.0;
    for (int v = 0; v < set.system().cloth_vertices; ++v) {
        longest = std::max(longest, (d.segment<3>(3 * v) - common).norm());
    }
    double piece = std::min(1.0, first_piece * set.system().activation / longest);
    if (colliders_move || !(longest > 0.0)) piece = 1.0;
    for (;; piece = std::min(1.0, 4.0 * piece)) {
        set.cover(x, piece * d, colliders_move);
        const std::vector<Candidate>& candidates = set.candidates().list();
        const double share = least_share(static_cast<int>(candidates.size()),
                                         [&](int i) { return pair(candidates[i], piece); });
        if (share < 1.0 || piece == 1.0) return share * piece;
    }
}

/// Of a candidate's points as cloth goes by share · d.
FourPoints motion_of(const Candidate& k, const ContactSystem& system, double share, const VecX& d) {
    FourPoints motion;
    for (int p = 0; p < 4; ++p) {
        const int v = k.points[p];
        motion[p] = system.is_cloth(v) ? Vec3(share * d.segment<3>(3 * v)) : Vec3(Vec3::Zero());
    }
    return motion;
}

}  // namespace

double largest_share(ContactSet& set, const VecX& x, const VecX& d) {
    const double share = pair_share(set, x, d, false, [&](const Candidate& k, double piece) {
        return safe_step(k.kind, set.colliders().points(x, k.points), motion_of(k, set.system(), piece, d),
                         k.offset, slack);
    });
    return std::min(share, plane_share(set, x, d, false));
}

double largest_share_placing(ContactSet& set, const VecX& x, const VecX& d) {
    const double share = pair_share(set, x, d, true, [&](const Candidate& k, double) {
        FourPoints motion;
        for (int p = 0; p < 4; ++p) {
            const int v = k.points[p];
            motion[p] = set.system().is_cloth(v) ? Vec3(d.segment<3>(3 * v)) : set.colliders().way_of(v);
        }
        return safe_step(k.kind, set.colliders().points(x, k.points), motion, k.offset, slack);
    });
    return std::min(share, plane_share(set, x, d, true));
}

VecX truncated_way(ContactSet& set, const VecX& x, const VecX& d) {
    set.cover(x, d, false);
    const ContactSystem& system = set.system();
    const MovingColliders& colliders = set.colliders();
    const std::vector<Candidate>& candidates = set.candidates().list();
    const int n = system.cloth_vertices;
    std::vector<double> shares(n, 1.0);
    VecX way = d;
    std::vector<double> found(candidates.size());
    for (int round = 0; round < 4; ++round) {
        parallel_for(static_cast<int>(candidates.size()), [&](int i) {
            const Candidate& k = candidates[i];
            const FourPoints p = colliders.points(x, k.points);
            const double gap = std::sqrt(nearest(k.kind, p).distance_squared) - k.offset;
            found[i] = safe_step(k.kind, p, motion_of(k, system, 1.0, way),
                                 k.offset + 0.5 * std::min(gap, k.activation), slack);
        });
        bool changed = false;
        for (std::size_t i = 0; i < candidates.size(); ++i) {
            if (found[i] >= 1.0) continue;
            changed = true;
            for (int v : candidates[i].points) {
                if (v < n) shares[v] = std::min(shares[v], found[i]);
            }
        }
        for (std::size_t p = 0; p < system.planes.size(); ++p) {
            if (!colliders.on(system.planes[p].collider)) continue;
            const auto& [point, normal] = colliders.plane(p);
            for (int v = 0; v < n; ++v) {
                const double gap =
                    normal.dot(x.segment<3>(3 * v) - point) - system.planes[p].radius - system.radius_of(v);
                const double closing = -normal.dot(way.segment<3>(3 * v));
                const double room = gap - 0.5 * std::min(gap, system.activation);
                if (closing > room) shares[v] = std::min(shares[v], room / closing);
            }
        }
        for (int v = 0; v < n; ++v) {
            if (shares[v] == 1.0) continue;
            way.segment<3>(3 * v) *= shares[v];
            shares[v] = 1.0;
        }
        if (!changed) break;
    }
    return largest_share(set, x, way) * way;
}

}  // namespace cloth
