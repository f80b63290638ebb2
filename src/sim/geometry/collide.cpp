#include "sim/geometry/collide.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cloth {
namespace {

/// Nearest point to p on the segment a … b: share of the way from a, in [0, 1], and distance squared.
struct OnSegment {
    double share, distance_squared;
};
OnSegment on_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
    const Vec3 e = b - a, r = p - a;
    const double length_squared = e.squaredNorm();
    const double share = length_squared > 0.0 ? std::clamp(e.dot(r) / length_squared, 0.0, 1.0) : 0.0;
    // Written as weights of the two ends, as the callers' weights will be.
    return {share, (p - ((1.0 - share) * a + share * b)).squaredNorm()};
}

/// Point `p` against the segment of points `a`, `b`; `sign` is +1 where p belongs to side A.
Nearest vertex_edge(const FourPoints& x, int p, int a, int b, double sign, double share) {
    Nearest n;
    n.weights[p] = sign;
    n.weights[a] = -sign * (1.0 - share);
    n.weights[b] = -sign * share;
    if (share > 0.0 && share < 1.0) {
        n.slide_count = 1;
        n.slides[0][a] = 1.0;
        n.slides[0][b] = -1.0;
    }
    n.distance_squared = n.difference(x).squaredNorm();
    return n;
}

/// Sine squared between two sides above which their common solution is taken without looking further.
constexpr double sharp = 1e-6;

/// Sign of the determinant of a-d, b-d, c-d; 0 where rounding could have turned it, as where the points are
/// in one row of a flat grid.
int orientation(const Vec3& a, const Vec3& b, const Vec3& c, const Vec3& d) {
    using L3 = Eigen::Matrix<long double, 3, 1>;
    const L3 o = d.cast<long double>();
    const L3 p = a.cast<long double>() - o, q = b.cast<long double>() - o, r = c.cast<long double>() - o;
    const long double value = p.dot(q.cross(r));
    long double size = 0.0L;
    for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        size += std::abs(p(i)) * (std::abs(q(j) * r(k)) + std::abs(q(k) * r(j)));
    }
    const long double rounding = 8.0L * std::numeric_limits<long double>::epsilon() * size;
    return (value > rounding) - (value < -rounding);
}

bool segment_crosses_triangle(const Vec3& p, const Vec3& q, const std::array<Vec3, 3>& t) {
    const int a = orientation(t[0], t[1], t[2], p);
    const int b = orientation(t[0], t[1], t[2], q);
    if (a * b >= 0) return false;
    const int u = orientation(p, q, t[0], t[1]);
    const int v = orientation(p, q, t[1], t[2]);
    const int w = orientation(p, q, t[2], t[0]);
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
    const Vec3 e1 = x[2] - x[1], e2 = x[3] - x[1], r = x[0] - x[1];
    const Vec3 normal = e1.cross(e2);
    const double area_squared = normal.squaredNorm();
    Nearest inside;
    inside.distance_squared = 1.0 / 0.0;
    if (area_squared > 0.0) {
        const double b2 = r.cross(e2).dot(normal) / area_squared;
        const double b3 = e1.cross(r).dot(normal) / area_squared;
        if (b2 > 0.0 && b3 > 0.0 && b2 + b3 < 1.0) {
            inside.weights = {1.0, b2 + b3 - 1.0, -b2, -b3};
            inside.slide_count = 2;
            inside.slides[0] = {0.0, 1.0, -1.0, 0.0};
            inside.slides[1] = {0.0, 1.0, 0.0, -1.0};
            inside.distance_squared = inside.difference(x).squaredNorm();
            if (area_squared > sharp * e1.squaredNorm() * e2.squaredNorm()) return inside;
        }
    }
    const OnSegment a = on_segment(x[0], x[1], x[2]), b = on_segment(x[0], x[2], x[3]),
                    c = on_segment(x[0], x[3], x[1]);
    Nearest edge;
    if (a.distance_squared <= b.distance_squared && a.distance_squared <= c.distance_squared) {
        edge = vertex_edge(x, 0, 1, 2, 1.0, a.share);
    } else if (b.distance_squared <= c.distance_squared) {
        edge = vertex_edge(x, 0, 2, 3, 1.0, b.share);
    } else {
        edge = vertex_edge(x, 0, 3, 1, 1.0, c.share);
    }
    return inside.distance_squared < edge.distance_squared ? inside : edge;
}

Nearest nearest_edge_edge(const FourPoints& x) {
    const Vec3 e1 = x[1] - x[0], e2 = x[3] - x[2], r = x[2] - x[0];
    const Vec3 normal = e1.cross(e2);
    const double sine_squared = normal.squaredNorm();  // times both lengths squared
    Nearest inside;
    inside.distance_squared = 1.0 / 0.0;
    if (sine_squared > 0.0) {
        const double s = r.cross(e2).dot(normal) / sine_squared;
        const double t = r.cross(e1).dot(normal) / sine_squared;
        if (s > 0.0 && s < 1.0 && t > 0.0 && t < 1.0) {
            inside.weights = {1.0 - s, s, t - 1.0, -t};
            inside.slide_count = 2;
            inside.slides[0] = {1.0, -1.0, 0.0, 0.0};
            inside.slides[1] = {0.0, 0.0, 1.0, -1.0};
            inside.distance_squared = inside.difference(x).squaredNorm();
            if (sine_squared > sharp * e1.squaredNorm() * e2.squaredNorm()) return inside;
        }
    }
    const OnSegment ends[4] = {on_segment(x[0], x[2], x[3]), on_segment(x[1], x[2], x[3]),
                               on_segment(x[2], x[0], x[1]), on_segment(x[3], x[0], x[1])};
    int best = 0;
    for (int i = 1; i < 4; ++i) {
        if (ends[i].distance_squared < ends[best].distance_squared) best = i;
    }
    const Nearest end = best < 2 ? vertex_edge(x, best, 2, 3, 1.0, ends[best].share)
                                 : vertex_edge(x, best, 0, 1, -1.0, ends[best].share);
    return inside.distance_squared < end.distance_squared ? inside : end;
}

bool boxes_apart(PairKind kind, const FourPoints& x, double reach) {
    const bool face = kind == PairKind::vertex_face;
    const Vec3 low_a = face ? x[0] : Vec3(x[0].cwiseMin(x[1])),
               high_a = face ? x[0] : Vec3(x[0].cwiseMax(x[1]));
    const Vec3& first = face ? x[1] : x[2];
    const Vec3 low_b = first.cwiseMin(x[2]).cwiseMin(x[3]), high_b = first.cwiseMax(x[2]).cwiseMax(x[3]);
    return ((low_a - high_b).array() > reach).any() || ((low_b - high_a).array() > reach).any();
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
    // Most pairs are too far apart to meet: tell so by the boxes alone.
    const double reach = (1.0 + slack) * closing + separation;
    if (boxes_apart(kind, x, reach)) return 1.0;
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
