// The assignment's functions against differences, closed forms and rigid motion.

#include <catch2/catch.hpp>
#include <random>

#include <Eigen/Dense>

#include "sim/assignment/assignment.h"
#include "sim/energies/membrane.h"
#include "support/energy_battery.h"

using namespace cloth;
using cloth::testing::numerical_gradient;
using cloth::testing::numerical_jacobian;
using cloth::testing::random_rotation;
using cloth::testing::smallest_eigenvalue;

namespace {

constexpr double mu = 142857.14285714287, lambda = 35714.285714285714;

struct Case {
    const char* name;
    Vec3 X[3];
    Vec9 q9;
    double area;
    Mat3 dphi;
};

/// A tilted rest triangle of size about 0.05 m, deformed by the 2x2 in-plane matrix A and a random rotation.
Case make_case(const char* name, const Mat2& A, unsigned seed, double thinness = 1.0) {
    std::mt19937 random(seed);
    Case c{name, {}, {}, 0, {}};
    const Mat3 R_rest = random_rotation(random), R = random_rotation(random);
    const Vec2 flat[3] = {{0.0, 0.0}, {0.05, 0.004}, {0.013, 0.047 * thinness}};
    for (int i = 0; i < 3; ++i) {
        const Vec2 a = A * flat[i];
        c.X[i] = R_rest * Vec3(flat[i].x(), flat[i].y(), 0.0) + Vec3(0.3, -0.2, 0.1);
        c.q9.segment<3>(3 * i) = R * Vec3(a.x(), a.y(), 0.0) + Vec3(-1.0, 0.4, 2.0);
    }
    c.area = 0.5 * (c.X[1] - c.X[0]).cross(c.X[2] - c.X[0]).norm();
    c.dphi = dphi_cloth_triangle_dX(c.X[0], c.X[1], c.X[2]);
    return c;
}

std::vector<Case> cases() {
    auto m = [](double a, double b, double c, double d) {
        Mat2 A;
        A << a, b, c, d;
        return A;
    };
    return {
        make_case("near rest", m(1.0 + 1e-7, 2e-7, -1e-7, 1.0 - 3e-7), 1),
        make_case("equally stretched", m(1.1, 0, 0, 1.1), 2),
        make_case("stretched", m(1.3, 0.2, 0.1, 1.1), 3),
        make_case("compressed", m(0.7, 0.1, -0.05, 0.6), 4),
        make_case("sheared", m(1.0, 0.8, 0.0, 1.0), 5),
        make_case("nearly a line", m(1.2, 0.0, 0.0, 0.02), 6),
        make_case("needle at rest", m(1.05, 0.01, 0.0, 0.97), 7, 0.02),
        make_case("turned over", m(-1.1, 0.1, 0.2, 0.9), 8),
    };
}

double gradient_scale(const Case& c) {
    return c.area * mu * c.dphi.norm();
}
double hessian_scale(const Case& c) {
    return c.area * mu * c.dphi.squaredNorm();
}

Vec9 row_major(const Mat3& m) {
    const Mat3 transposed = m.transpose();
    return transposed.reshaped();
}

/// ∂U, ∂S, ∂V by F_ij.
struct ByEntry {
    Mat3 dU;
    Vec3 dS;
    Mat3 dV;
};
ByEntry derivatives(const SvdDerivatives& d, int i, int j) {
    ByEntry e;
    for (int a = 0; a < 3; ++a) {
        e.dS(a) = d.dS[a](i, j);
        for (int b = 0; b < 3; ++b) {
            e.dU(a, b) = d.dU[a][b](i, j);
            e.dV(a, b) = d.dV[a][b](i, j);
        }
    }
    return e;
}

/// U, S and V of F, on the branch of the decomposition `d` of a matrix near it: columns point the way that
/// they do there, and a singular value is negative where only one of its columns had to be turned.
VecX branch_entries(const SvdDerivatives& d, const Mat3& F) {
    const Eigen::JacobiSVD<Mat3> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Mat3 U = svd.matrixU(), V = svd.matrixV();
    Vec3 S = svd.singularValues();
    for (int k = 0; k < 3; ++k) {
        const double u = U.col(k).dot(d.U.col(k)) < 0.0 ? -1.0 : 1.0;
        const double v = V.col(k).dot(d.V.col(k)) < 0.0 ? -1.0 : 1.0;
        U.col(k) *= u;
        V.col(k) *= v;
        S(k) *= u * v;
    }
    VecX entries(21);
    entries << U.reshaped(), S, V.reshaped();
    return entries;
}

/// df/dx by central differences of 8th order.
VecX central_difference(const std::function<VecX(double)>& f, double x, double h) {
    auto difference = [&](int k) -> VecX { return f(x + k * h) - f(x - k * h); };
    return (4.0 / 5.0 * difference(1) - 1.0 / 5.0 * difference(2) + 4.0 / 105.0 * difference(3) -
            1.0 / 280.0 * difference(4)) /
           h;
}

/// Difference steps must stay small against the thinnest direction.
double step(const Case& c) {
    return 2e-3 * std::min(1.0 / c.dphi.norm(), 0.02 * 0.05);
}

}  // namespace

