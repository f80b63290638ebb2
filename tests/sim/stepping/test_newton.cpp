// The parts of Newton's method: linear solvers and the rule that ends it.

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "sim/energies/bending.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"
#include "sim/stepping/newton.h"
#include "support/energy_battery.h"

using namespace cloth;

namespace {

/// A chain of `n` vertices, each block row more than the sum of the others; `stiff`: the weight of springs
/// between vertices `apart` places from each other, outside of the pattern.
struct Chain {
    BlockPattern pattern;
    SystemMatrix A;

    Chain(int n, int apart, double stiff) {
        std::vector<std::array<int, 2>> pairs;
        for (int i = 0; i + 1 < n; ++i) pairs.push_back({i, i + 1});
        pattern = BlockPattern(n, pairs);
        A.inside.reset(pattern);
        for (int i = 0; i < n; ++i) {
            A.inside.blocks[pattern.diagonal(i)] = Vec3(2.5, 3.0, 3.5 + 0.1 * i).asDiagonal();
            if (i + 1 < n) A.inside.blocks[pattern.slot(i, i + 1)] = -Mat3::Identity();
        }
        for (int i = 0; i + apart < n; i += 2) {
            const Vec3 u = Vec3(1.0, 2.0 + i, -1.0).normalized();
            const Mat3 k = stiff * u * u.transpose();
            A.inside.blocks[pattern.diagonal(i)] += k;
            A.inside.blocks[pattern.diagonal(i + apart)] += k;
            A.outside.where.push_back({i, i + apart});
            A.outside.blocks.push_back(-k);
        }
    }

    Eigen::MatrixXd dense() const {
        Eigen::MatrixXd D = testing::dense(pattern, A.inside);
        for (std::size_t b = 0; b < A.outside.where.size(); ++b) {
            const auto [i, j] = A.outside.where[b];
            D.block<3, 3>(3 * i, 3 * j) += A.outside.blocks[b];
            D.block<3, 3>(3 * j, 3 * i) += A.outside.blocks[b].transpose();
        }
        return D;
    }
};

VecX random_vector(int size) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    VecX v(size);
    for (double& value : v) value = normal(random);
    return v;
}

/// The dense solution on the vertices that are not in `pinned`.
VecX dense_solution(Eigen::MatrixXd D, VecX b, const std::vector<int>& pinned) {
    for (int v : pinned) {
        D.middleRows<3>(3 * v).setZero();
        D.middleCols<3>(3 * v).setZero();
        D.block<3, 3>(3 * v, 3 * v).setIdentity();
        b.segment<3>(3 * v).setZero();
    }
    return D.ldlt().solve(b);
}

}  // namespace

TEST_CASE("conjugate gradients solve what couples vertices outside of the pattern", "[newton]") {
    const std::vector<int> pinned{0, 7};
    for (double stiff : {0.5, 1e3}) {
        const Chain chain(20, 5, stiff);
        const VecX b = random_vector(60);
        ConjugateGradients solver(chain.pattern, chain.pattern);
        solver.leave_out(pinned);
        solver.begin();
        StepReport report;
        VecX d;
        REQUIRE(solver.factorize(chain.A, true, report));
        REQUIRE(solver.solve(b, 1e-9, d, report));
        const VecX expected = dense_solution(chain.dense(), b, pinned);
        CHECK((d - expected).norm() < 1e-7 * expected.norm());
        CHECK(report.cg_iterations > 1);
        CHECK(report.factorizations == 1);
        for (int v : pinned) CHECK(d.segment<3>(3 * v).isZero(0.0));
    }
}

TEST_CASE("both linear solvers agree where nothing is outside of the pattern", "[newton]") {
    Chain chain(12, 4, 2.0);
    chain.A.outside = {};
    const VecX b = random_vector(36);
    StepReport report;
    VecX direct, iterative;
    DirectSolver exact(chain.pattern);
    exact.leave_out({3});
    REQUIRE(exact.factorize(chain.A, false, report));
    REQUIRE(exact.solve(b, 0.0, direct, report));
    CHECK(report.cg_iterations == 0);
    ConjugateGradients solver(chain.pattern, chain.pattern);
    solver.leave_out({3});
    REQUIRE(solver.factorize(chain.A, false, report));
    REQUIRE(solver.solve(b, 1e-9, iterative, report));
    CHECK((iterative - direct).norm() < 1e-8 * direct.norm());
    CHECK(iterative != direct);  // two routes
}

