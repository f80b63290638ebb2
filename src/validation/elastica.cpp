#include "validation/elastica.h"

#include <cmath>
#include <numbers>
#include <vector>

#include <Eigen/Dense>
#include <Eigen/Eigenvalues>

namespace cloth::validation {
namespace {

struct Shot {
    double root_angle;  ///< φ at the clamp, from the vertical
    double drop, span;
};

/// From the tip, φ = δ and φ' = 0 with φ = π/2 - θ, to the clamp. s = 1 - σ: φ'' = Γ s sin φ.
Shot shoot(double gamma, double log_delta) {
    constexpr int steps = 40000;
    const double h = 1.0 / steps;
    double phi = std::exp(log_delta), rate = 0.0, drop = 0.0, span = 0.0;
    for (int i = 0; i < steps; ++i) {
        const double s = i * h;
        auto f = [&](double at, double p) { return gamma * at * std::sin(p); };
        const double k1 = rate, l1 = f(s, phi);
        const double k2 = rate + 0.5 * h * l1, l2 = f(s + 0.5 * h, phi + 0.5 * h * k1);
        const double k3 = rate + 0.5 * h * l2, l3 = f(s + 0.5 * h, phi + 0.5 * h * k2);
        const double k4 = rate + h * l3, l4 = f(s + h, phi + h * k3);
        const double middle = phi + 0.5 * h * k2;  // at s + h/2
        const double next = phi + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
        drop += h / 6.0 * (std::cos(phi) + 4.0 * std::cos(middle) + std::cos(next));
        span += h / 6.0 * (std::sin(phi) + 4.0 * std::sin(middle) + std::sin(next));
        phi = next;
        rate += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        if (phi > 3.2) return {phi, drop, span};  // past the vertical: δ is too large
    }
    return {phi, drop, span};
}

}  // namespace

Elastica heavy_elastica(double gamma) {
    constexpr double right_angle = 0.5 * std::numbers::pi;
    double low = -200.0, high = std::log(right_angle);
    for (int i = 0; i < 80; ++i) {
        const double middle = 0.5 * (low + high);
        (shoot(gamma, middle).root_angle < right_angle ? low : high) = middle;
    }
    const Shot shot = shoot(gamma, 0.5 * (low + high));
    return {shot.drop, shot.span};
}

double lateral_buckling_load(double b) {
    // Length 1, D = 1, load p per area; the stress field for p = 1.
    struct Term {
        int i, j;  // x^i y^j; i = -1: x - a (1 - exp(-x/a)), a twist that starts within the clamp's layer
    };
    std::vector<Term> terms;
    for (int j = 0; j < 4; ++j) {
        for (int i = 2; i < 10; ++i) terms.push_back({i, j});
        if (j % 2 == 1) terms.push_back({-1, j});
    }
    const double layer =
        b / std::sqrt(24.0);  // where warping dies out: D b^3/12 times the fourth derivative = 2 D b
    const int n = static_cast<int>(terms.size());
    Eigen::MatrixXd stiffness = Eigen::MatrixXd::Zero(n, n), work = stiffness;
    std::vector<double> panels{0.0};
    for (double x = layer; x < 0.5; x *= 2.0) panels.push_back(x);
    panels.push_back(1.0);
    // Gauss-Legendre nodes by Newton's method on P_m.
    constexpr int m = 16;
    std::vector<double> node(m), weight(m);
    for (int k = 0; k < m; ++k) {
        double x = std::cos(std::numbers::pi * (k + 0.75) / (m + 0.5)), slope = 1.0;
        for (int it = 0; it < 50; ++it) {
            double p0 = 1.0, p1 = x;
            for (int l = 2; l <= m; ++l) {
                const double p2 = ((2 * l - 1) * x * p1 - (l - 1) * p0) / l;
                p0 = p1;
                p1 = p2;
            }
            slope = m * (x * p1 - p0) / (x * x - 1.0);
            x -= p1 / slope;
        }
        node[k] = x;
        weight[k] = 2.0 / ((1.0 - x * x) * slope * slope);
    }
    for (std::size_t kx = 0; kx < m * (panels.size() - 1); ++kx) {
        const double from = panels[kx / m], to = panels[kx / m + 1];
        for (int ky = 0; ky < m; ++ky) {
            const double x = from + 0.5 * (to - from) * (node[kx % m] + 1.0), y = 0.5 * b * node[ky];
            const double area = 0.5 * (to - from) * weight[kx % m] * 0.5 * b * weight[ky];
            // Gravity along -y, weight b per length; exact plane-stress field of the heavy cantilever.
            const double rest = 1.0 - x;
            const double Nxx = 6.0 * rest * rest * y / (b * b) - 4.0 * y * y * y / (b * b) + 0.6 * y;
            const double Nxy = -6.0 * rest / (b * b) * (0.25 * b * b - y * y);
            const double Nyy = -0.5 * y + 2.0 * y * y * y / (b * b);
            Eigen::VectorXd wx(n), wy(n), wxx(n), wxy(n), wyy(n);
            for (int t = 0; t < n; ++t) {
                const auto [i, j] = terms[t];
                // y scaled by the half width keeps the matrices well conditioned.
                const double u = y / (0.5 * b), s = 1.0 / (0.5 * b);
                double X = std::pow(x, i), X1 = i * std::pow(x, i - 1), X2 = i * (i - 1) * std::pow(x, i - 2);
                if (i < 0) {
                    const double decay = std::exp(-x / layer);
                    X = x - layer * (1.0 - decay);
                    X1 = 1.0 - decay;
                    X2 = decay / layer;
                }
                const double Y = std::pow(u, j), Y1 = j > 0 ? s * j * std::pow(u, j - 1) : 0.0;
                const double Y2 = j > 1 ? s * s * j * (j - 1) * std::pow(u, j - 2) : 0.0;
                wx(t) = X1 * Y;
                wy(t) = X * Y1;
                wxx(t) = X2 * Y;
                wxy(t) = X1 * Y1;
                wyy(t) = X * Y2;
            }
            stiffness += area * (wxx * wxx.transpose() + wyy * wyy.transpose() + 2.0 * wxy * wxy.transpose());
            work -= area * (Nxx * wx * wx.transpose() + Nyy * wy * wy.transpose() +
                            Nxy * (wx * wy.transpose() + wy * wx.transpose()));
        }
    }
    // p is critical where stiffness - p work is singular: 1/p is the largest eigenvalue of work against
    // stiffness.
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> solver(work, stiffness);
    const double p = 1.0 / solver.eigenvalues().maxCoeff();
    // w = p b; √(B C) = √2 b.
    return p * b / (std::numbers::sqrt2 * b);
}

}  // namespace cloth::validation
