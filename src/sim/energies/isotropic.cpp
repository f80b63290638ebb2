#include "sim/energies/isotropic.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "sim/algebra/symmetric.h"

namespace cloth {
namespace {

/// Singular value decomposition of G = Σ s_i u_i v_iᵀ, s0 ≥ s1 ≥ 0, with the normal u0 × u1.
struct Stretches {
    double s0, s1;
    Mat32 U;
    Mat2 V;
    Vec3 n;

    explicit Stretches(const Mat32& G) {
        const Vec3 g0 = G.col(0), g1 = G.col(1);
        // Half the angle of C = GᵀG by half-angle formulas: no functions of the C library.
        const double half = 0.5 * (g0.squaredNorm() - g1.squaredNorm()), shear = g0.dot(g1);
        const double radius = std::sqrt(half * half + shear * shear);
        double c = 1.0, s = 0.0;
        if (radius > 0.0) {
            const double cosine = half / radius;
            if (cosine > 0.0) {
                c = std::sqrt(0.5 * (1.0 + cosine));
                s = 0.5 * shear / radius / c;
            } else {
                s = std::sqrt(0.5 * (1.0 - cosine));
                c = 0.5 * shear / radius / s;
            }
        }
        V << c, -s, s, c;
        const Vec3 w0 = G * V.col(0), w1 = G * V.col(1);
        s0 = w0.norm();
        s1 = w1.norm();
        U.col(0) = s0 > 0.0 ? Vec3(w0 / s0) : Vec3(Vec3::UnitX());
        // w1 is perpendicular to w0 but for rounding, which matters where s1 is small.
        Vec3 across = w1 - U.col(0) * U.col(0).dot(w1);
        if (!(across.norm() > 1e-12 * s0)) across = U.col(0).unitOrthogonal();
        U.col(1) = across.normalized();
        n = U.col(0).cross(U.col(1));
    }
};

constexpr double smallest_stretch = 1e-9;

Mat32 deformation(const TriangleRest& rest, const Vec9& q9) {
    return q9.reshaped(3, 3) * rest.b;
}

/// s0², the greater of the two.
double greatest_squared(const Mat32& G) {
    const double a = G.col(0).squaredNorm(), b = G.col(1).squaredNorm(), shear = G.col(0).dot(G.col(1));
    const double half = 0.5 * (a - b);
    return 0.5 * (a + b) + std::sqrt(half * half + shear * shear);
}

template <class Law>
Vec9 element_gradient(const TriangleRest& rest, const Law& law, const Vec9& q9) {
    const Stretches k(deformation(rest, q9));
    const StretchDerivatives d = law.derivatives(k.s0, k.s1);
    const Mat32 P = rest.volume *
                    (d.d0 * k.U.col(0) * k.V.col(0).transpose() + d.d1 * k.U.col(1) * k.V.col(1).transpose());
    Vec9 gradient;
    gradient.reshaped(3, 3).noalias() = P * rest.b.transpose();
    return gradient;
}

template <class Law>
Mat9 element_hessian(const TriangleRest& rest, const Law& law, const Vec9& q9, bool project) {
    const Stretches k(deformation(rest, q9));
    const StretchDerivatives d = law.derivatives(k.s0, k.s1);
    const Eigen::Matrix<double, 2, 3> vb = k.V.transpose() * rest.b.transpose();  // row i: v_i · b_j
    auto clamp = [&](double value) { return project ? std::max(value, 0.0) : value; };
    // 9-vectors of the modes u v_iᵀ.
    auto mode = [&](const Vec3& u, int i) {
        Vec9 m;
        m.reshaped(3, 3).noalias() = u * vb.row(i);
        return m;
    };
    const Vec3 u0 = k.U.col(0), u1 = k.U.col(1);
    const Vec9 a = mode(u0, 0), b = mode(u1, 1), e = mode(u1, 0), f = mode(u0, 1);
    Mat2 scaling;
    scaling << d.d00, d.d01, d.d01, d.d11;
    if (project) scaling = positive_part(scaling);
    Mat9 H = scaling(0, 0) * a * a.transpose() + scaling(1, 1) * b * b.transpose() +
             scaling(0, 1) * (a * b.transpose() + b * a.transpose());
    const Vec9 twist = e - f, flip = e + f;
    H += 0.5 * clamp(d.twist) * twist * twist.transpose() + 0.5 * clamp(d.flip) * flip * flip.transpose();
    const Vec9 n0 = mode(k.n, 0), n1 = mode(k.n, 1);
    H += clamp(d.d0 / std::max(k.s0, smallest_stretch)) * n0 * n0.transpose() +
         clamp(d.d1 / std::max(k.s1, smallest_stretch)) * n1 * n1.transpose();
    return rest.volume * H;
}

/// b(y) = y³/(1-y) and its derivatives.
struct Barrier {
    double value = 0.0, first = 0.0, second = 0.0;
    explicit Barrier(double y) {
        if (y <= 0.0) return;
        const double z = 1.0 - y;
        if (z <= 0.0) {
            value = first = second = std::numeric_limits<double>::infinity();
            return;
        }
        value = y * y * y / z;
        first = y * y * (3.0 - 2.0 * y) / (z * z);
        second = y * (6.0 - 6.0 * y + 2.0 * y * y) / (z * z * z);
    }
};

}  // namespace

double NeoHookean::value(double s0, double s1) const {
    // μ/2 (s0² + s1² - 2) - μ (J-1) = μ/2 (s0 - s1)², the form that loses no digits near rest.
    const double dilation = s0 * s1 - 1.0;
    return 0.5 * mu * (s0 - s1) * (s0 - s1) + 0.5 * (mu + lambda) * dilation * dilation;
}

StretchDerivatives NeoHookean::derivatives(double s0, double s1) const {
    const double bulk = mu + lambda, pressure = bulk * (s0 * s1 - 1.0);
    return {.d0 = mu * (s0 - s1) + pressure * s1,
            .d1 = mu * (s1 - s0) + pressure * s0,
            .d00 = mu + bulk * s1 * s1,
            .d01 = -mu + pressure + bulk * s0 * s1,
            .d11 = mu + bulk * s0 * s0,
            .twist = pressure,
            .flip = 2.0 * mu - pressure};
}

bool StrainLimit::idle(double greatest_squared) const {
    const double start = 0.5 * (1.0 + limit);
    return greatest_squared <= start * start;
}

double StrainLimit::value(double s0, double s1) const {
    const double start = 0.5 * (1.0 + limit), w = limit - start;
    return stiffness * w * w * (Barrier((s0 - start) / w).value + Barrier((s1 - start) / w).value);
}

StretchDerivatives StrainLimit::derivatives(double s0, double s1) const {
    const double start = 0.5 * (1.0 + limit), w = limit - start;
    const Barrier b0((s0 - start) / w), b1((s1 - start) / w);
    const double sum = std::max(s0 + s1, smallest_stretch), difference = s0 - s1;
    // Where the stretches nearly agree, their mean's second derivative: the error is quadratic in y0 - y1.
    const double flip = difference > 1e-5 * w ? w * (b0.first - b1.first) / difference
                                              : Barrier((0.5 * (s0 + s1) - start) / w).second;
    return {.d0 = stiffness * w * b0.first,
            .d1 = stiffness * w * b1.first,
            .d00 = stiffness * b0.second,
            .d01 = 0.0,
            .d11 = stiffness * b1.second,
            .twist = stiffness * w * (b0.first + b1.first) / sum,
            .flip = stiffness * flip};
}

template <class Law>
IsotropicEnergy<Law>::IsotropicEnergy(std::string_view name, std::vector<std::array<int, 3>> triangles,
                                      std::vector<TriangleRest> rest, std::vector<Law> laws)
    : name_(name), elements_(std::move(triangles)), rest_(std::move(rest)), laws_(std::move(laws)) {}

template <class Law>
bool IsotropicEnergy<Law>::idle(const VecX& x, int t) const {
    if constexpr (requires { laws_[t].idle(0.0); }) {
        return laws_[t].idle(greatest_squared(deformation(rest_[t], elements_.gather(x, t))));
    } else {
        return false;
    }
}

template <class Law>
double IsotropicEnergy<Law>::value(const VecX& x) const {
    return elements_.sum([&](int t) {
        if (idle(x, t)) return 0.0;
        const Stretches k(deformation(rest_[t], elements_.gather(x, t)));
        return rest_[t].volume * laws_[t].value(k.s0, k.s1);
    });
}

template <class Law>
void IsotropicEnergy<Law>::add_gradient(const VecX& x, VecX& g) const {
    elements_.add_gradient(
        g, [&](int t) { return element_gradient(rest_[t], laws_[t], elements_.gather(x, t)); },
        [&](int t) { return idle(x, t); });
}

template <class Law>
void IsotropicEnergy<Law>::add_hessian(const VecX& x, HessianKind kind, BlockMatrix& H) const {
    elements_.add_hessian(
        H,
        [&](int t) {
            return element_hessian(rest_[t], laws_[t], elements_.gather(x, t), kind != HessianKind::exact);
        },
        [&](int t) { return idle(x, t); });
}

template class IsotropicEnergy<NeoHookean>;
template class IsotropicEnergy<StrainLimit>;

}  // namespace cloth
