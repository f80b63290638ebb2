#include "pipeline/formats/planar_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "pipeline/formats/triangulate.h"

namespace cloth::pipeline {
namespace {

/// Twice the area of a, b, c; positive counter-clockwise.
double turn(const Vec2& a, const Vec2& b, const Vec2& c) {
    const Vec2 ab = b - a, ac = c - a;
    return ab.x() * ac.y() - ab.y() * ac.x();
}

/// Whether d lies in the circle through a, b, c (counter-clockwise), by more than rounding.
bool in_circle(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
    const Vec2 p = a - d, q = b - d, r = c - d;
    const double pp = p.squaredNorm(), qq = q.squaredNorm(), rr = r.squaredNorm();
    const double det = pp * (q.x() * r.y() - q.y() * r.x()) - qq * (p.x() * r.y() - p.y() * r.x()) +
                       rr * (p.x() * q.y() - p.y() * q.x());
    const double size = std::max({pp, qq, rr});
    return det > 1e-10 * size * size;
}

/// A triangulation that changes by flips and new points.
class Mesh {
  public:
    Mesh(std::vector<Vec2> points, std::vector<std::array<int, 3>> triangles)
        : points_(std::move(points)), triangles_(std::move(triangles)), next_(triangles_.size()) {
        std::map<std::array<int, 2>, std::array<int, 2>> open;
        for (int t = 0; t < count(); ++t) {
            next_[at(t)] = {-1, -1, -1};
            for (int i = 0; i < 3; ++i) {
                const int a = corner(t, i + 1), b = corner(t, i + 2);
                const auto other = open.find({b, a});
                if (other == open.end()) {
                    open[{a, b}] = {t, i};
                } else {
                    const auto [u, j] = other->second;
                    next_[at(t)][at(i)] = u;
                    next_[at(u)][at(j)] = t;
                }
            }
        }
    }

    int count() const { return static_cast<int>(triangles_.size()); }
    const std::vector<Vec2>& points() const { return points_; }
    const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }

    /// Flips edges until none has a neighbour's corner in its triangle's circle.
    void make_delaunay() {
        std::vector<int> all(triangles_.size());
        for (int t = 0; t < count(); ++t) all[at(t)] = t;
        settle(all);
    }

    /// A point inside: its triangle becomes three.
    void insert(const Vec2& p) {
        const int t = find(p);
        if (t < 0) return;
        const int v = static_cast<int>(points_.size());
        points_.push_back(p);
        const auto [a, b, c] = triangles_[at(t)];
        const auto [na, nb, nc] = next_[at(t)];
        const int u = count(), w = u + 1;
        triangles_[at(t)] = {v, b, c};
        next_[at(t)] = {na, u, w};
        triangles_.push_back({a, v, c});
        next_.push_back({t, nb, w});
        triangles_.push_back({a, b, v});
        next_.push_back({t, u, nc});
        replace(nb, t, u);
        replace(nc, t, w);
        last_ = t;
        settle({t, u, w});
    }

    /// Points from `first` on to the middle of their neighbours, where that turns no triangle over.
    void smooth(int first) {
        std::vector<Vec2> sum(points_.size(), Vec2::Zero());
        std::vector<int> neighbours(points_.size(), 0);
        std::vector<std::vector<int>> around(points_.size());
        for (int t = 0; t < count(); ++t) {
            for (int i = 0; i < 3; ++i) {
                const int v = corner(t, i);
                around[at(v)].push_back(t);
                for (int k = 1; k < 3; ++k) sum[at(v)] += points_[at(corner(t, i + k))];
                neighbours[at(v)] += 2;
            }
        }
        for (int v = first; v < static_cast<int>(points_.size()); ++v) {
            if (neighbours[at(v)] == 0) continue;
            const Vec2 before = points_[at(v)];
            const auto smallest = [&] {
                double area = std::numeric_limits<double>::infinity();
                for (const int t : around[at(v)]) area = std::min(area, area_of(t));
                return area;
            };
            const double least = smallest();
            points_[at(v)] = sum[at(v)] / neighbours[at(v)];
            if (!(smallest() > 0.2 * least)) points_[at(v)] = before;
        }
        make_delaunay();
    }

  private:
    static std::size_t at(int i) { return static_cast<std::size_t>(i); }
    int corner(int t, int i) const { return triangles_[at(t)][at(i % 3)]; }
    const Vec2& point(int t, int i) const { return points_[at(corner(t, i))]; }
    double area_of(int t) const { return turn(point(t, 0), point(t, 1), point(t, 2)); }

    void replace(int t, int was, int now) {
        if (t < 0) return;
        for (int& n : next_[at(t)])
            if (n == was) n = now;
    }

    /// The triangle that holds p: by a walk from the last one found, else by looking at all.
    int find(const Vec2& p) const {
        int t = std::min(last_, count() - 1);
        for (int steps = 0; t >= 0 && steps < count(); ++steps) {
            int across = -2;
            for (int i = 0; i < 3 && across == -2; ++i)
                if (turn(point(t, i + 1), point(t, i + 2), p) < 0.0) across = next_[at(t)][at(i)];
            if (across == -2) return t;
            t = across;
        }
        for (t = 0; t < count(); ++t) {
            bool inside = true;
            for (int i = 0; i < 3; ++i) inside = inside && turn(point(t, i + 1), point(t, i + 2), p) >= 0.0;
            if (inside) return t;
        }
        return -1;
    }

