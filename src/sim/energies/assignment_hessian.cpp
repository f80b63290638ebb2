#include "sim/energies/assignment_hessian.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include <Eigen/Eigenvalues>

#include "sim/algebra/symmetric.h"
#include "sim/assignment/assignment.h"
#include "sim/energies/membrane.h"

namespace cloth {
namespace {

using Vec4 = Eigen::Vector4d;

/// Orthonormal basis of what sums to zero over three corners.
Mat32 differences() {
    const double a = std::sqrt(0.5), b = std::sqrt(1.0 / 6.0);
    Mat32 B;
    B << a, b, -a, b, 0.0, -2.0 * b;
    return B;
}

/// Eigenvalues below `limit` become `raised`, as the assignment says [N/m].
constexpr double limit = 1e-6, raised = 1e-3;

struct Mode {
    double value;  ///< eigenvalue
    Vec4 vector;   ///< of length 1
};

/// The lowest eigenvalue of diag(0, d) + δ z zᵀ; nothing where more than that one may be below `limit`.
std::optional<Mode> lowest_mode(const AssignmentRest& plane, double delta) {
    const Eigen::Array3d d = plane.d.array(), zz = plane.z.tail<3>().array().square();
    const double z0z0 = plane.z(0) * plane.z(0);
    if (!(d(0) > limit)) return std::nullopt;
    // Between 0 and d the secular function falls for δ < 0: no root below `limit` where it is positive there.
    if (delta < 0.0 && !(1.0 - delta * z0z0 / limit + delta * (zz / (d - limit)).sum() > 0.0)) {
        return std::nullopt;
    }
    double x = 0.0;
    for (int k = 0;; ++k) {
        if (k == 20) return std::nullopt;
        const Eigen::Array3d below = 1.0 / (d - x);
        const double share = 1.0 + delta * (zz * below).sum();
        const double miss = x * share - delta * z0z0;
        const double slope = share + x * delta * (zz * below * below).sum();
        if (!(slope > 0.0)) return std::nullopt;
        const double change = miss / slope;
        x -= change;
        if (std::abs(change) <= 1e-15 * std::abs(x)) break;
    }
    if (!(x < d(0))) return std::nullopt;
    Mode mode{x, Vec4::Zero()};
    mode.vector(0) = plane.z(0);
    mode.vector.tail<3>() = -x * plane.z.tail<3>().array() / (d - x);
    mode.vector.normalize();
    return mode;
}

}  // namespace

AssignmentRest make_assignment_rest(const TriangleRest& rest) {
    Eigen::Matrix<double, 6, 6> H;
    Eigen::Matrix<double, 6, 1> turn;
    for (int i = 0; i < 3; ++i) {
        const Vec2 b = rest.b.row(i);
        turn.segment<2>(2 * i) << -b.y(), b.x();
    }
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const Vec2 bi = rest.b.row(i), bj = rest.b.row(j);
            H.block<2, 2>(2 * i, 2 * j) =
                rest.volume *
                (2.0 * rest.mu * bi.dot(bj) * Mat2::Identity() + rest.lambda * bi * bj.transpose() -
                 rest.mu * turn.segment<2>(2 * i) * turn.segment<2>(2 * j).transpose());
        }
    }
    const Mat32 B = differences();
    Eigen::Matrix<double, 6, 4> P = Eigen::Matrix<double, 6, 4>::Zero();
    for (int i = 0; i < 3; ++i) {
        for (int k = 0; k < 2; ++k) P.block<2, 2>(2 * i, 2 * k) = B(i, k) * Mat2::Identity();
    }
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(P.transpose() * H * P);
    AssignmentRest plane;
    plane.d = solver.eigenvalues().tail<3>();
    plane.basis = P * solver.eigenvectors();
    plane.z = std::sqrt(rest.volume) * plane.basis.transpose() * turn;
    return plane;
}

Mat9 fixed_assignment_hessian(const TriangleRest& rest, const AssignmentRest& plane, const Vec9& q9) {
    const MembraneKinematics k(rest, q9);
    const double delta = (rest.mu + rest.lambda) * (k.I - 2.0) / k.I;
    const auto mode = k.I > 0.1 ? lowest_mode(plane, delta) : std::nullopt;
    const double det = k.G.col(0).cross(k.G.col(1)).norm();  // s0 s1
    if (!mode || !(det > 1e-3)) {
        return d2V_membrane_corotational_dq2(rest.dphi, q9, rest.volume, rest.mu, rest.lambda);
    }
    Eigen::Matrix<double, 2, 3> turn, lifted;  // Q b_i, and the lowest mode's in-plane coordinates
    turn.row(0) = -rest.b.col(1).transpose();
    turn.row(1) = rest.b.col(0).transpose();
    const bool fix = mode->value < limit;
    const double lift = fix ? raised - mode->value : 0.0;
    lifted.reshaped() = plane.basis * mode->vector;

    // Along n, with S⁻¹ of the symmetric S = RᵀG.
    const double psi2 = rest.lambda * (k.I - 2.0), c = psi2 - 2.0 * rest.mu, t = delta - rest.mu;
    const Mat2 S = k.R.transpose() * k.G;
    const Mat2 K = of_eigenvalues(S, [&](double s) { return 2.0 * rest.mu + (c + psi2 / s) / s; });
    static const Mat32 B = differences();
    const Mat2 T = B.transpose() * rest.b;
    const Mat2 along_n =
        of_eigenvalues(rest.volume * T * K * T.transpose(), [](double v) { return v < limit ? raised : v; });
    const Mat3 normal = B * along_n * B.transpose();

    const Mat3 nn = k.n * k.n.transpose();
    const Mat3 bb = rest.b * rest.b.transpose();
    Mat9 H;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            Mat2 in_plane = rest.volume * (rest.lambda * rest.b.row(i).transpose() * rest.b.row(j) +
                                           t * turn.col(i) * turn.col(j).transpose());
            in_plane.diagonal().array() += rest.volume * 2.0 * rest.mu * bb(i, j);
            in_plane += lift * lifted.col(i) * lifted.col(j).transpose();
            Mat3 block = k.R * in_plane * k.R.transpose() + normal(i, j) * nn;
            block.diagonal().array() += raised / 3.0;
            H.block<3, 3>(3 * i, 3 * j) = block;
            if (i != j) H.block<3, 3>(3 * j, 3 * i) = block.transpose();
        }
    }
    return H;
}

}  // namespace cloth
