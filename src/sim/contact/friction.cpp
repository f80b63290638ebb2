#include "sim/contact/friction.h"

namespace cloth {
namespace {

/// φ, φ'/u and (φ'' - φ'/u)/u².
struct Slide {
    double value, slope, curvature;
};
Slide slide(double u, double way) {
    if (u >= way) return {u - way / 3.0, 1.0 / u, -1.0 / (u * u * u)};
    const double value = u * u / way - u * u * u / (3.0 * way * way);
    return {value, 2.0 / way - u / (way * way), u > 0.0 ? -1.0 / (u * way * way) : 0.0};
}

/// u
Vec3 tangential_way(const Friction& f, const VecX& x) {
    Vec3 u = -f.start;
    for (int i = 0; i < 4; ++i) {
        if (f.points[i] >= 0) u += f.weights[i] * x.segment<3>(3 * f.points[i]);
    }
    return u - f.normal * f.normal.dot(u);
}

}  // namespace

void FrictionList::add_value(const VecX& x, double& sum) const {
    for (const Friction& f : items) sum += f.force * slide(tangential_way(f, x).norm(), sliding_way).value;
}

void FrictionList::add_gradient(const VecX& x, VecX& g) const {
    for (const Friction& f : items) {
        const Vec3 u = tangential_way(f, x);
        const double factor = f.force * slide(u.norm(), sliding_way).slope;
        for (int i = 0; i < 4; ++i) {
            if (f.points[i] >= 0) g.segment<3>(3 * f.points[i]) += factor * f.weights[i] * u;
        }
    }
}

Mat3 FrictionList::hessian(int k, const VecX& x, double curvature) const {
    const Friction& f = items[k];
    const Vec3 u = tangential_way(f, x);
    const Slide s = slide(u.norm(), sliding_way);
    return f.force * (s.slope * (Mat3::Identity() - f.normal * f.normal.transpose()) +
                      curvature * s.curvature * u * u.transpose());
}

}  // namespace cloth
