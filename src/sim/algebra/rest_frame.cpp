#include "sim/algebra/rest_frame.h"

#include <Eigen/Dense>

namespace cloth {

RestFrame make_rest_frame(const Vec3& X0, const Vec3& X1, const Vec3& X2, const Vec3& warp) {
    RestFrame frame;
    const Vec3 area_normal = (X1 - X0).cross(X2 - X0);
    frame.normal = area_normal.normalized();
    frame.t0 = warp - frame.normal * frame.normal.dot(warp);
    if (!(frame.t0.norm() > 1e-6 * warp.norm())) frame.t0 = X1 - X0;
    frame.t0.normalize();
    frame.t1 = frame.normal.cross(frame.t0);
    frame.area = 0.5 * area_normal.norm();
    return frame;
}

Mat32 shape_gradients(const RestFrame& frame, const Vec3& X0, const Vec3& X1, const Vec3& X2) {
    Mat2 Dm;
    Dm << frame.in_plane(X1 - X0), frame.in_plane(X2 - X0);
    Mat32 b;
    b.bottomRows<2>() = Dm.inverse();
    b.row(0) = -b.row(1) - b.row(2);
    return b;
}

}  // namespace cloth
