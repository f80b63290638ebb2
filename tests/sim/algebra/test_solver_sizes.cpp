// The direct solver at the sizes it is used at: 2,000 and 10,000 vertices of cloth with bending, both
// precisions, fronts that several threads share; against Eigen's sparse Cholesky and, where it is installed,
// CHOLMOD.
//
// Tolerances: the backward error |b - A x| / (|A| |x|) of Cholesky's method is a small multiple of the unit
// roundoff u whatever the condition number κ, and the error of x at most κ times that (Higham 2002, Accuracy
// and Stability of Numerical Algorithms, section 10.1). κ is the ratio of the extreme eigenvalues, found by
// power iterations.

#include <tbb/global_control.h>

#include <catch2/catch.hpp>
#include <numeric>
#include <random>

#include <Eigen/SparseCholesky>
#ifdef CLOTH_CHOLMOD
#include <Eigen/CholmodSupport>
#endif

#include "sim/algebra/sparse_solver.h"
#include "sim/energies/bending.h"
#include "sim/energies/membrane.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"
#include "support/sparse.h"

using namespace cloth;
using cloth::testing::lower_triangle;

namespace {

using Precision = SparseSolver::Precision;
using Sparse = Eigen::SparseMatrix<double>;

double unit_roundoff(Precision precision) {
    return precision == Precision::full ? 1.2e-16 : 6.0e-8;
}

/// M + h² H of a cloth with bending, in waves: 0.15 kg/m², 500 N/m, 1e-5 N m, a step of 1/60 s.
struct System {
    BlockPattern pattern;
    BlockMatrix A;
    std::vector<std::array<int, 6>> patches;
    std::vector<int> pinned;

    explicit System(const MeshData& mesh, double mass_scale = 1.0) {
        const auto n = static_cast<int>(mesh.positions.rows());
        std::vector<std::array<int, 3>> triangles;
        std::vector<TriangleRest> rest;
        VecX mass = VecX::Zero(n), x(3 * n);
        for (const auto& t : mesh.triangles.rowwise()) {
            const Vec3 a = mesh.positions.row(t(0)), b = mesh.positions.row(t(1)),
                       c = mesh.positions.row(t(2));
            triangles.push_back({t(0), t(1), t(2)});
            rest.push_back(make_triangle_rest(a, b, c, 5e-4, 4e5, 3e5));
            for (int v : triangles.back()) mass(v) += 0.15 / 6.0 * (b - a).cross(c - a).norm();
        }
        for (int v = 0; v < n; ++v) {
            const Vec3 p = mesh.positions.row(v);
            x.segment<3>(3 * v) = p + Vec3(0, 0, 0.02 * std::sin(9.0 * p.x()) * std::cos(7.0 * p.y()));
        }
        const auto bending = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitY());
        for (const BendingPatch& patch : bending) patches.push_back(patch.vertices);
        MembraneEnergy stretch(triangles, rest);
        BendingEnergy bend(bending, std::vector<Mat3>(bending.size(), bending_rigidity(1e-5, 1e-5, {})));
        std::vector<std::array<int, 2>> pairs;
        stretch.append_pairs(pairs);
        bend.append_pairs(pairs);
        pattern = BlockPattern(n, pairs);
        A.reset(pattern);
        stretch.bind(pattern);
        bend.bind(pattern);
        stretch.add_hessian(x, HessianKind::projected, A);
        bend.add_hessian(x, HessianKind::projected, A);
        for (Mat3& block : A.blocks) block /= 3600.0;
        shift(mass_scale * mass);
    }

    /// Adds `amounts`, one per vertex, to the diagonal.
    void shift(const VecX& amounts) {
        for (int v = 0; v < pattern.vertex_count(); ++v)
            A.blocks[pattern.diagonal(v)].diagonal().array() += amounts(v);
    }

    /// Contacts of a vertex with the triangle beside it: k (w ⊗ n)(w ⊗ n)ᵀ, k a multiple of the greatest
    /// entry.
    void add_contacts(int count, double times_stiffer, std::mt19937& random) {
        std::uniform_real_distribution<double> uniform(0.0, 1.0);
        double stiffness = 0.0;
        for (const Mat3& block : A.blocks) stiffness = std::max(stiffness, block.cwiseAbs().maxCoeff());
        for (int contact = 0; contact < count; ++contact) {
            const auto& p = patches[random() % patches.size()];
            const double b = uniform(random), c = (1.0 - b) * uniform(random);
            const std::array<double, 4> w{b + c - 1.0, -b, -c, 1.0};
            const Vec3 n = Vec3(uniform(random), uniform(random), 0.1).normalized();
            for (int i = 0; i < 4; ++i) {
                for (int j = 0; j < 4; ++j) {
                    if (p[i] > p[j]) continue;
                    A.blocks[pattern.slot(p[i], p[j])] +=
                        times_stiffer * stiffness * w[i] * w[j] * n * n.transpose();
                }
            }
        }
    }