TEST_CASE("shape function gradients are dual to the edges and sum to zero", "[assignment]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        // φ_i is 1 at corner i and 0 at the others, so ∇φ_i·(X_j - X_0) = δ_ij - δ_i0.
        for (int i = 0; i < 3; ++i) {
            for (int j = 1; j < 3; ++j) {
                const double expected = (i == j) - (i == 0);
                CHECK(c.dphi.row(i).dot(c.X[j] - c.X[0]) == Approx(expected).margin(1e-12));
            }
        }
        CHECK(c.dphi.colwise().sum().norm() < 1e-12 * c.dphi.norm());
        CHECK(std::abs(c.dphi.row(1).dot((c.X[1] - c.X[0]).cross(c.X[2] - c.X[0]))) < 1e-12);
    }
}

TEST_CASE("the deformation gradient maps edges to edges and normal to normal", "[assignment]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const Mat3 F = deformation_gradient(c.dphi, c.q9);
        const Vec3 e1 = c.q9.segment<3>(3) - c.q9.head<3>(), e2 = c.q9.tail<3>() - c.q9.head<3>();
        CHECK((F * (c.X[1] - c.X[0]) - e1).norm() < 1e-13);
        CHECK((F * (c.X[2] - c.X[0]) - e2).norm() < 1e-13);
        const Vec3 N = (c.X[1] - c.X[0]).cross(c.X[2] - c.X[0]).normalized();
        CHECK((F * N - e1.cross(e2).normalized()).norm() < 1e-12);
        CHECK(F.determinant() > 0.0);
    }
}

TEST_CASE("dF/dq agrees with differences of F", "[assignment]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        auto flat = [&](const VecX& q) -> VecX {
            const Eigen::Matrix<double, 3, 3, Eigen::RowMajor> F = deformation_gradient(c.dphi, q);
            return Eigen::Map<const Vec9>(F.data());
        };
        const Mat9 B = deformation_gradient_dq(c.dphi, c.q9);
        const double scale = B.cwiseAbs().maxCoeff();
        CHECK((B - numerical_jacobian(flat, c.q9, step(c))).cwiseAbs().maxCoeff() < 1e-9 * scale);
    }
}

TEST_CASE("the membrane gradient agrees with differences of the energy", "[assignment]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        auto V = [&](const VecX& q) { return V_membrane_corotational(c.dphi, q, c.area, mu, lambda); };
        const Vec9 g = dV_membrane_corotational_dq(c.dphi, c.q9, c.area, mu, lambda);
        const double scale = gradient_scale(c);
        CHECK((g - numerical_gradient(V, c.q9, step(c))).norm() < 1e-9 * scale);
        CHECK((g.head<3>() + g.segment<3>(3) + g.tail<3>()).norm() < 1e-12 * scale);
    }
}

TEST_CASE("known energies of uniform stretch", "[assignment]") {
    // F = diag(a, b, 1): ψ = mu ((a-1)² + (b-1)²) + lambda/2 (a+b-2)².
    for (const auto& [a, b] : {std::pair{1.2, 0.9}, std::pair{1.0, 1.0}, std::pair{0.5, 1.5}}) {
        Mat2 A;
        A << a, 0, 0, b;
        const Case c = make_case("diagonal", A, 11);
        const double psi =
            mu * ((a - 1) * (a - 1) + (b - 1) * (b - 1)) + 0.5 * lambda * (a + b - 2) * (a + b - 2);
        CHECK(V_membrane_corotational(c.dphi, c.q9, c.area, mu, lambda) ==
              Approx(c.area * psi).epsilon(1e-12).margin(1e-20));
    }
}

