#include "sim/contact/candidates.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/parallel.h"
#include "sim/contact/mollifier.h"

namespace cloth {
namespace {

/// In activation distances: how far from the ways that they were found for candidates hold, along each axis.
constexpr double margin_factor = 1.0;

}  // namespace

Candidates::Candidates(const ContactSystem& system)
    : system_(system), broad_phase_(system.mesh, system.rest) {}

Candidates::Ways Candidates::ways_of(const MovingColliders& colliders, const VecX& x, const VecX& d,
                                     bool colliders_move) const {
    const int n = system_.cloth_vertices, count = system_.mesh.vertex_count();
    Ways ways{VecX(3 * count), VecX(3 * count)};
    ways.from << x, colliders.positions();
    ways.way.head(3 * n) = d;
    if (colliders_move) {
        ways.way.tail(3 * (count - n)) = colliders.way();
    } else {
        ways.way.tail(3 * (count - n)).setZero();
    }
    return ways;
}

Candidate Candidates::make(const PairCandidate& pair) const {
    const auto& mesh = system_.mesh;
    Candidate c{pair.kind, pair_points(mesh, pair), 0.0, system_.activation, 0.0, 0.0, 0.0};
    const int split = pair.kind == PairKind::vertex_face ? 1 : 2;
    const int a = mesh.vertex_body[c.points[0]], b = mesh.vertex_body[c.points[split]];
    c.offset = mesh.bodies[a].radius + mesh.bodies[b].radius;
    c.friction = std::sqrt(system_.friction[a] * system_.friction[b]);
    double mass[2] = {0.0, 0.0};
    for (int i = 0; i < 4; ++i) {
        const int v = c.points[i];
        mass[i < split ? 0 : 1] +=
            system_.is_cloth(v) ? system_.mass[v] : std::numeric_limits<double>::infinity();
    }
    mass[0] /= split;
    mass[1] /= 4 - split;
    FourPoints rest;
    for (int i = 0; i < 4; ++i) rest[i] = system_.rest.segment<3>(3 * c.points[i]);
    // Whether neighbours in the rest shape may be near: a bound first, for most are not.
    const double spans =
        (rest[split] - rest[0]).norm() - (split == 2 ? (rest[1] - rest[0]).norm() : 0.0) -
        std::max((rest[3] - rest[split]).norm(), split == 1 ? (rest[2] - rest[1]).norm() : 0.0);
    const bool one_piece = a == b && mesh.vertex_piece[c.points[0]] == mesh.vertex_piece[c.points[split]];
    if (one_piece && spans < 4.0 * c.offset + 2.0 * c.activation) {
        // Neighbours in a fine mesh stand nearer than the thickness at rest; they meet where that is halved.
        // What is at one place at rest is no neighbour (patterns cut from one sheet, a seam not joined): it
        // keeps all.
        const double apart = std::sqrt(nearest(pair.kind, rest).distance_squared);
        if (apart > 1e-5 * (rest[3] - rest[split]).norm()) {
            c.offset = std::min(c.offset, 0.25 * apart);
            c.activation = std::min(c.activation, 0.5 * apart);
        }
    }
    c.stiffness = std::min(mass[0], mass[1]) * c.activation * system_.acceleration;
    if (pair.kind == PairKind::edge_edge) c.mollifier = mollifier_threshold(rest);
    return c;
}

std::vector<Candidate> Candidates::find(const Ways& ways, const MovingColliders& colliders) const {
    const auto& mesh = system_.mesh;
    const double margin = margin_factor * system_.activation;
    auto start = [&](int v) { return Vec3(ways.from.segment<3>(3 * v)); };
    auto way = [&](int v) { return Vec3(ways.way.segment<3>(3 * v)); };
    std::vector<MovingBox> boxes(mesh.vertex_count());
    parallel_for(mesh.vertex_count(), [&](int v) {
        boxes[v] =
            MovingBox(start(v), start(v) + way(v), margin + system_.radius_of(v) + 0.5 * system_.activation);
    });
    const std::vector<PairCandidate> boxed = broad_phase_.pairs(mesh, boxes, colliders.body_on());
    return parallel_collect<Candidate>(static_cast<int>(boxed.size()), [&](int i,
                                                                           std::vector<Candidate>& out) {
        const auto points = pair_points(mesh, boxed[i]);
        const bool face = boxed[i].kind == PairKind::vertex_face;
        FourPoints x;
        Vec3 mean = Vec3::Zero();
        for (int j = 0; j < 4; ++j) {
            x[j] = start(points[j]);
            mean += 0.25 * way(points[j]);
        }
        std::array<double, 4> ways_off;
        for (int j = 0; j < 4; ++j) ways_off[j] = (way(points[j]) - mean).norm();
        const double closing = face ? ways_off[0] + std::max({ways_off[1], ways_off[2], ways_off[3]})
                                    : std::max(ways_off[0], ways_off[1]) + std::max(ways_off[2], ways_off[3]);
        const double far = closing + 2.0 * 1.7321 * margin + system_.activation +
                           system_.radius_of(points[0]) + system_.radius_of(points[face ? 1 : 2]);
        if (boxes_apart(boxed[i].kind, x, far)) return;
        if (nearest(boxed[i].kind, x).distance_squared <= far * far) out.push_back(make(boxed[i]));
    });
}

bool Candidates::covers(const Ways& ways, const MovingColliders& colliders) const {
    if (covered_.from.size() == 0 || on_ != colliders.on()) return false;
    const int n = system_.cloth_vertices;
    // The same share of the covered ways for all points, and what each is off it.
    const double length_squared = covered_.way.head(3 * n).squaredNorm();
    auto off = [&](const VecX& p) {
        const VecX moved = p - covered_.from;
        double share = 0.0;
        if (length_squared > 0.0) {
            share = std::clamp(moved.head(3 * n).dot(covered_.way.head(3 * n)) / length_squared, 0.0, 1.0);
        }
        return (moved - share * covered_.way).cwiseAbs().maxCoeff();
    };
    const double margin = margin_factor * system_.activation;
    return off(ways.from) <= margin && off(ways.from + ways.way) <= margin;
}

std::vector<Candidate> Candidates::find(const MovingColliders& colliders, const VecX& x, const VecX& d,
                                        bool colliders_move) const {
    return find(ways_of(colliders, x, d, colliders_move), colliders);
}

bool Candidates::covers(const MovingColliders& colliders, const VecX& x, const VecX& d,
                        bool colliders_move) const {
    return covers(ways_of(colliders, x, d, colliders_move), colliders);
}

void Candidates::cover(const MovingColliders& colliders, const VecX& x, const VecX& d, bool colliders_move) {
    Ways ways = ways_of(colliders, x, d, colliders_move);
    if (covers(ways, colliders)) return;
    ++detections_;
    list_ = find(ways, colliders);
    covered_ = std::move(ways);
    on_ = colliders.on();
}

}  // namespace cloth
