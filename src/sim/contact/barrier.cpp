#include "sim/contact/barrier.h"

#include <cmath>
#include <limits>

#include <Eigen/Eigenvalues>

#include "sim/contact/mollifier.h"

namespace cloth {
namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

/// Changes of the weights that shift the nearest points by orthonormal tangents.
struct Tangents {
    int count = 0;
    std::array<std::array<double, 4>, 2> weights{};  ///< u_k
    std::array<Vec3, 2> directions;                  ///< t_k
};
Tangents tangents_of(const Nearest& n, const FourPoints& x) {
    Tangents t;
    for (int k = 0; k < n.slide_count; ++k) {
        std::array<double, 4> u = n.slides[k];
        Vec3 p = Vec3::Zero();
        for (int i = 0; i < 4; ++i) p += u[i] * x[i];
        const double full = p.norm();
        for (int m = 0; m < t.count; ++m) {
            const double share = p.dot(t.directions[m]);
            p -= share * t.directions[m];
            for (int i = 0; i < 4; ++i) u[i] -= share * t.weights[m][i];
        }
        const double length = p.norm();
        if (!(length > 1e-12 * full)) continue;
        for (double& w : u) w /= length;
        t.weights[t.count] = u;
        t.directions[t.count++] = p / length;
    }
    return t;
}

bool is_mollified(const Contact& c, const FourPoints& x) {
    return c.mollifier > 0.0 && cross_squared(x) < c.mollifier;
}

/// ∇d over the four points.
Vec12 distance_gradient(const Contact& c) {
    Vec12 g;
    for (int i = 0; i < 4; ++i) g.segment<3>(3 * i) = c.nearest.weights[i] * c.normal;
    return g;
}

/// Of the pair without its mollifier.
Mat12 plain_hessian(const Contact& c, const FourPoints& x, const BarrierValue& b, bool exact) {
    const auto& w = c.nearest.weights;
    const Vec12 gd = distance_gradient(c);
    Mat12 H = b.second * gd * gd.transpose();
    if (c.plane >= 0) return H;
    const Tangents t = tangents_of(c.nearest, x);
    Mat3 rest = Mat3::Identity() - c.normal * c.normal.transpose();
    for (int k = 0; k < t.count; ++k) {
        rest -= t.directions[k] * t.directions[k].transpose();
        Vec12 a, s;
        for (int i = 0; i < 4; ++i) {
            a.segment<3>(3 * i) = t.weights[k][i] * c.normal;
            s.segment<3>(3 * i) = w[i] * t.directions[k];
        }
        if (exact) {
            H -= b.first * (c.distance * a * a.transpose() + a * s.transpose() + s * a.transpose());
            continue;
        }
        const double aa = a.squaredNorm(), ss = s.squaredNorm();
        const double root = std::sqrt(c.distance * c.distance * aa * aa + 4.0 * aa * ss);
        const double eigenvalue = 0.5 * (c.distance * aa + root);
        if (!(eigenvalue > 0.0)) continue;
        // Eigenvector over (a/|a|, s/|s|): (λ, |a||s|), of length² λ² + |a|²|s|².
        const Vec12 v = eigenvalue / std::sqrt(aa) * a + std::sqrt(aa) * s;
        H += (-b.first * eigenvalue / (eigenvalue * eigenvalue + aa * ss)) * v * v.transpose();
    }
    if (exact) {
        for (int i = 0; i < 4; ++i) {
            for (int j = 0; j < 4; ++j) {
                H.block<3, 3>(3 * i, 3 * j) += b.first / c.distance * w[i] * w[j] * rest;
            }
        }
    }
    return H;
}

}  // namespace

BarrierValue barrier(double gap, double activation, double stiffness) {
    if (gap >= activation) return {0.0, 0.0, 0.0};
    if (!(gap > 0.0)) return {infinity, -infinity, infinity};
    const double z = gap / activation, y = 1.0 - z;
    return {
        stiffness * y * y * y / z, -stiffness / activation * y * y * (3.0 - 2.0 * y) / (z * z),
        stiffness / (activation * activation) * 2.0 * y * (3.0 * z * z + y * (3.0 - 2.0 * y)) / (z * z * z)};
}

double contact_value(const Contact& c, const FourPoints& x) {
    const double e = barrier(c.gap, c.activation, c.stiffness).value;
    if (!(c.mollifier > 0.0) || e == infinity) return e;
    return e * mollify(cross_squared(x), c.mollifier).value;
}

Vec12 contact_gradient(const Contact& c, const FourPoints& x) {
    const BarrierValue b = barrier(c.gap, c.activation, c.stiffness);
    Vec12 g;
    for (int i = 0; i < 4; ++i) g.segment<3>(3 * i) = b.first * c.nearest.weights[i] * c.normal;
    if (is_mollified(c, x)) {
        const CrossSquared cross = cross_squared_derivatives(x);
        const Mollifier m = mollify(cross.value, c.mollifier);
        g = m.value * g + m.first * b.value * cross.gradient;
    }
    return g;
}

Mat12 contact_hessian(const Contact& c, const FourPoints& x, HessianKind kind) {
    const BarrierValue b = barrier(c.gap, c.activation, c.stiffness);
    if (!is_mollified(c, x)) return plain_hessian(c, x, b, kind == HessianKind::exact);
    const CrossSquared cross = cross_squared_derivatives(x);
    const Mollifier m = mollify(cross.value, c.mollifier);
    const Vec12 gb = b.first * distance_gradient(c);
    const Mat12 H = m.value * plain_hessian(c, x, b, true) +
                    m.first * (cross.gradient * gb.transpose() + gb * cross.gradient.transpose()) +
                    (m.second * b.value) * cross.gradient * cross.gradient.transpose() +
                    (m.first * b.value) * cross.hessian;
    if (kind == HessianKind::exact) return H;
    const Eigen::SelfAdjointEigenSolver<Mat12> solver(H);
    return solver.eigenvectors() * solver.eigenvalues().cwiseMax(0.0).asDiagonal() *
           solver.eigenvectors().transpose();
}

}  // namespace cloth