TEST_CASE("rigid motion costs nothing and exerts no force", "[assignment]") {
    const Case c = make_case("rigid", Mat2::Identity(), 21);
    CHECK(V_membrane_corotational(c.dphi, c.q9, c.area, mu, lambda) < 1e-25);
    CHECK(dV_membrane_corotational_dq(c.dphi, c.q9, c.area, mu, lambda).norm() < 1e-11 * gradient_scale(c));
}

TEST_CASE("the closed-form membrane is the assignment's energy and gradient", "[assignment][membrane]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const TriangleRest rest = make_triangle_rest(c.X[0], c.X[1], c.X[2], 1.0, mu, lambda);
        const double V = V_membrane_corotational(c.dphi, c.q9, c.area, mu, lambda);
        CHECK(membrane_energy(rest, c.q9) == Approx(V).epsilon(1e-11).margin(1e-12 * c.area * mu));
        CHECK((membrane_gradient(rest, c.q9) - dV_membrane_corotational_dq(c.dphi, c.q9, c.area, mu, lambda))
                  .norm() < 1e-11 * gradient_scale(c));
    }
}

TEST_CASE("the assignment's Hessian is the exact one plus A ψ_2 (dn/dq)ᵀ(dn/dq)", "[assignment][membrane]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const TriangleRest rest = make_triangle_rest(c.X[0], c.X[1], c.X[2], 1.0, mu, lambda);
        const Vec3 e1 = c.q9.segment<3>(3) - c.q9.head<3>(), e2 = c.q9.tail<3>() - c.q9.head<3>();
        const Vec3 n = e1.cross(e2).normalized();
        // dn/dq from n·e = 0: dn = -Σ (n·dx_i) ∇φ_i in space.
        const Mat3 F = deformation_gradient(c.dphi, c.q9);
        const Mat3 spatial = c.dphi * F.inverse();
        Eigen::Matrix<double, 3, 9> dn;
        for (int i = 0; i < 3; ++i) dn.block<3, 3>(0, 3 * i) = -spatial.row(i).transpose() * n.transpose();
        const double psi_2 = lambda * (Eigen::JacobiSVD<Mat3>(F).singularValues().sum() - 3.0);
        const Mat9 seed = d2V_membrane_corotational_dq2_unfixed(c.dphi, c.q9, c.area, mu, lambda);
        const Mat9 expected = membrane_hessian(rest, c.q9, false) + c.area * psi_2 * dn.transpose() * dn;
        const double scale = std::max(hessian_scale(c), seed.norm());
        CHECK((seed - expected).norm() < 1e-9 * scale);

        // And the exact one is the derivative of the gradient.
        auto g = [&](const VecX& q) -> VecX { return membrane_gradient(rest, q); };
        CHECK((membrane_hessian(rest, c.q9, false) - numerical_jacobian(g, c.q9, step(c))).norm() <
              1e-8 * scale);
    }
}

TEST_CASE("the eigenvalue fix lifts eigenvalues below 1e-6 to 1e-3 and keeps the others", "[assignment]") {
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const Mat9 before = d2V_membrane_corotational_dq2_unfixed(c.dphi, c.q9, c.area, mu, lambda);
        const Mat9 after = d2V_membrane_corotational_dq2(c.dphi, c.q9, c.area, mu, lambda);
        Vec9 expected =
            Eigen::SelfAdjointEigenSolver<Mat9>(0.5 * (before + before.transpose())).eigenvalues();
        const double scale = expected.cwiseAbs().maxCoeff();
        for (double& v : expected) v = v < 1e-6 ? 1e-3 : v;
        std::sort(expected.data(), expected.data() + 9);
        const Vec9 got = Eigen::SelfAdjointEigenSolver<Mat9>(0.5 * (after + after.transpose())).eigenvalues();
        CHECK((got - expected).norm() < 1e-11 * scale);
    }
}

