#include <algorithm>
#include <cmath>
#include <random>

#include <catch2/catch.hpp>

#include "sim/geometry/collide.h"
#include "sim/scene/mesh.h"

using namespace cloth;

namespace {

using L3 = Eigen::Matrix<long double, 3, 1>;

/// Nearest distance by searching the weights' simplex: independent of the features' case analysis. The
/// squared distance is convex in the weights, so alternating exact minimisation along one weight at a time
/// with projection would stall at corners; a grid refined around its best point does not.
long double distance_by_search(PairKind kind, const FourPoints& x) {
    std::array<L3, 4> y;
    for (int i = 0; i < 4; ++i) y[i] = x[i].cast<long double>();
    auto at = [&](long double u, long double v) {
        if (kind == PairKind::vertex_face) {
            // (u, v) in the unit square → triangle: second coordinate scaled by what the first leaves.
            const long double b = u, c = (1.0L - u) * v;
            return (y[0] - ((1.0L - b - c) * y[1] + b * y[2] + c * y[3])).norm();
        }
        return ((1.0L - u) * y[0] + u * y[1] - (1.0L - v) * y[2] - v * y[3]).norm();
    };
    long double best = 1e30L, bu = 0.5L, bv = 0.5L, half = 0.5L;
    for (int level = 0; level < 40; ++level) {
        const long double u0 = bu, v0 = bv;
        for (int i = -8; i <= 8; ++i) {
            for (int j = -8; j <= 8; ++j) {
                const long double u = std::clamp(u0 + half * i / 8.0L, 0.0L, 1.0L);
                const long double v = std::clamp(v0 + half * j / 8.0L, 0.0L, 1.0L);
                const long double d = at(u, v);
                if (d < best) best = d, bu = u, bv = v;
            }
        }
        half *= 0.5L;
    }
    return best;
}

/// Random pairs, one in two degenerate in some way.
FourPoints random_pair(std::mt19937& random, int degeneracy) {
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    auto point = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
    FourPoints x{point(), point(), point(), point()};
    switch (degeneracy) {
        case 1:  // parallel edges
            x[3] = x[2] + uniform(random) * (x[1] - x[0]);
            break;
        case 2:  // nearly parallel
            x[3] = x[2] + uniform(random) * (x[1] - x[0]) + 1e-7 * point();
            break;
        case 3:  // coplanar
            for (Vec3& p : x) p.z() = 0.25;
            break;
        case 4:  // zero-length edge, triangle collapsed to a segment
            x[3] = x[2];
            break;
        case 5:  // all of one side at one point
            x[3] = x[2] = x[1];
            break;
        case 6:  // a needle
            x[3] = 0.5 * (x[1] + x[2]) + 1e-9 * point();
            break;
        case 7:  // a shared point
            x[0] = x[2];
            break;
        case 8:  // collinear
            for (int i = 1; i < 4; ++i) x[i] = x[0] + uniform(random) * Vec3(1.0, 2.0, 3.0);
            break;
        default:
            break;
    }
    return x;
}

}  // namespace

TEST_CASE("nearest distances agree with a search over the weights in extended precision", "[collide]") {
    std::mt19937 random(1);
    for (int k = 0; k < 8000; ++k) {
        const FourPoints x = random_pair(random, k % 18);
        for (PairKind kind : {PairKind::vertex_face, PairKind::edge_edge}) {
            const Nearest n = nearest(kind, x);
            const double distance = std::sqrt(n.distance_squared);
            CAPTURE(k % 18, kind == PairKind::edge_edge, distance);
            // The search is an upper bound; so is any set of weights.
            REQUIRE(distance <= static_cast<double>(distance_by_search(kind, x)) + 1e-9);
        }
    }
}

TEST_CASE("weights are convex, belong to their sides and give the stated distance and slides", "[collide]") {
    std::mt19937 random(2);
    for (int k = 0; k < 4000000; ++k) {
        const FourPoints x = random_pair(random, k % 18);
        for (PairKind kind : {PairKind::vertex_face, PairKind::edge_edge}) {
            const Nearest n = nearest(kind, x);
            const int split = kind == PairKind::vertex_face ? 1 : 2;
            double a = 0.0, b = 0.0;
            bool signs = true;
            for (int i = 0; i < 4; ++i) {
                (i < split ? a : b) += n.weights[i];
                signs = signs && (i < split ? n.weights[i] >= 0.0 : n.weights[i] <= 0.0);
            }
            const bool good = signs && std::abs(a - 1.0) < 1e-12 && std::abs(b + 1.0) < 1e-12 &&
                              n.difference(x).squaredNorm() == n.distance_squared;
            if (!good) FAIL(k);
            // No corner of one side is nearer to a corner of the other than the distance stated.
            for (int i = 0; i < split; ++i) {
                for (int j = split; j < 4; ++j) {
                    if ((x[i] - x[j]).squaredNorm() < n.distance_squared * (1.0 - 1e-12)) FAIL(k);
                }
            }
        }
    }
}

