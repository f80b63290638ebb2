// The direct solver against dense solutions, on small meshes.

#include <catch2/catch.hpp>
#include <random>

#include <Eigen/Dense>

#include "sim/algebra/sparse_solver.h"
#include "sim/scene/mesh.h"
#include "support/energy_battery.h"

using namespace cloth;
using cloth::testing::dense;

namespace {

/// Random symmetric positive definite matrix over a pattern: diagonally dominant, with off-diagonal
/// structure.
BlockMatrix random_matrix(const BlockPattern& pattern, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    BlockMatrix A;
    A.reset(pattern);
    for (int i = 0; i < pattern.vertex_count(); ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            for (double& v : A.blocks[s].reshaped()) v = normal(random);
            if (pattern.column[s] != i) continue;
            A.blocks[s] = (A.blocks[s] + A.blocks[s].transpose()).eval();
            A.blocks[s].diagonal().array() += 60.0;
        }
    }
    return A;
}

BlockPattern pattern_of(const Triangles& triangles, int n, bool wide) {
    std::vector<std::array<int, 2>> pairs;
    for (int t = 0; t < triangles.rows(); ++t) {
        for (int i = 0; i < 3; ++i) pairs.push_back({triangles(t, i), triangles(t, (i + 1) % 3)});
    }
    if (wide) {
        for (int i = 0; i + 7 < n; i += 3) pairs.push_back({i, i + 7});
    }
    return BlockPattern(n, pairs);
}

}  // namespace

TEST_CASE("the direct solver agrees with a dense solution", "[solver]") {
    struct Case {
        std::array<int, 2> resolution;
        std::vector<int> pinned;
        bool wide;
    };
    for (const Case& c : {Case{{2, 2}, {}, false}, Case{{2, 2}, {0, 1, 2}, false}, Case{{9, 7}, {}, true},
                          Case{{13, 11}, {0, 5, 12, 77, 142}, true}, Case{{3, 40}, {}, false}}) {
        const MeshData mesh = make_grid({.resolution = c.resolution});
        const auto n = static_cast<int>(mesh.positions.rows());
        const BlockPattern pattern = pattern_of(mesh.triangles, n, c.wide);
        SparseSolver solver(pattern, c.pinned);
        for (unsigned seed : {1u, 2u}) {  // a second factorisation reuses all memory
            const BlockMatrix A = random_matrix(pattern, seed);
            Eigen::MatrixXd D = dense(pattern, A);
            VecX b = VecX::LinSpaced(3 * n, -1.0, 2.0);
            for (int v : c.pinned) {
                D.middleRows<3>(3 * v).setZero();
                D.middleCols<3>(3 * v).setZero();
                D.block<3, 3>(3 * v, 3 * v).setIdentity();
            }
            VecX x;
            REQUIRE(solver.factorize(A));
            solver.solve(b, x);
            for (int v : c.pinned) {
                CHECK(x.segment<3>(3 * v).norm() == 0.0);
                b.segment<3>(3 * v).setZero();
            }
            CHECK((x - D.llt().solve(b)).norm() < 1e-13 * x.norm());
            VecX y;
            solver.solve(b, y);
            CHECK(y == x);
        }
    }
}

TEST_CASE("unconnected pieces and a fully pinned mesh are solved", "[solver]") {
    const BlockPattern pattern(5, {{0, 1}, {3, 4}});
    const BlockMatrix A = random_matrix(pattern, 3);
    SparseSolver solver(pattern, {});
    REQUIRE(solver.factorize(A));
    const VecX b = VecX::Ones(15);
    VecX x;
    solver.solve(b, x);
    CHECK((dense(pattern, A) * x - b).norm() < 1e-12);
    SparseSolver pinned(pattern, {0, 1, 2, 3, 4});
    REQUIRE(pinned.factorize(A));
    pinned.solve(b, x);
    CHECK(x == VecX::Zero(15));
}

TEST_CASE("a matrix that is not positive definite is refused", "[solver]") {
    const BlockPattern pattern(6, {{0, 1}, {1, 2}, {2, 3}, {3, 4}, {4, 5}});
    BlockMatrix A = random_matrix(pattern, 5);
    SparseSolver solver(pattern, {});
    CHECK(solver.factorize(A));
    A.blocks[pattern.diagonal(3)](1, 1) = -1.0;
    CHECK_FALSE(solver.factorize(A));
    A = random_matrix(pattern, 5);
    A.blocks[pattern.diagonal(2)](0, 0) = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(solver.factorize(A));
    CHECK(solver.factorize(random_matrix(pattern, 5)));  // it recovers
}