TEST_CASE("the assignment's formula for the Hessian, with dsvd, is the closed form", "[assignment]") {
    // ∂/∂F_ij ∂ψ/∂F = ∂U dS Vᵀ + U diag(ds_ij) Vᵀ + U dS ∂Vᵀ. The third stretch is 1: pairs with it are equal
    // where a stretch is 1, and the two others where the triangle is stretched equally.
    int equal_pairs = 0;
    for (const Case& c : cases()) {
        CAPTURE(c.name);
        const SvdDerivatives d = dsvd(deformation_gradient(c.dphi, c.q9));
        const Vec3 dpsi = 2.0 * mu * (d.S.array() - 1.0) + lambda * (d.S.sum() - 3.0);
        const Mat3 d2psi = 2.0 * mu * Mat3::Identity() + lambda * Mat3::Ones();
        Mat9 psi_FF;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const auto [dU, dS, dV] = derivatives(d, i, j);
                Mat3 dP = dU * dpsi.asDiagonal() * d.V.transpose() +
                          d.U * (d2psi * dS).asDiagonal() * d.V.transpose() +
                          d.U * dpsi.asDiagonal() * dV.transpose();
                // Where two stretches are equal ∂U and ∂V leave a turn out, which ψ meets with 2 mu.
                Mat3 limit = Mat3::Zero();
                for (int k = 0; k < 3; ++k) {
                    for (int l = k + 1; l < 3; ++l) {
                        if (d.S(k) - d.S(l) > 1e-10 * d.S(0)) continue;
                        ++equal_pairs;
                        limit(k, l) = limit(l, k) = mu * (d.U(i, k) * d.V(j, l) + d.U(i, l) * d.V(j, k));
                    }
                }
                dP += d.U * limit * d.V.transpose();
                psi_FF.col(3 * i + j) = row_major(dP);
            }
        }
        const Mat9 B = deformation_gradient_dq(c.dphi, c.q9);
        const Mat9 H = c.area * B.transpose() * psi_FF * B;
        const Mat9 closed = d2V_membrane_corotational_dq2_unfixed(c.dphi, c.q9, c.area, mu, lambda);
        CHECK((H - closed).norm() < 1e-9 * closed.norm());
        CHECK(H != closed);  // two routes
    }
    CHECK(equal_pairs >= 9);
}

TEST_CASE("derivatives of the singular value decomposition agree with differences", "[assignment]") {
    std::mt19937 random(17);
    for (const Vec3& S : {Vec3(1.7, 1.1, 0.4), Vec3(1.2, 1.0, 0.03), Vec3(1.0 + 1e-3, 1.0, 0.5),
                          Vec3(1.4, 0.7 + 1e-5, 0.7), Vec3(1.0 + 1e-4, 1.0, 1.0 - 1e-4), Vec3(1.3, 0.8, 0.0),
                          Vec3(1.3, 2e-4, 0.0), Vec3(2e-6, 1e-6, 5e-7), Vec3(3e5, 2e5, 1e2)}) {
        CAPTURE(S.transpose());
        const Mat3 F = random_rotation(random) * S.asDiagonal() * random_rotation(random);
        const SvdDerivatives d = dsvd(F);
        CHECK((d.U * d.S.asDiagonal() * d.V.transpose() - F).norm() < 1e-14 * S(0));
        // Steps are small against the gap to the nearest neighbour, to the mirror image of S_1 too.
        const double gap = std::min({S(0) - S(1), S(1) - S(2), S(1) + S(2)});
        const double step = 2e-3 * gap, error = 1e-9 + 1e-14 * S(0) / step;
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                auto entries = [&](double f) {
                    Mat3 moved = F;
                    moved(i, j) = f;
                    return branch_entries(d, moved);
                };
                const VecX numerical = central_difference(entries, F(i, j), step);
                const auto [dU, dS, dV] = derivatives(d, i, j);
                const Vec9 u = numerical.head<9>(), v = numerical.tail<9>();
                CHECK((dS - numerical.segment<3>(9)).norm() < error);
                CHECK((dU.reshaped() - u).norm() < error / gap);
                CHECK((dV.reshaped() - v).norm() < error / gap);
                CHECK(u.norm() + v.norm() > 0.0);
                CHECK(dU.reshaped() != u);
            }
        }
    }
}

