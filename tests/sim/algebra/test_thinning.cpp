// A sparser matrix in place of a symmetric one.

#include <random>

#include <Eigen/Dense>
#include <catch2/catch.hpp>

#include "sim/algebra/thinning.h"
#include "support/energy_battery.h"

using namespace cloth;

namespace {

Mat3 random_block(std::mt19937& random) {
    std::normal_distribution<double> normal;
    Mat3 block;
    for (double& value : block.reshaped()) value = normal(random);
    return block;
}

}  // namespace

TEST_CASE("a block is split into what its two diagonals answer it with", "[algebra]") {
    std::mt19937 random(5);
    const Vec3 u = Vec3(1.0, -2.0, 0.5), v = Vec3(0.3, 0.1, -4.0);
    const std::vector<Mat3> blocks{
        random_block(random), random_block(random),    1e-9 * random_block(random),
        u * v.transpose(),    -3.0 * Mat3::Identity(), Vec3(2.0, 0.0, -1.0).asDiagonal(),
        Mat3::Zero()};
    for (const Mat3& B : blocks) {
        Mat3 on_row, on_column;
        split_block(B, on_row, on_column);
        // Against the singular value decomposition.
        const Eigen::JacobiSVD<Mat3> svd(B, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const Mat3 S = svd.singularValues().asDiagonal();
        const double size = B.norm() + 1e-300;
        CHECK((on_row - svd.matrixU() * S * svd.matrixU().transpose()).norm() < 1e-7 * size);
        CHECK((on_column - svd.matrixV() * S * svd.matrixV().transpose()).norm() < 1e-7 * size);
        Eigen::Matrix<double, 6, 6> answered;
        answered << on_row, -B, -B.transpose(), on_column;
        CHECK(testing::smallest_eigenvalue(answered) > -1e-7 * size);
    }
}

TEST_CASE("a thinned matrix has the blocks it keeps, and is nowhere below the whole one", "[algebra]") {
    const int n = 12;
    std::vector<std::array<int, 2>> all, kept;
    for (int i = 0; i < n; ++i) {
        for (int apart : {1, 2, 5}) {
            if (i + apart >= n) continue;
            all.push_back({i, i + apart});
            if (apart == 1) kept.push_back({i, i + apart});
        }
    }
    kept.push_back({0, n - 1});  // which the whole one lacks
    const BlockPattern whole(n, all), thin(n, kept);
    std::mt19937 random(9);
    BlockMatrix A, P;
    A.reset(whole);
    for (Mat3& block : A.blocks) block = random_block(random);
    for (int i = 0; i < n; ++i) {
        Mat3& block = A.blocks[whole.diagonal(i)];
        block = block * block.transpose() + 15.0 * Mat3::Identity();
    }
    Thinning thinning(whole, thin);
    CHECK(thinning.left_out() == whole.slot_count() - thin.slot_count() + 1);
    thinning.apply(A, P);
    REQUIRE(P.blocks.size() == static_cast<std::size_t>(thin.slot_count()));
    for (int i = 0; i + 1 < n; ++i) CHECK(P.blocks[thin.slot(i, i + 1)] == A.blocks[whole.slot(i, i + 1)]);
    CHECK(P.blocks[thin.slot(0, n - 1)].isZero(0.0));
    const Eigen::MatrixXd a = testing::dense(whole, A), p = testing::dense(thin, P);
    CHECK(testing::smallest_eigenvalue(a) > 0.0);
    CHECK(testing::smallest_eigenvalue(p - a) > -1e-10);
    CHECK((p - a).norm() > 1.0);
    // Nothing is left out of a matrix over the same pattern.
    Thinning same(whole, whole);
    same.apply(A, P);
    CHECK(same.left_out() == 0);
    CHECK(testing::dense(whole, P) == a);
}
