#include "sim/energies/membrane.h"

#include <algorithm>
#include <cmath>

#include "sim/algebra/rest_frame.h"
#include "sim/algebra/symmetric.h"
#include "sim/assignment/assignment.h"

namespace cloth {
namespace {

/// ψ_i / s_i is kept finite for a triangle squeezed to a line.
constexpr double smallest_stretch = 1e-9;

/// K = 2μ 1 + c S⁻¹ in the rest frame; its eigenvalues are ψ_i/s_i. `project` clamps them at 0.
Mat2 normal_stiffness(const TriangleRest& rest, const MembraneKinematics& k, double c, bool project) {
    // S = RᵀG is symmetric; its eigenvalues are the stretches.
    const Mat2 S = k.R.transpose() * k.G;
    return of_eigenvalues(S, [&](double s) {
        const double value = 2.0 * rest.mu + c / std::max(s, smallest_stretch);
        return project ? std::max(value, 0.0) : value;
    });
}

}  // namespace

MembraneKinematics::MembraneKinematics(const TriangleRest& rest, const Vec9& q9) {
    G.noalias() = q9.reshaped(3, 3) * rest.b;
    const Vec3 area_normal = G.col(0).cross(G.col(1));
    const double J = area_normal.norm();
    n = J > 0.0 ? Vec3(area_normal / J) : Vec3(Vec3::Zero());
    // R = (G + J G^-T)/I, where J G^-T = [g1 × n, n × g0] needs no division. The norms of G ± J G^-T are
    // √2 (s0 ± s1); unlike tr C ± 2J they lose no digits near rest.
    Mat32 cofactor;
    cofactor.col(0) = G.col(1).cross(n);
    cofactor.col(1) = n.cross(G.col(0));
    R = G + cofactor;
    I = std::sqrt(0.5 * R.squaredNorm());
    D2 = 0.5 * (G - cofactor).squaredNorm();
    R /= I > 0.0 ? I : 1.0;
}

TriangleRest make_triangle_rest(const Vec3& X0, const Vec3& X1, const Vec3& X2, double thickness, double mu,
                                double lambda) {
    const RestFrame frame = make_rest_frame(X0, X1, X2);
    TriangleRest rest;
    rest.b = shape_gradients(frame, X0, X1, X2);
    rest.volume = frame.area * thickness;
    rest.mu = mu;
    rest.lambda = lambda;
    rest.dphi = dphi_cloth_triangle_dX(X0, X1, X2);
    return rest;
}

double membrane_energy(const TriangleRest& rest, const Vec9& q9) {
    const MembraneKinematics k(rest, q9);
    const double dilation = k.I - 2.0;
    // μ Σ(s_i - 1)² = μ/2 ((I-2)² + (s0-s1)²), the form that loses no digits near rest.
    return 0.5 * rest.volume * ((rest.mu + rest.lambda) * dilation * dilation + rest.mu * k.D2);
}

Vec9 membrane_gradient(const TriangleRest& rest, const Vec9& q9) {
    const MembraneKinematics k(rest, q9);
    const double c = rest.lambda * (k.I - 2.0) - 2.0 * rest.mu;
    const Mat32 P = rest.volume * (2.0 * rest.mu * k.G + c * k.R);
    Vec9 gradient;
    gradient.reshaped(3, 3).noalias() = P * rest.b.transpose();
    return gradient;
}

Mat9 membrane_hessian(const TriangleRest& rest, const Vec9& q9, bool project) {
    const MembraneKinematics k(rest, q9);
    const double c = rest.lambda * (k.I - 2.0) - 2.0 * rest.mu;
    double twist = c / std::max(k.I, smallest_stretch);
    if (project) twist = std::max(twist, -rest.mu);
    const Mat2 K = normal_stiffness(rest, k, c, project);
    const Mat3 nn = k.n * k.n.transpose();
    const Mat3 in_plane = Mat3::Identity() - nn;

    const Mat3 Rb = k.R * rest.b.transpose();  // column i: R b_i
    Mat32 RQ;                                  // R Q, Q = quarter turn (x, y) → (-y, x)
    RQ.col(0) = k.R.col(1);
    RQ.col(1) = -k.R.col(0);
    const Mat3 RQb = RQ * rest.b.transpose();
    const Mat3 bb = rest.b * rest.b.transpose();
    const Mat3 bKb = rest.b * K * rest.b.transpose();

    Mat9 H;
    for (int i = 0; i < 3; ++i) {
        for (int j = i; j < 3; ++j) {
            const Mat3 block = rest.volume * (2.0 * rest.mu * bb(i, j) * in_plane +
                                              rest.lambda * Rb.col(i) * Rb.col(j).transpose() +
                                              twist * RQb.col(i) * RQb.col(j).transpose() + bKb(i, j) * nn);
            H.block<3, 3>(3 * i, 3 * j) = block;
            if (i != j) H.block<3, 3>(3 * j, 3 * i) = block.transpose();
        }
    }
    return H;
}

double membrane_stretch(const TriangleRest& rest, const Vec9& q9) {
    const MembraneKinematics k(rest, q9);
    return 0.5 * (k.I + std::sqrt(k.D2));
}

double largest_stretch(const Triangles& triangles, const std::vector<TriangleRest>& rest, const VecX& x) {
    return parallel_max(static_cast<int>(rest.size()), 0.0, [&](int t) {
        Vec9 q9;
        for (int i = 0; i < 3; ++i) q9.segment<3>(3 * i) = x.segment<3>(3 * triangles(t, i));
        return membrane_stretch(rest[t], q9);
    });
}

MembraneEnergy::MembraneEnergy(std::vector<std::array<int, 3>> triangles, std::vector<TriangleRest> rest)
    : elements_(std::move(triangles)), rest_(std::move(rest)) {
    for (const TriangleRest& r : rest_) plane_.push_back(make_assignment_rest(r));
}

double MembraneEnergy::value(const VecX& x) const {
    return elements_.sum([&](int t) { return membrane_energy(rest_[t], elements_.gather(x, t)); });
}

void MembraneEnergy::add_gradient(const VecX& x, VecX& g) const {
    elements_.add_gradient(g, [&](int t) { return membrane_gradient(rest_[t], elements_.gather(x, t)); });
}

void MembraneEnergy::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    elements_.add_hessian(H, [&](int t) -> Mat9 {
        const Vec9 q9 = elements_.gather(x, t);
        return kind == HessianKind::assignment
                   ? fixed_assignment_hessian(rest_[t], plane_[t], q9)
                   : membrane_hessian(rest_[t], q9, kind == HessianKind::projected);
    });
}

}  // namespace cloth