TEST_CASE("equal and zero singular values: what has a derivative is right, free turns are 0",
          "[assignment]") {
    std::mt19937 random(19);
    for (const Vec3& S : {Vec3(1.2, 1.2, 0.5), Vec3(1.2, 0.5, 0.5), Vec3(1, 1, 1), Vec3(1.5, 0, 0),
                          Vec3(0.7, 0.7, 0), Vec3(0, 0, 0)}) {
        CAPTURE(S.transpose());
        const Mat3 F = random_rotation(random) * S.asDiagonal() * random_rotation(random);
        const SvdDerivatives d = dsvd(F);
        for (int i = 0; i < 3; ++i) {
            for (int j = 0; j < 3; ++j) {
                const auto [dU, dS, dV] = derivatives(d, i, j);
                const Mat3 X = d.U.transpose() * dU, Y = d.V.transpose() * dV;
                CHECK((X + X.transpose()).norm() < 1e-14 * (1.0 + X.norm()));
                CHECK((Y + Y.transpose()).norm() < 1e-14 * (1.0 + Y.norm()));
                // Uᵀ dF V without the part that turns cannot bring about.
                Mat3 A = d.U.row(i).transpose() * d.V.row(j);
                for (int k = 0; k < 3; ++k) {
                    for (int l = k + 1; l < 3; ++l) {
                        const bool equal = S(k) == S(l), zero = S(k) + S(l) == 0.0;
                        const double symmetric = equal ? 0.0 : 0.5 * (A(k, l) + A(l, k));
                        const double rotation = zero ? 0.0 : 0.5 * (A(k, l) - A(l, k));
                        if (equal) CHECK(std::abs(X(k, l) + Y(k, l)) < 1e-14);
                        if (zero) CHECK(std::abs(X(k, l) - Y(k, l)) < 1e-14);
                        A(k, l) = symmetric + rotation;
                        A(l, k) = symmetric - rotation;
                    }
                }
                const Mat3 dF = dU * d.S.asDiagonal() * d.V.transpose() +
                                d.U * dS.asDiagonal() * d.V.transpose() +
                                d.U * d.S.asDiagonal() * dV.transpose();
                CHECK((d.U.transpose() * dF * d.V - A).norm() < 1e-13);
            }
        }
    }
}

TEST_CASE("the mass matrix is the integral of φ_i φ_j", "[assignment]") {
    const Mat9 M = mass_matrix_triangle(0.6);
    // ∫ φ_i φ_j over a triangle is A/6 on the diagonal and A/12 off it; all nine add up to A.
    CHECK(M(0, 0) == Approx(0.1).epsilon(1e-14));
    CHECK(M(0, 3) == Approx(0.05).epsilon(1e-14));
    CHECK(M(0, 1) == 0.0);
    Vec9 unit = Vec9::Zero();
    for (int i = 0; i < 3; ++i) unit(3 * i) = 1.0;
    CHECK(unit.dot(M * unit) == Approx(0.6).epsilon(1e-14));

    Triangles F(2, 3);
    F << 0, 1, 2, 1, 3, 2;
    const VecX areas = VecX::Constant(2, 0.5);
    const SparseMatrix mesh = mass_matrix_mesh(4, F, 3.0, areas);
    const VecX v = Vec3(1.0, -2.0, 0.5).replicate(4, 1);
    CHECK(T_cloth(v, mesh) == Approx(0.5 * 3.0 * 1.0 * 5.25).epsilon(1e-14));
    const VecX g = dV_cloth_gravity_dq(mesh, Vec3(0, -9.81, 0));
    CHECK(g.sum() == Approx(3.0 * 9.81).epsilon(1e-14));  // one square metre of 3 kg/m²
}