    /// Flips the edges of these triangles and of all that change with them.
    void settle(std::vector<int> open) {
        std::size_t flips = 0;
        const std::size_t most = 100 * triangles_.size() + 1000;  // rounding may not turn in circles
        while (!open.empty() && flips < most) {
            const int t = open.back();
            open.pop_back();
            for (int i = 0; i < 3; ++i) {
                const int u = next_[at(t)][at(i)];
                if (u < 0 || !should_flip(t, i, u)) continue;
                flip(t, i, u);
                ++flips;
                open.push_back(t);
                open.push_back(u);
                break;
            }
        }
    }
    int side_of(int u, int t) const { return next_[at(u)][0] == t ? 0 : next_[at(u)][1] == t ? 1 : 2; }
    bool should_flip(int t, int i, int u) const {
        const Vec2 &p = point(t, i), &a = point(t, i + 1), &b = point(t, i + 2), &q = point(u, side_of(u, t));
        if (!(turn(p, a, q) > 0.0 && turn(p, q, b) > 0.0)) return false;  // not convex
        const double flat = 1e-9 * (b - a).squaredNorm();
        if (turn(p, a, b) <= flat || turn(q, b, a) <= flat) return true;
        return in_circle(p, a, b, q);
    }
    /// Edge a b between p a b and q b a becomes p q.
    void flip(int t, int i, int u) {
        const int j = side_of(u, t);
        const int p = corner(t, i), a = corner(t, i + 1), b = corner(t, i + 2), q = corner(u, j);
        const int pa = next_[at(t)][at((i + 2) % 3)], pb = next_[at(t)][at((i + 1) % 3)];
        const int qb = next_[at(u)][at((j + 2) % 3)], qa = next_[at(u)][at((j + 1) % 3)];
        triangles_[at(t)] = {p, a, q};
        next_[at(t)] = {qa, u, pa};
        triangles_[at(u)] = {p, q, b};
        next_[at(u)] = {qb, pb, t};
        replace(qa, u, t);
        replace(pb, t, u);
    }

    std::vector<Vec2> points_;
    std::vector<std::array<int, 3>> triangles_;
    std::vector<std::array<int, 3>> next_;  ///< across the edge opposite to each corner; -1: the rim
    int last_ = 0;
};

double distance_to_segment(const Vec2& p, const Vec2& a, const Vec2& b) {
    const Vec2 way = b - a;
    const double share = std::clamp(way.dot(p - a) / way.squaredNorm(), 0.0, 1.0);
    return (p - a - share * way).norm();
}

bool inside(const std::vector<Vec2>& polygon, const Vec2& p) {
    bool odd = false;
    for (std::size_t i = 0, j = polygon.size() - 1; i < polygon.size(); j = i++) {
        const Vec2 &a = polygon[i], &b = polygon[j];
        if ((a.y() > p.y()) != (b.y() > p.y()) &&
            p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x())
            odd = !odd;
    }
    return odd;
}

/// Points of the lattice that have room between the polygon's edges.
std::vector<Vec2> lattice(const std::vector<Vec2>& polygon, double edge_length) {
    Vec2 low = polygon[0], high = polygon[0];
    for (const Vec2& p : polygon) {
        low = low.cwiseMin(p);
        high = high.cwiseMax(p);
    }
    const double row = 0.5 * std::sqrt(3.0) * edge_length;
    constexpr double room = 0.6;  // of an edge's length
    std::vector<Vec2> points;
    const auto rows = static_cast<int>((high.y() - low.y()) / row),
               columns = static_cast<int>((high.x() - low.x()) / edge_length);
    for (int j = 0; j <= rows; ++j) {
        for (int i = 0; i <= columns; ++i) {
            const Vec2 p = low + Vec2((i + (j % 2 ? 0.5 : 0.0)) * edge_length, (j + 0.5) * row);
            if (!inside(polygon, p)) continue;
            double near = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < polygon.size(); ++k)
                near = std::min(near, distance_to_segment(p, polygon[k], polygon[(k + 1) % polygon.size()]));
            if (near > room * edge_length) points.push_back(p);
        }
    }
    return points;
}

}  // namespace

PlanarMesh fill_polygon(const std::vector<Vec2>& polygon, double edge_length) {
    std::vector<Vec3> flat;
    double area = 0.0;
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        flat.emplace_back(polygon[i].x(), polygon[i].y(), 0.0);
        area += turn(Vec2::Zero(), polygon[i], polygon[(i + 1) % polygon.size()]);
    }
    std::vector<std::array<int, 3>> ears = triangulate(flat);
    if (ears.empty()) return {};
    if (area < 0.0)
        for (auto& ear : ears) std::swap(ear[1], ear[2]);
    Mesh mesh(polygon, std::move(ears));
    mesh.make_delaunay();
    for (const Vec2& p : lattice(polygon, edge_length)) mesh.insert(p);
    constexpr int rounds = 5;
    for (int k = 0; k < rounds; ++k) mesh.smooth(static_cast<int>(polygon.size()));
    return {mesh.points(), mesh.triangles()};
}

}  // namespace cloth::pipeline