TEST_CASE("no impact is missed and every step found is free of crossings", "[collide]") {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    int impacts = 0, free_ways = 0;
    for (int k = 0; k < 400000; ++k) {
        const FourPoints x = random_pair(random, k % 18);
        FourPoints v = random_pair(random, (k / 18) % 18);
        // Aim one half of them, so that grazes and hits are common; vary the speed over six decades.
        const double speed = std::pow(10.0, 3.0 * uniform(random));
        for (Vec3& p : v) p *= speed;
        const double separation = (k / 7) % 2 == 0 ? 0.0 : 1e-3;
        for (PairKind kind : {PairKind::vertex_face, PairKind::edge_edge}) {
            const double start = std::sqrt(nearest(kind, x).distance_squared);
            const double t = safe_step(kind, x, v, separation);
            if (start <= separation) {
                REQUIRE(t == 0.0);
                continue;
            }
            (t < 1.0 ? impacts : free_ways)++;
            // The gap along the whole way stays above a tenth of the first, give or take rounding.
            double least = start;
            for (int i = 0; i <= 200; ++i) {
                FourPoints y;
                for (int p = 0; p < 4; ++p) y[p] = x[p] + t * i / 200.0 * v[p];
                least = std::min(least, std::sqrt(nearest(kind, y).distance_squared));
            }
            if (least - separation < 0.099 * (start - separation) - 1e-13 * speed) {
                CAPTURE(k, speed, t, start, least, separation);
                REQUIRE(least - separation >= 0.099 * (start - separation));
            }
        }
    }
    CHECK(impacts > 2000);
    CHECK(free_ways > 2000);
}

TEST_CASE("a step that is cut short ends near the impact", "[collide]") {
    // A vertex falls from height 1 at speed 4 onto a face: impact at 1/4; a fifth of the gap is kept.
    const FourPoints x{Vec3(0.2, 1.0, 0.2), Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)};
    const FourPoints v{Vec3(0, -4, 0), Vec3::Zero(), Vec3::Zero(), Vec3::Zero()};
    const double t = safe_step(PairKind::vertex_face, x, v, 0.0);
    CHECK(t <= 0.225);
    CHECK(t >= 0.2);
    // Two crossing edges approach at the same speed.
    const FourPoints e{Vec3(-1, 1, 0), Vec3(1, 1, 0), Vec3(0, 0, -1), Vec3(0, 0, 1)};
    const FourPoints w{Vec3(0, -4, 0), Vec3(0, -4, 0), Vec3::Zero(), Vec3::Zero()};
    CHECK(safe_step(PairKind::edge_edge, e, w, 0.5) <= 0.1125);
    CHECK(safe_step(PairKind::edge_edge, e, w, 0.5) >= 0.1);
    // Sideways motion and motion in common are free.
    const FourPoints side{Vec3(0, 0, 400), Vec3(0, 0, 400), Vec3(0, 0, 400), Vec3(0, 0, 400)};
    CHECK(safe_step(PairKind::edge_edge, e, side, 0.5) == 1.0);
}

TEST_CASE("triangles cross where an edge passes through the other's inside, and only there", "[collide]") {
    const std::array<Vec3, 3> floor{Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 0, 1)};
    const std::array<Vec3, 3> through{Vec3(0.2, -0.5, 0.2), Vec3(0.3, 0.5, 0.2), Vec3(3.0, 0.5, 3.0)};
    CHECK(triangles_cross(floor, through));
    CHECK(triangles_cross(through, floor));
    std::array<Vec3, 3> above = through;
    for (Vec3& p : above) p.y() += 0.51;
    CHECK_FALSE(triangles_cross(floor, above));
    const std::array<Vec3, 3> touching{Vec3(0.2, 0.0, 0.2), Vec3(0.3, 0.5, 0.2), Vec3(0.2, 0.5, 0.3)};
    CHECK_FALSE(triangles_cross(floor, touching));
    CHECK_FALSE(triangles_cross(floor, floor));
    const std::array<Vec3, 3> beside{Vec3(0.8, -0.5, 0.8), Vec3(0.8, 0.5, 0.8), Vec3(3.0, 0.5, 3.0)};
    CHECK_FALSE(triangles_cross(floor, beside));
}

TEST_CASE("no two triangles of a flat sheet cross, whichever way it is turned", "[collide]") {
    Grid grid;
    grid.size = {0.5, 0.4};
    grid.resolution = {20, 16};
    const MeshData sheet = make_grid(grid);
    std::mt19937 random(7);
    for (int turn = 0; turn < 6; ++turn) {
        const double yaw = static_cast<double>(random() % 360), roll = static_cast<double>(random() % 30);
        const Mat3 rotation = rotation_matrix({-90.0, yaw + 0.1, roll - 15.3});
        Points x = sheet.positions;
        for (Eigen::Index v = 0; v < x.rows(); ++v) {
            x.row(v) = (rotation * Vec3(x.row(v)) + Vec3(-0.05, 0.5, 0.01 * turn)).transpose();
        }
        int found = 0;
        for (Eigen::Index s = 0; s < sheet.triangles.rows(); ++s) {
            for (Eigen::Index t = s + 1; t < sheet.triangles.rows(); ++t) {
                std::array<Vec3, 3> a, b;
                bool shared = false;
                for (int k = 0; k < 3; ++k) {
                    a[k] = x.row(sheet.triangles(s, k));
                    b[k] = x.row(sheet.triangles(t, k));
                    shared = shared || (sheet.triangles.row(s).array() == sheet.triangles(t, k)).any();
                }
                found += !shared && triangles_cross(a, b);
            }
        }
        CAPTURE(turn);
        CHECK(found == 0);
    }
}