TEST_CASE("springs: energy and gradient", "[assignment]") {
    const Vec3 a(0.1, 0.2, 0.3), b(1.1, 0.7, -0.4);
    const double l = (b - a).norm();
    CHECK(V_spring_particle_particle(a, b, l, 10.0) == 0.0);
    CHECK(V_spring_particle_particle(a, b, 0.0, 10.0) == Approx(5.0 * l * l).epsilon(1e-14));
    for (double l0 : {0.0, 0.3, 2.0}) {
        VecX x(6);
        x << a, b;
        auto V = [&](const VecX& q) {
            return V_spring_particle_particle(q.head<3>(), q.tail<3>(), l0, 10.0);
        };
        CHECK((dV_spring_particle_particle_dq(a, b, l0, 10.0) - numerical_gradient(V, x, 1e-3)).norm() <
              1e-10);
    }
    CHECK(dV_spring_particle_particle_dq(a, a, 0.0, 10.0).norm() == 0.0);
}

TEST_CASE("pinned vertices are a projection", "[assignment]") {
    const SparseMatrix P = fixed_point_constraints(4, {1, 3});
    CHECK(P.rows() == 6);
    VecX q(12);
    for (int i = 0; i < 12; ++i) q(i) = i;
    const VecX kept = P * q;
    VecX expected(6);
    expected << 0, 1, 2, 6, 7, 8;
    CHECK(kept == expected);
    CHECK((P * SparseMatrix(P.transpose())).toDense().isIdentity(0.0));
    const VecX x0 = q - P.transpose() * kept;
    CHECK(VecX(P.transpose() * kept + x0) == q);
}

TEST_CASE("sphere contact and one-sided filter", "[assignment]") {
    const Vec3 center(0.0, 0.0, 0.4);
    VecX q(9), v(9);
    q << 0.0, 0.0, 0.19, 0.0, 0.0, 0.17, 0.21, 0.0, 0.4;  // inside, outside, inside
    v << 0.3, 0.0, 2.0, 0.0, 0.0, 5.0, 1.0, 2.0, 0.0;     // inward, free, outward
    const SphereContacts contacts = collision_detection_cloth_sphere(q, center, 0.22);
    REQUIRE(contacts.vertices == std::vector<int>{0, 2});
    CHECK((contacts.normals[0] - Vec3(0, 0, -1)).norm() < 1e-15);
    velocity_filter_cloth_sphere(v, contacts);
    VecX expected(9);
    expected << 0.3, 0.0, 0.0, 0.0, 0.0, 5.0, 1.0, 2.0, 0.0;
    CHECK((v - expected).norm() < 1e-15);
}

TEST_CASE("picking finds the triangle under the pointer and its neighbours in the radius", "[assignment]") {
    // Camera at (0, 0, 2) looking along -z, 90° field of view: pixel ↔ plane z = 0 at 2 m: half height 2 m.
    Mat4 view = Mat4::Identity();
    view(2, 3) = -2.0;
    Mat4 projection = Mat4::Zero();
    const double n = 0.1, f = 10.0;
    projection(0, 0) = projection(1, 1) = 1.0;
    projection(2, 2) = -(f + n) / (f - n);
    projection(2, 3) = -2.0 * f * n / (f - n);
    projection(3, 2) = -1.0;
    const Vec2 viewport(100, 100);
    Triangles F(2, 3);
    F << 0, 1, 2, 3, 4, 5;
    VecX q(18);
    q << -1, -1, 0, 1, -1, 0, 0, 1, 0,    // at z = 0
        -1, -1, -1, 1, -1, -1, 0, 1, -1;  // behind it
    // World (0.02, 0.9, 0): pixel x = 50 + 25·0.02, y = 50 - 25·0.9.
    const Vec2 win(50.5, 27.5);
    Pick pick = pick_nearest_vertices(win, view, projection, viewport, q, F, 0.5);
    REQUIRE(pick.vertices == std::vector<int>{2});
    CHECK((pick.hit - Vec3(0.02, 0.9, 0.0)).norm() < 1e-12);
    pick = pick_nearest_vertices(win, view, projection, viewport, q, F, 1.01);
    CHECK(pick.vertices == std::vector<int>{2, 5});
    CHECK(pick_nearest_vertices(Vec2(1, 1), view, projection, viewport, q, F, 1.0).vertices.empty());
    CHECK((unproject(Vec2(75, 50), view, projection, viewport, pick.hit) - Vec3(1.0, 0.0, 0.0)).norm() <
          1e-12);
}
