// The assignment's fixed Hessian in closed form against its own eigenproblem of size nine.

#include <catch2/catch.hpp>
#include <random>

#include "sim/assignment/assignment.h"
#include "sim/energies/membrane.h"

using namespace cloth;

namespace {

struct Triangle {
    TriangleRest rest;
    Vec9 q9;
};

/// A random triangle at rest with edges of `size`, and the same with principal stretches s0, s1 along random
/// directions, turned and shifted.
Triangle random_triangle(std::mt19937& random, double size, double s0, double s1, double mu, double lambda) {
    std::normal_distribution<double> normal;
    auto vector = [&] { return Vec3(normal(random), normal(random), normal(random)); };
    Vec3 X0, X1, X2;
    do {
        X0 = size * vector();
        X1 = size * vector();
        X2 = size * vector();
    } while ((X1 - X0).cross(X2 - X0).norm() < 0.1 * (X1 - X0).norm() * (X2 - X0).norm());
    const Vec3 n = (X1 - X0).cross(X2 - X0).normalized();
    const Vec3 a = (vector() - n * n.dot(vector())).cross(n).normalized();
    Mat3 frame, turned;
    frame << a, n.cross(a), n;
    turned << vector().normalized(), Vec3::Zero(), Vec3::Zero();
    turned.col(1) = turned.col(0).cross(vector()).normalized();
    turned.col(2) = turned.col(0).cross(turned.col(1));
    const Mat3 F = turned * Vec3(s0, s1, 1.0).asDiagonal() * frame.transpose();
    Triangle t{make_triangle_rest(X0, X1, X2, 1.0, mu, lambda), {}};
    const Vec3 shift = vector();
    t.q9 << F * X0 + shift, F * X1 + shift, F * X2 + shift;
    return t;
}

}  // namespace

TEST_CASE("the fixed Hessian in closed form is that of the eigenproblem of size nine", "[assignment]") {
    std::mt19937 random(5);
    // The assignment's own moduli, ordinary ones, and a negative second one.
    const std::vector<std::array<double, 2>> moduli{{142857.142857, 35714.285714}, {3e4, 5e4}, {1e3, -400.0}};
    const std::vector<double> stretches{0.35,        0.6,        0.9,   0.999, 1.0 - 1e-9, 1.0,
                                        1.0 + 1e-12, 1.0 + 1e-7, 1.003, 1.1,   1.7,        3.0};
    int closed = 0, all = 0;
    for (const auto& [mu, lambda] : moduli) {
        for (const double s0 : stretches) {
            for (const double s1 : stretches) {
                for (const double size : {0.05, 1.0}) {
                    const Triangle t = random_triangle(random, size, s0, s1, mu, lambda);
                    const Mat9 expected =
                        d2V_membrane_corotational_dq2(t.rest.dphi, t.q9, t.rest.volume, mu, lambda);
                    const Mat9 H = fixed_assignment_hessian(t.rest, make_assignment_rest(t.rest), t.q9);
                    CAPTURE(mu, lambda, s0, s1, size);
                    CHECK((H - expected).norm() < 1e-10 * expected.norm());
                    CHECK((H - H.transpose()).norm() < 1e-15 * H.norm());
                    closed += H != expected;  // the other route gives the very same bits
                    ++all;
                }
            }
        }
    }
    CHECK(closed > 0.9 * all);
}

TEST_CASE("a triangle squeezed nearly flat goes by the eigenproblem itself", "[assignment]") {
    std::mt19937 random(6);
    for (const double s1 : {1e-6, 0.02}) {
        const Triangle t = random_triangle(random, 0.05, 0.05, s1, 142857.142857, 35714.285714);
        const Mat9 expected =
            d2V_membrane_corotational_dq2(t.rest.dphi, t.q9, t.rest.volume, t.rest.mu, t.rest.lambda);
        CHECK(expected.allFinite());
        CHECK(fixed_assignment_hessian(t.rest, make_assignment_rest(t.rest), t.q9) == expected);
    }
}