    void leave_free(VecX& x) const {
        for (int v : pinned) x.segment<3>(3 * v).setZero();
    }
    VecX times(const VecX& x) const {
        VecX y;
        multiply(pattern, A, x, y);
        leave_free(y);
        return y;
    }
    /// The lower triangle, with 1 on the diagonal of what is pinned.
    Sparse lower() const {
        BlockMatrix free = A;
        for (int i = 0; i < pattern.vertex_count(); ++i) {
            for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
                const bool row = std::binary_search(pinned.begin(), pinned.end(), i);
                if (!row && !std::binary_search(pinned.begin(), pinned.end(), pattern.column[s])) continue;
                free.blocks[s] = pattern.column[s] == i ? Mat3(Mat3::Identity()) : Mat3(Mat3::Zero());
            }
        }
        return lower_triangle(pattern, free);
    }
};

/// A grid made irregular: vertices moved and numbered at random, diagonals at random, one triangle in twelve
/// missing.
MeshData irregular(const Grid& grid, std::mt19937& random) {
    MeshData mesh = make_grid(grid);
    const int nx = grid.resolution[0];
    std::uniform_real_distribution<double> uniform(-0.3, 0.3);
    std::vector<int> number(mesh.positions.rows());
    std::iota(number.begin(), number.end(), 0);
    std::shuffle(number.begin(), number.end(), random);
    const Points regular = mesh.positions;
    for (Eigen::Index v = 0; v < regular.rows(); ++v) {
        mesh.positions.row(number[v]) =
            regular.row(v) + Vec3(uniform(random), uniform(random), 0.0).transpose() / nx;
    }
    std::vector<std::array<int, 3>> kept;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); t += 2) {
        const int a = mesh.triangles.row(t).minCoeff(), b = a + 1, c = a + nx, d = c + 1;
        const bool rising = random() % 2 == 0;
        for (const auto& corners : rising ? std::array<std::array<int, 3>, 2>{{{a, b, d}, {a, d, c}}}
                                          : std::array<std::array<int, 3>, 2>{{{a, b, c}, {b, d, c}}}) {
            if (random() % 12 != 0)
                kept.push_back({number[corners[0]], number[corners[1]], number[corners[2]]});
        }
    }
    mesh.triangles.resize(static_cast<Eigen::Index>(kept.size()), 3);
    for (std::size_t t = 0; t < kept.size(); ++t) {
        mesh.triangles.row(static_cast<Eigen::Index>(t)) << kept[t][0], kept[t][1], kept[t][2];
    }
    return mesh;
}

VecX random_vector(const System& system, unsigned seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal;
    VecX x(3 * system.pattern.vertex_count());
    for (double& v : x) v = normal(random);
    system.leave_free(x);
    return x;
}

/// Greatest eigenvalue of the free part.
double greatest_eigenvalue(const System& system) {
    VecX x = random_vector(system, 1);
    double value = 0.0;
    for (int k = 0; k < 40; ++k) {
        x = system.times(x.normalized());
        value = x.norm();
    }
    return value;
}

/// Least eigenvalue, by the inverse of a factor of someone else's.
template <class Reference>
double least_eigenvalue(const System& system, const Reference& reference) {
    VecX x = random_vector(system, 2);
    double value = 0.0;
    for (int k = 0; k < 12; ++k) {
        x.normalize();
        const VecX y = reference.solve(x);
        value = 1.0 / y.norm();
        x = y;
    }
    return value;
}

/// Conjugate gradients with the factor as preconditioner: iterations to 1e-10 of the first residual.
int iterations_with(const SparseSolver& solver, const System& system, const VecX& b) {
    VecX x = VecX::Zero(b.size()), r = b, z, p;
    solver.solve(r, z);
    p = z;
    double rz = r.dot(z);
    for (int k = 0; k < 100; ++k) {
        if (r.norm() <= 1e-10 * b.norm()) return k;
        const VecX Ap = system.times(p);
        const double step = rz / p.dot(Ap);
        x += step * p;
        r -= step * Ap;
        solver.solve(r, z);
        const double before = rz;
        rz = r.dot(z);
        p = z + rz / before * p;
    }
    return 100;
}

