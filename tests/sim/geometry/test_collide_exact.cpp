// Distances and times of impact against exact rational arithmetic, on degenerate pairs above all: parallel
// edges, coplanar and collinear points, vertices on edges and corners, collapsed sides, no motion, grazes.

#include <gmpxx.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

#include <catch2/catch.hpp>

#include "sim/geometry/collide.h"

using namespace cloth;

namespace {

using Rational = mpq_class;
using Exact3 = std::array<Rational, 3>;
using ExactPoints = std::array<Exact3, 4>;

Exact3 exact(const Vec3& p) {
    return {Rational(p.x()), Rational(p.y()), Rational(p.z())};
}

ExactPoints exact(const FourPoints& x) {
    return {exact(x[0]), exact(x[1]), exact(x[2]), exact(x[3])};
}

Exact3 operator-(const Exact3& a, const Exact3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

Rational dot(const Exact3& a, const Exact3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

Exact3 cross(const Exact3& a, const Exact3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

/// Squared distance of p from the segment a … b.
Rational segment_distance(const Exact3& p, const Exact3& a, const Exact3& b) {
    const Exact3 e = b - a, r = p - a;
    const Rational along = dot(e, r), length = dot(e, e);
    if (along <= 0) return dot(r, r);
    if (along >= length) return dot(p - b, p - b);
    return dot(r, r) - along * along / length;
}

/// Squared distance of a pair: of the two planes' or lines' common perpendicular where it meets both insides,
/// else the least of the boundary's.
Rational distance_squared(PairKind kind, const ExactPoints& x) {
    const bool face = kind == PairKind::vertex_face;
    const Exact3 e1 = face ? x[2] - x[1] : x[1] - x[0], e2 = face ? x[3] - x[1] : x[3] - x[2];
    const Exact3 r = face ? x[0] - x[1] : x[2] - x[0], normal = cross(e1, e2);
    const Rational size = dot(normal, normal);
    if (size > 0) {
        const Rational s = dot(cross(r, e2), normal),
                       t = face ? dot(cross(e1, r), normal) : dot(cross(r, e1), normal);
        const bool inside = s >= 0 && t >= 0 && (face ? Rational(s + t) <= size : s <= size && t <= size);
        if (inside) {
            const Rational height = dot(r, normal);
            return height * height / size;
        }
    }
    if (face) {
        return std::min({segment_distance(x[0], x[1], x[2]), segment_distance(x[0], x[2], x[3]),
                         segment_distance(x[0], x[3], x[1])});
    }
    return std::min({segment_distance(x[0], x[2], x[3]), segment_distance(x[1], x[2], x[3]),
                     segment_distance(x[2], x[0], x[1]), segment_distance(x[3], x[0], x[1])});
}

/// Points with coordinates of few digits, so that what looks degenerate is so exactly, and sums are exact.
struct Pairs {
    std::mt19937 random;
    Vec3 point() {
        auto digit = [&] { return (static_cast<int>(random() % 17) - 8) / 8.0; };
        const double x = digit(), y = digit();
        return {x, y, digit()};
    }
    double share() { return static_cast<double>(random() % 5) / 4.0; }

    static constexpr int kinds = 12;
    FourPoints any(int kind) {
        FourPoints x{point(), point(), point(), point()};
        std::uniform_real_distribution<double> uniform(-1.0, 1.0);
        auto rough = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
        switch (kind) {
            case 0:  // no two points of simple numbers
                for (Vec3& p : x) p = rough();
                break;
            case 1:  // parallel edges
                x[3] = x[2] + (share() - 0.5) * (x[1] - x[0]);
                break;
            case 2:  // nearly parallel
                x[3] = x[2] + (share() - 0.5) * (x[1] - x[0]) +
                       std::ldexp(1.0, -20 - static_cast<int>(random() % 30)) * rough();
                break;
            case 3:  // coplanar
                for (Vec3& p : x) p.z() = 0.25;
                break;
            case 4:  // the last two coincide
                x[3] = x[2];
                break;
            case 5:  // three coincide
                x[3] = x[2] = x[1];
                break;
            case 6:  // a corner of either side at one place
                x[0] = x[1 + random() % 3];
                break;
            case 7:  // the first on an edge, or on its line, of the others
                x[0] = x[2] + (2.0 * share() - 0.5) * (x[3] - x[2]);
                break;
            case 8:  // the first in the face of the others
                x[0] = x[1] + 0.5 * share() * (x[2] - x[1]) + 0.5 * share() * (x[3] - x[1]);
                break;
            case 9:  // collinear
                for (int i = 1; i < 4; ++i) x[i] = x[0] + (2.0 * share() - 1.0) * Vec3(1.0, 2.0, 3.0);
                break;
            case 10:  // a needle
                x[3] = 0.5 * (x[1] + x[2]) + std::ldexp(1.0, -20 - static_cast<int>(random() % 30)) * rough();
                break;
            default:
                break;
        }
        return x;
    }
};

/// A rational not less than the root of the sum of squares.
Rational length_above(const Exact3& v) {
    const double length = std::sqrt(dot(v, v).get_d());
    return Rational(length) * (1 + Rational(1, 1 << 30));
}

/// Whether the pair stays farther apart than `separation` during all of x + t v, 0 ≤ t ≤ end: proved piece by
/// piece. Within w of the time t no distance falls below d(t) - w l, where l bounds the closing speed from
/// above.
bool stays_apart(PairKind kind, const ExactPoints& x, const ExactPoints& v, const Rational& separation,
                 const Rational& end) {
    const int split = kind == PairKind::vertex_face ? 1 : 2;
    // Motion in common with the last point changes no distance.
    std::array<Rational, 2> speeds{0, 0};
    for (int i = 0; i < 4; ++i) speeds[i >= split] = std::max(speeds[i >= split], length_above(v[i] - v[3]));
    const Rational closing = speeds[0] + speeds[1];
    std::vector<std::array<Rational, 2>> open{{0, end}};
    const Rational finest = end / Rational(mpz_class(1) << 60);
    while (!open.empty()) {
        const auto [from, to] = open.back();
        open.pop_back();
        const Rational middle = (from + to) / 2, least = separation + closing * (to - from) / 2;
        ExactPoints y;
        for (int i = 0; i < 4; ++i) {
            for (int a = 0; a < 3; ++a) y[i][a] = x[i][a] + middle * v[i][a];
        }
        const Rational d = distance_squared(kind, y);
        if (d > least * least) continue;
        if (d <= separation * separation || to - from < finest) return false;
        open.push_back({from, middle});
        open.push_back({middle, to});
    }
    return true;
}

}  // namespace

TEST_CASE("distances are exact to a few units of roundoff of the coordinates, degenerate or not",
          "[collide]") {
    Pairs pairs{std::mt19937(1)};
    int touching = 0;
    for (int k = 0; k < 24000; ++k) {
        FourPoints x = pairs.any(k % Pairs::kinds);
        if (k % 5 == 0) {
            for (Vec3& p : x) p += Vec3(1000.0, -3.0, 0.25);
        }
        double size = 0.0;
        for (const Vec3& p : x) size = std::max(size, p.cwiseAbs().maxCoeff());
        for (PairKind kind : {PairKind::vertex_face, PairKind::edge_edge}) {
            const double found = nearest(kind, x).distance_squared;
            mpf_class expected(distance_squared(kind, exact(x)), 256);
            touching += expected == 0;
            expected = sqrt(expected);
            const mpf_class error = abs(sqrt(mpf_class(found, 256)) - expected);
            CAPTURE(k % Pairs::kinds, kind == PairKind::edge_edge, expected.get_d());
            REQUIRE(error.get_d() <= 6.0 * 0x1p-53 * size);
            // Powers of two change no digit.
            for (const int power : {-100, 100}) {
                FourPoints scaled = x;
                for (Vec3& p : scaled) p *= std::ldexp(1.0, power);
                REQUIRE(nearest(kind, scaled).distance_squared == std::ldexp(found, 2 * power));
            }
        }
    }
    CHECK(touching > 1000);
}

TEST_CASE("a step that is called free is free in exact arithmetic", "[collide]") {
    Pairs pairs{std::mt19937(2)};
    int cut_short = 0, whole = 0, none = 0;
    for (int k = 0; k < 12 * 12 * 14; ++k) {
        FourPoints x = pairs.any(k % Pairs::kinds), v;
        const int way = k / Pairs::kinds % 6, exponent = (k % 7 - 3) * 12;
        const FourPoints there = pairs.any(k / 29 % Pairs::kinds);
        const double time = 1.0 / static_cast<double>(1 << (1 + k % 5));
        for (int i = 0; i < 4; ++i) {
            // Anywhere; to touch, or graze, at a time that is exact; in one plane; not at all; slowly; at
            // great speed.
            const Vec3 on_the_way = x[i] - there[i];
            v[i] = way == 0   ? there[i]
                   : way == 1 ? Vec3(-on_the_way / time)
                   : way == 2 ? Vec3(there[i].x(), there[i].y(), 0.0)
                   : way == 3 ? (i == 0 ? Vec3(there[0]) : Vec3::Zero())
                   : way == 4 ? Vec3(0x1p-30 * there[i])
                              : Vec3(0x1p12 * there[i]);
            x[i] *= std::ldexp(1.0, exponent);
            v[i] *= std::ldexp(1.0, exponent);
        }
        const double separation = k % 3 == 0 ? std::ldexp(1.0, exponent - 10) : 0.0;
        for (PairKind kind : {PairKind::vertex_face, PairKind::edge_edge}) {
            CAPTURE(k, way, exponent, kind == PairKind::edge_edge);
            const double t = safe_step(kind, x, v, separation);
            REQUIRE((t >= 0.0 && t <= 1.0));
            const ExactPoints y = exact(x);
            const Rational limit = separation, start = distance_squared(kind, y);
            if (start <= limit * limit) REQUIRE(t == 0.0);
            (t == 0.0 ? none : t < 1.0 ? cut_short : whole)++;
            if (t == 0.0) continue;
            CAPTURE(t, start.get_d());
            REQUIRE(stays_apart(kind, y, exact(v), limit, t));
            // Standing still, or all moving as one, nothing meets.
            REQUIRE(safe_step(kind, x, {Vec3::Zero(), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()},
                              separation) == 1.0);
            REQUIRE(safe_step(kind, x, {v[0], v[0], v[0], v[0]}, separation) == 1.0);
        }
    }
    CHECK(cut_short > 300);
    CHECK(whole > 300);
    CHECK(none > 300);
}

TEST_CASE("the proof of a free way fails where there is an impact", "[collide]") {
    // A vertex meets the corner of a face at t = 3/4, coming along the face's plane; an edge grazes a
    // parallel one.
    const FourPoints x{Vec3(-3, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)};
    const FourPoints v{Vec3(4, 0, 0), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    CHECK(stays_apart(PairKind::vertex_face, exact(x), exact(v), 0, Rational(3, 4) - Rational(1, 1000)));
    CHECK_FALSE(stays_apart(PairKind::vertex_face, exact(x), exact(v), 0, Rational(3, 4)));
    CHECK(safe_step(PairKind::vertex_face, x, v, 0.0) < 0.75);
    const FourPoints e{Vec3(-5, 0, 0), Vec3(-4, 0, 0), Vec3(0, 0, 0), Vec3(1, 0, 0)};
    const FourPoints w{Vec3(8, 0, 0), Vec3(8, 0, 0), Vec3::Zero(), Vec3::Zero()};
    CHECK(stays_apart(PairKind::edge_edge, exact(e), exact(w), 0, Rational(499, 1000)));
    CHECK_FALSE(stays_apart(PairKind::edge_edge, exact(e), exact(w), 0, Rational(1, 2)));
    CHECK(safe_step(PairKind::edge_edge, e, w, 0.0) < 0.5);
}
