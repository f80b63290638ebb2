#include "sim/contact/mollifier.h"

namespace cloth {

Mollifier mollify(double c, double c0) {
    const double z = c / c0;
    if (!(c0 > 0.0) || z >= 1.0) return {};
    return {(2.0 - z) * z, (2.0 - 2.0 * z) / c0, -2.0 / (c0 * c0)};
}

double mollifier_threshold(const FourPoints& rest) {
    return 1e-3 * (rest[1] - rest[0]).squaredNorm() * (rest[3] - rest[2]).squaredNorm();
}

double cross_squared(const FourPoints& x) {
    return (x[1] - x[0]).cross(x[3] - x[2]).squaredNorm();
}

CrossSquared cross_squared_derivatives(const FourPoints& x) {
    const Vec3 e = x[1] - x[0], f = x[3] - x[2];
    const double ee = e.squaredNorm(), ff = f.squaredNorm(), ef = e.dot(f);
    const Vec3 ge = 2.0 * (ff * e - ef * f), gf = 2.0 * (ee * f - ef * e);
    const Mat3 I = Mat3::Identity();
    const Mat3 Hee = 2.0 * (ff * I - f * f.transpose()), Hff = 2.0 * (ee * I - e * e.transpose());
    const Mat3 Hef = 4.0 * e * f.transpose() - 2.0 * f * e.transpose() - 2.0 * ef * I;
    CrossSquared c;
    c.value = cross_squared(x);
    c.gradient << -ge, ge, -gf, gf;
    const double s[2] = {-1.0, 1.0};
    for (int i = 0; i < 2; ++i) {
        for (int j = 0; j < 2; ++j) {
            c.hessian.block<3, 3>(3 * i, 3 * j) = s[i] * s[j] * Hee;
            c.hessian.block<3, 3>(6 + 3 * i, 6 + 3 * j) = s[i] * s[j] * Hff;
            c.hessian.block<3, 3>(3 * i, 6 + 3 * j) = s[i] * s[j] * Hef;
            c.hessian.block<3, 3>(6 + 3 * j, 3 * i) = s[i] * s[j] * Hef.transpose();
        }
    }
    return c;
}

}  // namespace cloth
