#include "pipeline/formats/triangulate.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

namespace cloth::pipeline {
namespace {

double cross(const Vec2& a, const Vec2& b) {
    return a.x() * b.y() - a.y() * b.x();
}

/// The polygon flat, counter-clockwise, in units of its size; empty where it has no area.
std::vector<Vec2> flattened(std::span<const Vec3> polygon) {
    Vec3 centre = Vec3::Zero(), normal = Vec3::Zero();
    double size = 0.0;
    for (const Vec3& p : polygon) centre += p / static_cast<double>(polygon.size());
    for (const Vec3& p : polygon) size = std::max(size, (p - centre).norm());
    if (!(size > 0.0) || !std::isfinite(size)) return {};
    std::vector<Vec3> scaled;
    for (const Vec3& p : polygon) scaled.push_back((p - centre) / size);
    for (std::size_t i = 0; i < scaled.size(); ++i)
        normal += scaled[i].cross(scaled[(i + 1) % scaled.size()]);
    if (!(normal.norm() > 1e-10)) return {};
    normal.normalize();
    const Vec3 u = normal.unitOrthogonal(), v = normal.cross(u);
    std::vector<Vec2> flat;
    for (const Vec3& p : scaled) flat.emplace_back(u.dot(p), v.dot(p));
    return flat;
}

/// What is left of a polygon while ears are clipped.
class Ears {
  public:
    explicit Ears(std::vector<Vec2> flat) : flat_(std::move(flat)), shapes_(flat_.size()) {
        for (std::size_t i = 0; i < flat_.size(); ++i) left_.push_back(static_cast<int>(i));
        measure_all();
    }

    /// The best ear, taken off; all -1 where there is none.
    std::array<int, 3> clip() {
        if (left_.size() == 3) {
            const std::array<int, 3> last{left_[0], left_[1], left_[2]};
            const bool good = shape(1) > 0.0;
            left_.clear();
            return good ? last : nothing;
        }
        double best = *std::max_element(shapes_.begin(), shapes_.end());
        if (!(best > 0.0)) {
            // What stood in the way may be gone.
            measure_all();
            best = *std::max_element(shapes_.begin(), shapes_.end());
        }
        if (!(best > 0.0)) return nothing;
        // The first of those that are as good but for rounding; a square's second corner.
        std::size_t i = 1;
        while (!(shapes_[i % left_.size()] >= 0.999 * best)) ++i;
        i %= left_.size();
        const std::array<int, 3> ear{at(i, -1), left_[i], at(i, 1)};
        left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(i));
        shapes_.erase(shapes_.begin() + static_cast<std::ptrdiff_t>(i));
        const std::size_t n = left_.size();
        for (const std::size_t k : {(i + n - 1) % n, i % n}) shapes_[k] = shape(k);
        return ear;
    }
    bool done() const { return left_.empty(); }

    static constexpr std::array<int, 3> nothing{-1, -1, -1};

  private:
    int at(std::size_t i, int step) const {
        const std::size_t n = left_.size();
        return left_[step < 0 ? (i + n - 1) % n : (i + 1) % n];
    }
    const Vec2& point(int corner) const { return flat_[static_cast<std::size_t>(corner)]; }

    void measure_all() {
        shapes_.resize(left_.size());
        for (std::size_t i = 0; i < left_.size(); ++i) shapes_[i] = shape(i);
    }

    /// Twice the area over the longest edge squared of the ear at `i`; 0 where it is none.
    double shape(std::size_t i) const {
        constexpr double rounding = 1e-12;
        const int ia = at(i, -1), ib = left_[i], ic = at(i, 1);
        const Vec2 &a = point(ia), &b = point(ib), &c = point(ic);
        const double area = cross(b - a, c - a);
        if (!(area > rounding)) return 0.0;
        for (const int other : left_) {
            const Vec2& p = point(other);
            // Corners at one place are the two banks of a cut to a hole.
            if (other == ia || other == ib || other == ic || p == a || p == b || p == c) continue;
            if (cross(b - a, p - a) >= -rounding && cross(c - b, p - b) >= -rounding &&
                cross(a - c, p - c) >= -rounding)
                return 0.0;
        }
        return area / std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()});
    }

    std::vector<Vec2> flat_;
    std::vector<int> left_;       ///< corners not yet cut off, in their order
    std::vector<double> shapes_;  ///< of the ears at them, as last measured
};

}  // namespace

std::vector<std::array<int, 3>> triangulate(std::span<const Vec3> polygon) {
    std::vector<Vec2> flat = flattened(polygon);
    if (flat.empty()) return {};
    Ears ears(std::move(flat));
    std::vector<std::array<int, 3>> triangles;
    while (!ears.done()) {
        triangles.push_back(ears.clip());
        if (triangles.back() == Ears::nothing) return {};
    }
    return triangles;
}

}  // namespace cloth::pipeline
