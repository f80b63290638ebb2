#pragma once
// The checks that every energy must pass, and the numerical derivatives they use.

#include <cmath>
#include <functional>
#include <random>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <catch2/catch.hpp>

#include "sim/energies/energy.h"

namespace cloth::testing {

/// d value/d x by central differences of 8th order. With f's rounding ε the error is about ε/h + h⁸.
inline VecX numerical_gradient(const std::function<double(const VecX&)>& f, const VecX& x, double h) {
    VecX g(x.size());
    for (int i = 0; i < x.size(); ++i) {
        auto at = [&](double s) {
            VecX y = x;
            y(i) += s * h;
            return f(y);
        };
        g(i) = (4.0 / 5.0 * (at(1) - at(-1)) - 1.0 / 5.0 * (at(2) - at(-2)) + 4.0 / 105.0 * (at(3) - at(-3)) -
                1.0 / 280.0 * (at(4) - at(-4))) /
               h;
    }
    return g;
}

/// Jacobian of a gradient, by the same rule.
inline Eigen::MatrixXd numerical_jacobian(const std::function<VecX(const VecX&)>& f, const VecX& x,
                                          double h) {
    Eigen::MatrixXd J(x.size(), x.size());
    for (int i = 0; i < x.size(); ++i) {
        auto at = [&](double s) {
            VecX y = x;
            y(i) += s * h;
            return f(y);
        };
        J.col(i) = (4.0 / 5.0 * (at(1) - at(-1)) - 1.0 / 5.0 * (at(2) - at(-2)) +
                    4.0 / 105.0 * (at(3) - at(-3)) - 1.0 / 280.0 * (at(4) - at(-4))) /
                   h;
    }
    return J;
}

inline double smallest_eigenvalue(const Eigen::MatrixXd& H) {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(H, Eigen::EigenvaluesOnly).eigenvalues()(0);
}

inline Eigen::MatrixXd dense(const BlockPattern& pattern, const BlockMatrix& H) {
    const int n = pattern.vertex_count();
    Eigen::MatrixXd D = Eigen::MatrixXd::Zero(3 * n, 3 * n);
    for (int i = 0; i < n; ++i) {
        for (int s = pattern.row_begin[i]; s < pattern.row_begin[i + 1]; ++s) {
            const int j = pattern.column[s];
            D.block<3, 3>(3 * i, 3 * j) = H.blocks[s];
            D.block<3, 3>(3 * j, 3 * i) = H.blocks[s].transpose();
        }
    }
    return D;
}

inline Mat3 random_rotation(std::mt19937& random) {
    std::normal_distribution<double> normal;
    const Eigen::Quaterniond q(normal(random), normal(random), normal(random), normal(random));
    return q.normalized().toRotationMatrix();
}

struct Battery {
    double length = 0.1;            ///< size of an element [m]: sets the difference step
    double force_scale = 1.0;       ///< [N] for the floor of the gradient's error
    double stiffness_scale = 1.0;   ///< [N/m] for the floor of the Hessian's error
    bool projection_adds = true;    ///< projected - exact ≥ 0; not where a part of either sign is left out
    bool curved = true;             ///< has second derivatives; not gravity
    bool rigid_motion_free = true;  ///< energies of deformation; not gravity, not springs to a fixed target
};

/// Runs the battery on `energy` at each state. Tolerances: gradient 1e-9, Hessian by differences of the
/// gradient 1e-8, of the larger of the scale given and the value's own size.
///
/// The check is checked too: at some state the derivatives are far larger than those tolerances (a thousandth
/// of the scales), and where there are any, the two routes to them differ in their last bits: neither is the
/// other in disguise.
inline void check_energy(Energy& energy, int vertex_count, const std::vector<VecX>& states,
                         const Battery& b) {
    std::vector<std::array<int, 2>> pairs;
    energy.append_pairs(pairs);
    const BlockPattern pattern(vertex_count, pairs);
    energy.bind(pattern);
    auto gradient = [&](const VecX& x) {
        VecX g = VecX::Zero(x.size());
        energy.add_gradient(x, g);
        return g;
    };
    auto hessian = [&](const VecX& x, HessianKind kind) {
        BlockMatrix H;
        H.reset(pattern);
        energy.add_hessian(x, kind, H);
        return dense(pattern, H);
    };
    std::mt19937 random(7);
    double largest_gradient = 0.0, largest_hessian = 0.0;
    for (std::size_t k = 0; k < states.size(); ++k) {
        CAPTURE(energy.name(), k);
        const VecX& x = states[k];
        const VecX g = gradient(x);
        const VecX numerical =
            numerical_gradient([&](const VecX& y) { return energy.value(y); }, x, 3e-3 * b.length);
        const double g_scale = std::max(b.force_scale, g.cwiseAbs().maxCoeff());
        CHECK((g - numerical).cwiseAbs().maxCoeff() < 1e-9 * g_scale);
        CHECK((g.isZero(0.0) || g != numerical));
        largest_gradient = std::max(largest_gradient, g.cwiseAbs().maxCoeff());

        const Eigen::MatrixXd exact = hessian(x, HessianKind::exact);
        const Eigen::MatrixXd H = hessian(x, HessianKind::projected);
        const double H_scale = std::max(b.stiffness_scale, exact.cwiseAbs().maxCoeff());
        const Eigen::MatrixXd differences = numerical_jacobian(gradient, x, 3e-3 * b.length);
        CHECK((exact - differences).cwiseAbs().maxCoeff() < 1e-8 * H_scale);
        CHECK((exact.isZero(0.0) || exact != differences));
        largest_hessian = std::max(largest_hessian, exact.cwiseAbs().maxCoeff());
        CHECK((H - H.transpose()).cwiseAbs().maxCoeff() <= 1e-14 * H_scale);
        CHECK(smallest_eigenvalue(H) > -1e-12 * H_scale);
        if (b.projection_adds) CHECK(smallest_eigenvalue(H - exact) > -1e-12 * H_scale);

        if (b.rigid_motion_free) {
            const Mat3 R = random_rotation(random);
            const Vec3 t(0.3, -1.2, 2.5);
            VecX moved(x.size()), turned(x.size());
            for (int i = 0; i < vertex_count; ++i) {
                moved.segment<3>(3 * i) = R * x.segment<3>(3 * i) + t;
                turned.segment<3>(3 * i) = R * g.segment<3>(3 * i);
            }
            const double e_scale = b.force_scale * b.length + std::abs(energy.value(x));
            CHECK(std::abs(energy.value(moved) - energy.value(x)) < 1e-11 * e_scale);
            CHECK((gradient(moved) - turned).cwiseAbs().maxCoeff() < 1e-11 * g_scale);
        }
    }
    CAPTURE(energy.name());
    CHECK(largest_gradient > 1e-3 * b.force_scale);
    CHECK((largest_hessian > 1e-3 * b.stiffness_scale) == b.curved);
}

}  // namespace cloth::testing