/// Both precisions against a reference's solution. `kappa` and `norm` are of the free part.
void check_solver(const System& system, const VecX& b, const VecX& expected, double norm, double kappa) {
    for (const Precision precision : {Precision::full, Precision::single}) {
        const double u = unit_roundoff(precision);
        CAPTURE(u, kappa);
        SparseSolver solver(system.pattern, system.pinned, precision);
        const bool factorized = solver.factorize(system.A);
        // Rounding alone may take a matrix as near to singular as this across the border.
        if (kappa * u < 0.1) REQUIRE(factorized);
        if (!factorized) continue;
        VecX x;
        solver.solve(b, x);
        for (int v : system.pinned) REQUIRE(x.segment<3>(3 * v) == Vec3::Zero());
        CHECK((system.times(x) - b).norm() < 3.0 * u * norm * x.norm());
        if (kappa * u < 0.1) {
            CHECK((x - expected).norm() < 3.0 * kappa * u * expected.norm());
            CHECK(iterations_with(solver, system, b) <= 10);
        }
    }
}

template <class Reference>
void check_against(const System& system) {
    const Reference reference(system.lower());
    REQUIRE(reference.info() == Eigen::Success);
    const VecX b = random_vector(system, 3);
    const double norm = greatest_eigenvalue(system);
    check_solver(system, b, reference.solve(b), norm, norm / least_eigenvalue(system, reference));
}

/// Scalars in the factor of a block matrix with that pattern where nothing is padded, by Eigen's
/// factorization of the graph of its vertices in the same order.
double true_fill(const BlockPattern& pattern) {
    const int n = pattern.vertex_count();
    std::vector<Eigen::Triplet<double>> graph;
    for (int i = 0; i < n; ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            graph.emplace_back(pattern.column[s], i, pattern.column[s] == i ? 1e3 : 1.0);
        }
    }
    Sparse lower(n, n);
    lower.setFromTriplets(graph.begin(), graph.end());
    const Eigen::SimplicialLDLT<Sparse, Eigen::Lower, Eigen::AMDOrdering<int>> factor(lower);
    const auto below = static_cast<double>(factor.matrixL().nestedExpression().nonZeros());
    return 9.0 * below + 6.0 * n;
}

}  // namespace

TEST_CASE("2,000 vertices: pinned, stiff contacts, nearly singular, irregular", "[solver]") {
    std::mt19937 random(4);
    const Grid grid{.size = {1.0, 0.8}, .resolution = {50, 40}, .diagonals = Diagonals::alternating};
    std::vector<std::pair<const char*, System>> systems;
    systems.emplace_back("free", System(make_grid(grid)));
    systems.emplace_back("pinned", System(make_grid(grid)));
    for (int v = 0; v < 2000; v += v < 50 ? 1 : 97) systems.back().second.pinned.push_back(v);
    for (const auto& [name, times_stiffer] : {std::pair{"contacts", 1e2}, std::pair{"stiff contacts", 1e6}}) {
        systems.emplace_back(name, System(make_grid(grid)));
        systems.back().second.add_contacts(300, times_stiffer, random);
    }
    systems.emplace_back("nearly singular", System(make_grid(grid), 1e-6));
    systems.emplace_back("irregular", System(irregular(grid, random)));
    systems.back().second.pinned = {7, 300, 301, 1999};
    systems.back().second.shift(VecX::Constant(2000, 1e-5));  // some vertices are in no triangle
    for (const auto& [name, system] : systems) {
        CAPTURE(name);
        check_against<Eigen::SimplicialLDLT<Sparse>>(system);
#ifdef CLOTH_CHOLMOD
        check_against<Eigen::CholmodSupernodalLLT<Sparse>>(system);
#endif
    }
}

