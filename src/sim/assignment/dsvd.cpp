#include <Eigen/SVD>

#include "sim/assignment/assignment.h"

namespace cloth {

SvdDerivatives dsvd(const Mat3& F) {
    const Eigen::JacobiSVD<Mat3, Eigen::NoQRPreconditioner> svd(F, Eigen::ComputeFullU | Eigen::ComputeFullV);
    SvdDerivatives d{svd.matrixU(), svd.singularValues(), svd.matrixV(), {}, {}, {}};
    const double tolerance = 1e-10 * d.S(0);
    for (int i = 0; i < 3; ++i) {
        for (int j = 0; j < 3; ++j) {
            const Mat3 A = d.U.row(i).transpose() * d.V.row(j);
            Mat3 turn_u = Mat3::Zero(), turn_v = Mat3::Zero();
            for (int k = 0; k < 3; ++k) {
                for (int l = k + 1; l < 3; ++l) {
                    const double gap = d.S(l) - d.S(k), sum = d.S(k) + d.S(l);
                    const double together = -gap > tolerance ? (A(k, l) + A(l, k)) / gap : 0.0;
                    const double apart = sum > tolerance ? (A(k, l) - A(l, k)) / sum : 0.0;
                    turn_u(k, l) = 0.5 * (together + apart);
                    turn_u(l, k) = -turn_u(k, l);
                    turn_v(k, l) = 0.5 * (together - apart);
                    turn_v(l, k) = -turn_v(k, l);
                }
            }
            const Mat3 dU = d.U * turn_u, dV = d.V * turn_v;
            for (int a = 0; a < 3; ++a) {
                d.dS[a](i, j) = A(a, a);
                for (int b = 0; b < 3; ++b) {
                    d.dU[a][b](i, j) = dU(a, b);
                    d.dV[a][b](i, j) = dV(a, b);
                }
            }
        }
    }
    return d;
}

}  // namespace cloth
