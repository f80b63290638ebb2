#include "sim/collide.h"

#include <algorithm>
#include <cmath>

namespace cloth {
namespace {

void take_if_nearer(Nearest& best, const FourPoints& x, Nearest candidate) {
    candidate.distance_squared = candidate.difference(x).squaredNorm();
    if (candidate.distance_squared < best.distance_squared) best = candidate;
}

/// Where the point nearest to p lies on the segment a … b, clamped to [0, 1].
double along_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 e = b - a;
    const double length_squared = e.squaredNorm();
    if (!(length_squared > 0.0)) return 0.0;
    return std::clamp(e.dot(p - a) / length_squared, 0.0, 1.0);
}

/// Point `p` against the segment of points `a`, `b`; `sign` is +1 where p belongs to side A.
Nearest point_on_segment(const FourPoints& x, int p, int a, int b, double sign) {
    const double s = along_segment(x[p], x[a], x[b]);
    Nearest n;
    n.weights[p] = sign;
    n.weights[a] = -sign * (1.0 - s);
    n.weights[b] = -sign * s;
    if (s > 0.0 && s < 1.0) {
        n.slide_count = 1;
        n.slides[0][a] = 1.0;
        n.slides[0][b] = -1.0;
    }
    return n;
}

Nearest nothing_yet() {
    Nearest n;
    n.distance_squared = 1.0 / 0.0;
    return n;
}

long double orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    using L3 = Eigen::Matrix<long double, 3, 1>;
    const L3 o = d.cast<long double>();
    return (a.cast<long double>() - o).dot((b.cast<long double>() - o).cross(c.cast<long double>() - o));
}

int sign(long double v) {
    return (v > 0.0L) - (v < 0.0L);
}

bool segment_crosses_triangle(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
    const int a = sign(orientation(t[0], t[1], t[2], p));
    const int b = sign(orientation(t[0], t[1], t[2], q));
    if (a * b >= 0) return false;
    const int u = sign(orientation(p, q, t[0], t[1]));
    const int v = sign(orientation(p, q, t[1], t[2]));
    const int w = sign(orientation(p, q, t[2], t[0]));
    return u != 0 && u == v && v == w;
}

}  // namespace

Nearest nearest_point_point(const Vec3& a, const Vec3& b) {
    Nearest n;
    n.weights = {1.0, -1.0, 0.0, 0.0};
    n.distance_squared = (a - b).squaredNorm();
    return n;
}

Nearest nearest_vertex_face(const FourPoints& x) {
    Nearest best = nothing_yet();
    const Vec3 e1 = x[2] - x[1], e2 = x[3] - x[1], r = x[0] - x[1];
    const Vec3 normal = e1.cross(e2);
    const double area_squared = normal.squaredNorm();
    if (area_squared > 0.0) {
        const double b2 = r.cross(e2).dot(normal) / area_squared;
        const double b3 = e1.cross(r).dot(normal) / area_squared;
        if (b2 > 0.0 && b3 > 0.0 && b2 + b3 < 1.0) {
            Nearest n;
            n.weights = {1.0, b2 + b3 - 1.0, -b2, -b3};
            n.slide_count = 2;
            n.slides[0] = {0.0, 1.0, -1.0, 0.0};
            n.slides[1] = {0.0, 1.0, 0.0, -1.0};
            take_if_nearer(best, x, n);
        }
    }
    take_if_nearer(best, x, point_on_segment(x, 0, 1, 2, 1.0));
    take_if_nearer(best, x, point_on_segment(x, 0, 2, 3, 1.0));
    take_if_nearer(best, x, point_on_segment(x, 0, 3, 1, 1.0));
    return best;
}

Nearest nearest_edge_edge(const FourPoints& x) {
    Nearest best = nothing_yet();
    const Vec3 e1 = x[1] - x[0], e2 = x[3] - x[2], r = x[2] - x[0];
    const Vec3 normal = e1.cross(e2);
    const double sine_squared = normal.squaredNorm();  // times both lengths squared
    if (sine_squared > 0.0) {
        const double s = r.cross(e2).dot(normal) / sine_squared;
        const double t = r.cross(e1).dot(normal) / sine_squared;
        if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
            Nearest n;
            n.weights = {1.0 - s, s, t - 1.0, -t};
            n.slide_count = 2;
            n.slides[0] = {1.0, -1.0, 0.0, 0.0};
            n.slides[1] = {0.0, 0.0, 1.0, -1.0};
            take_if_nearer(best, x, n);
        }
    }
    take_if_nearer(best, x, point_on_segment(x, 0, 2, 3, 1.0));
    take_if_nearer(best, x, point_on_segment(x, 1, 2, 3, 1.0));
    take_if_nearer(best, x, point_on_segment(x, 2, 0, 1, -1.0));
    take_if_nearer(best, x, point_on_segment(x, 3, 0, 1, -1.0));
    return best;
}

double safe_step(PairKind kind, const FourPoints& x, const FourPoints& motion, double separation,
                 double slack) {
    // Common motion does not change the distance; without it the bound on the closing speed is tighter.
    const Vec3 mean = 0.25 * (motion[0] + motion[1] + motion[2] + motion[3]);
    FourPoints v;
    std::array<double, 4> speed;
    for (int i = 0; i < 4; ++i) {
        v[i] = motion[i] - mean;
        speed[i] = v[i].norm();
    }
    const double closing = kind == PairKind::vertex_face
                               ? speed[0] + std::max({speed[1], speed[2], speed[3]})
                               : std::max(speed[0], speed[1]) + std::max(speed[2], speed[3]);
    auto gap_at = [&](double t) {
        FourPoints y;
        for (int i = 0; i < 4; ++i) y[i] = x[i] + t * v[i];
        return std::sqrt(nearest(kind, y).distance_squared) - separation;
    };
    double gap = gap_at(0.0);
    if (!(gap > 0.0)) return 0.0;
    if (gap > (1.0 + slack) * closing) return 1.0;
    const double enough = slack * gap;
    double t = 0.0;
    // After each advance at least half of `enough` is left, so stopping early is safe as well.
    for (int pass = 0; pass < 256; ++pass) {
        t += (gap - 0.5 * enough) / closing;
        if (t >= 1.0) return 1.0;
        gap = gap_at(t);
        if (gap <= enough) break;
    }
    return t;
}

bool triangles_cross(const std::array<Vec3, 3>& a, const std::array<Vec3, 3>& b) {
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3;
        if (segment_crosses_triangle(a[i], a[j], b) || segment_crosses_triangle(b[i], b[j], a)) return true;
    }
    return false;
}

}  // namespace cloth