TEST_CASE("a matrix that is not positive definite is refused by the factor or on the way", "[newton]") {
    Chain chain(12, 4, 2.0);
    StepReport report;
    VecX d;
    const BlockPattern diagonal(12, {});
    SystemMatrix hidden = chain.A;
    hidden.outside = {};
    for (int i = 0; i + 1 < 12; ++i) hidden.inside.blocks[chain.pattern.slot(i, i + 1)] *= 10.0;
    ConjugateGradients thin(chain.pattern, diagonal);  // whose factor lacks these, and is positive definite
    thin.leave_out({});
    REQUIRE(thin.factorize(hidden, false, report));
    CHECK_FALSE(thin.solve(random_vector(36), 1e-6, d, report));

    ConjugateGradients solver(chain.pattern, chain.pattern);
    solver.leave_out({});
    SystemMatrix coupled = chain.A;
    for (Mat3& block : coupled.outside.blocks) block *= 100.0;
    CHECK_FALSE(solver.factorize(coupled, false, report));

    chain.A.inside.blocks[chain.pattern.diagonal(5)] *= -1.0;
    DirectSolver exact(chain.pattern);
    exact.leave_out({});
    CHECK_FALSE(exact.factorize(chain.A, false, report));
    CHECK_FALSE(solver.factorize(chain.A, false, report));
}

TEST_CASE("contact that is coupled in the factor takes few iterations", "[newton]") {
    const Chain chain(200, 5, 1e5);
    StepReport report;
    VecX d;
    ConjugateGradients solver(chain.pattern, chain.pattern);
    solver.leave_out({});
    solver.begin();
    REQUIRE(solver.factorize(chain.A, true, report));
    REQUIRE(solver.solve(random_vector(600), 1e-3, d, report));
    CHECK(report.cg_iterations <= 4);
}

TEST_CASE("a factor goes without bending's second ring, and keeps all else", "[newton]") {
    const MeshData mesh = make_grid({.resolution = {4, 4}});
    std::vector<std::array<int, 2>> edges, all{{0, 15}};  // a spring across, and bending
    for (int t = 0; t < mesh.triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) edges.push_back({mesh.triangles(t, i), mesh.triangles(t, (i + 1) % 3)});
    }
    all.insert(all.end(), edges.begin(), edges.end());
    const auto patches = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitY());
    const BendingEnergy bending(patches, std::vector<Mat3>(patches.size(), bending_rigidity(1e-5, 1e-5, {})));
    bending.append_pairs(all);
    const BlockPattern whole(16, all), near = without_second_ring(whole, mesh.triangles);
    edges.push_back({0, 15});
    const BlockPattern expected(16, edges);
    CHECK(whole.slot_count() > expected.slot_count());
    CHECK(near.column == expected.column);
    CHECK(near.row_begin == expected.row_begin);
}

TEST_CASE("accuracy says when a solve ends unless a scene says it in numbers", "[newton]") {
    SimulationDesc options;
    const StoppingLimits fine = options.stopping();
    options.accuracy = Accuracy::draft;
    const StoppingLimits draft = options.stopping();
    CHECK(draft.speed > fine.speed);
    CHECK(draft.share > fine.share);
    options.accuracy = Accuracy::reference;
    CHECK(options.stopping().speed == 0.0);
    CHECK(options.stopping().share == 0.0);
    CHECK(options.stopping().tolerance == 1e-6);
    options.newton_speed = 0.2;
    CHECK(options.stopping().speed == 0.2);
    CHECK(options.stopping().share == 0.0);
    CHECK(options.stopping().tolerance == 1e-6);
    options.newton_tolerance = 1e-3;
    CHECK(options.stopping().tolerance == 1e-3);
    options.newton_speed.reset();
    CHECK(options.stopping().speed == 0.0);
}

TEST_CASE("the rule ends a minimisation by its residual, at rest, or where rounding rules", "[newton]") {
    StoppingRule rule{.limits = {.tolerance = 1e-3, .speed = 0.03, .share = 0.05}, .scale = 50.0};
    CHECK(rule.converged(0.05));
    CHECK_FALSE(rule.converged(0.051));
    CHECK(rule.near(0.49));
    CHECK_FALSE(rule.near(0.51));
    // A step of a tenth of a second is slow below 3 mm.
    CHECK(rule.slow(0.0029, 0.1));
    CHECK_FALSE(rule.slow(0.0031, 0.1));
    CHECK(rule.at_rest(0.00029));
    CHECK_FALSE(rule.at_rest(0.00031));
    // Of a cloth at 2 m/s the share counts, below 1 cm.
    rule.own = 2.0;
    CHECK(rule.slow(0.0099, 0.1));
    CHECK_FALSE(rule.slow(0.0101, 0.1));
    CHECK(rule.at_rest(0.00099));
    rule.limits = {.tolerance = 1e-3, .speed = 0.0, .share = 0.0};
    CHECK_FALSE(rule.slow(0.0, 0.1));
    // Positions of a metre, a stiffness of 1e6 N/m: 4e-10 N.
    CHECK(rule.lost_in_rounding(3e-10, 1e6, 1.0, 1.0));
    CHECK_FALSE(rule.lost_in_rounding(5e-10, 1e6, 1.0, 1.0));
    CHECK(rule.lost_in_rounding(1.0, 1e6, 0.9e-14, 1.0));
}