TEST_CASE("10,000 vertices, fronts shared by threads: right, and the same bits on any number", "[solver]") {
    std::mt19937 random(5);
    System system(make_grid({.resolution = {100, 100}, .diagonals = Diagonals::alternating}));
    system.pinned = {0, 99, 5050, 9999};
    system.add_contacts(500, 1e2, random);
#ifdef CLOTH_CHOLMOD
    check_against<Eigen::CholmodSupernodalLLT<Sparse>>(system);
#else
    check_against<Eigen::SimplicialLDLT<Sparse>>(system);
#endif
    const VecX b = random_vector(system, 6);
    for (const Precision precision : {Precision::full, Precision::single}) {
        VecX first;
        for (const std::size_t threads : {1, 2, 5}) {
            const tbb::global_control control(tbb::global_control::max_allowed_parallelism, threads);
            SparseSolver solver(system.pattern, system.pinned, precision);
            CHECK(solver.statistics().parallel_fronts >= 2);
            CHECK(solver.statistics().greatest_front >= 600);
            REQUIRE(solver.factorize(system.A));
            VecX x;
            solver.solve(b, x);
            if (threads == 1) first = x;
            CHECK(x == first);
        }
    }
}

TEST_CASE("a matrix is refused as soon as one eigenvalue is negative", "[solver]") {
    System system(make_grid({.resolution = {50, 40}}));
    for (int v = 0; v < 50; ++v) system.pinned.push_back(v);
    const Eigen::SimplicialLDLT<Sparse> reference(system.lower());
    const double least = least_eigenvalue(system, reference);
    const BlockMatrix A = system.A;
    for (const Precision precision : {Precision::full, Precision::single}) {
        SparseSolver solver(system.pattern, system.pinned, precision);
        for (const double share : {0.9, 1.1, 0.0}) {  // it recovers
            CAPTURE(share, unit_roundoff(precision));
            system.A = A;
            system.shift(VecX::Constant(2000, -share * least));
            CHECK(solver.factorize(system.A) == (share < 1.0));
        }
    }
}

TEST_CASE("padding is bounded: on a sheet, on irregular meshes, and along narrow ribbons", "[solver]") {
    std::mt19937 random(6);
    MeshData ribbons = make_grid({.size = {0.02, 0.6}, .resolution = {6, 150}});
    const MeshData one = ribbons;
    ribbons.positions.conservativeResize(2 * one.positions.rows(), 3);
    ribbons.positions.bottomRows(one.positions.rows()) =
        one.positions.rowwise() + Eigen::RowVector3d(1, 0, 0);
    ribbons.triangles.conservativeResize(2 * one.triangles.rows(), 3);
    ribbons.triangles.bottomRows(one.triangles.rows()) =
        one.triangles.array() + static_cast<int>(one.positions.rows());
    for (const MeshData& mesh :
         {ribbons, make_grid({.resolution = {60, 60}}), irregular({.resolution = {50, 50}}, random)}) {
        const System system(mesh);
        const SparseSolver::Statistics found = SparseSolver(system.pattern, {}).statistics();
        const double fill = true_fill(system.pattern);
        CHECK(found.entries >= fill);
        CHECK(found.entries <= 1.3 * fill);
        CHECK(found.fronts < system.pattern.vertex_count() / 2);  // it does merge
    }
}

TEST_CASE("the sizes of the processor's caches do not decide the bits", "[solver]") {
    // Three groups, each coupled within itself and to the next: fronts of 360 columns and 360 rows below,
    // sums that Eigen would cut differently.
    constexpr int group = 120, n = 3 * group;
    std::vector<std::array<int, 2>> pairs;
    for (int i = 0; i < n; ++i) {
        for (int j = i + 1; j < n; ++j) {
            if (j / group - i / group <= 1) pairs.push_back({i, j});
        }
    }
    const BlockPattern pattern(n, pairs);
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    BlockMatrix A;
    A.reset(pattern);
    for (Mat3& block : A.blocks) {
        for (double& value : block.reshaped()) value = uniform(random);
    }
    for (int i = 0; i < n; ++i) A.blocks[pattern.diagonal(i)] = 1e3 * Mat3::Identity();
    const VecX b = VecX::Ones(3 * n);
    for (Precision precision : {Precision::full, Precision::single}) {
        std::vector<VecX> solutions;
        for (const std::ptrdiff_t level_1 : {16 << 10, 48 << 10, 128 << 10}) {
            Eigen::setCpuCacheSizes(level_1, 1 << 20, 8 << 20);
            SparseSolver solver(pattern, {}, precision);
            REQUIRE(solver.factorize(A));
            solver.solve(b, solutions.emplace_back());
        }
        CHECK(solutions[0] == solutions[1]);
        CHECK(solutions[2] == solutions[1]);
    }
}
