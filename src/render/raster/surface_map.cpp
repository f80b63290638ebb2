#include "render/raster/surface_map.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace cloth::render {
namespace {

Float3 difference(const Float3& a, const Float3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
float dot(const Float3& a, const Float3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Float3 cross(const Float3& a, const Float3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
Float3 unit(const Float3& a) {
    const float length = std::sqrt(dot(a, a));
    return {a[0] / length, a[1] / length, a[2] / length};
}

/// A corner of what is left of a triangle in front of the eye.
struct Corner {
    Float3 place;                 ///< x, y [sample], depth
    std::array<float, 3> shares;  ///< of the triangle's own corners
};

class Painter {
  public:
    Painter(const Frame& frame, const View& view, SurfaceMap& map) : frame_(frame), map_(map), camera_(view) {
        const Float3 sight = difference(view.target, view.eye);
        near_ = 0.01f * std::sqrt(dot(sight, sight));
        rows_ = map.window.y1 - map.window.y0;
    }

    void draw(int surface) {
        const Surface& s = frame_.surfaces[static_cast<std::size_t>(surface)];
        projected_.clear();
        for (std::size_t v = 0; 3 * v < s.positions.size(); ++v)
            projected_.push_back(in_samples(
                camera_.project({s.positions[3 * v], s.positions[3 * v + 1], s.positions[3 * v + 2]})));
        for (std::size_t t = 0; 3 * t < s.triangles.size(); ++t) draw(surface, static_cast<int>(t), s);
    }

  private:
    Float3 in_samples(const Float3& p) const {
        constexpr float n = samples_per_side;
        return {n * (p[0] - static_cast<float>(map_.window.x0)),
                n * (p[1] - static_cast<float>(map_.window.y0)), p[2]};
    }

    void draw(int surface, int triangle, const Surface& s) {
        std::array<Corner, 3> corners{};
        int behind = 0;
        for (int i = 0; i < 3; ++i) {
            corners[i].place = projected_[s.triangles[3 * static_cast<std::size_t>(triangle) + i]];
            corners[i].shares[i] = 1;
            behind += corners[i].place[2] < near_;
        }
        if (behind == 3) return;
        if (behind == 0) {
            fill(surface, triangle, s, corners[0], corners[1], corners[2]);
            return;
        }
        // Cut at the near plane: three or four corners are left.
        std::vector<Corner> rest;
        for (int i = 0; i < 3; ++i) {
            const Corner &a = corners[i], &b = corners[(i + 1) % 3];
            const float za = a.place[2], zb = b.place[2];
            if (za >= near_) rest.push_back(a);
            if ((za < near_) == (zb < near_)) continue;
            const float share = (near_ - za) / (zb - za);
            Float3 world{};
            Corner cut;
            for (int k = 0; k < 3; ++k) {
                cut.shares[k] = (1 - share) * a.shares[k] + share * b.shares[k];
                const std::size_t v = s.triangles[3 * static_cast<std::size_t>(triangle) + k];
                for (int axis = 0; axis < 3; ++axis) world[axis] += cut.shares[k] * s.positions[3 * v + axis];
            }
            cut.place = in_samples(camera_.project(world));
            rest.push_back(cut);
        }
        for (std::size_t i = 2; i < rest.size(); ++i)
            fill(surface, triangle, s, rest[0], rest[i - 1], rest[i]);
    }

    void fill(int surface, int triangle, const Surface& s, const Corner& a, const Corner& b,
              const Corner& c) {
        const Float3 &p = a.place, &q = b.place, &r = c.place;
        const float area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
        if (!(std::abs(area) > 1e-12f)) return;
        const auto first = [](float low, int limit) {
            return static_cast<int>(std::clamp(std::ceil(low - 0.5f), 0.0f, static_cast<float>(limit)));
        };
        const auto last = [](float high, int limit) {
            return static_cast<int>(
                std::clamp(std::floor(high - 0.5f), -1.0f, static_cast<float>(limit - 1)));
        };
        const int height = samples_per_side * rows_;
        const int x0 = first(std::min({p[0], q[0], r[0]}), map_.width),
                  x1 = last(std::max({p[0], q[0], r[0]}), map_.width);
        const int y0 = first(std::min({p[1], q[1], r[1]}), height),
                  y1 = last(std::max({p[1], q[1], r[1]}), height);
        for (int y = y0; y <= y1; ++y)
            for (int x = x0; x <= x1; ++x) {
                const float sx = static_cast<float>(x) + 0.5f, sy = static_cast<float>(y) + 0.5f;
                const float u = ((sx - p[0]) * (r[1] - p[1]) - (sy - p[1]) * (r[0] - p[0])) / area;
                const float v = ((q[0] - p[0]) * (sy - p[1]) - (q[1] - p[1]) * (sx - p[0])) / area;
                const float w = 1 - u - v;
                if (u < 0 || v < 0 || w < 0) continue;
                // What is linear in space over the depth is linear in the picture.
                const float wp = w / p[2], uq = u / q[2], vr = v / r[2];
                const float depth = 1 / (wp + uq + vr);
                SurfaceSample& sample =
                    map_.samples[static_cast<std::size_t>(y) * static_cast<std::size_t>(map_.width) +
                                 static_cast<std::size_t>(x)];
                if (sample.surface >= 0 && sample.depth <= depth) continue;
                std::array<float, 3> shares{};
                for (int k = 0; k < 3; ++k)
                    shares[k] = depth * (wp * a.shares[k] + uq * b.shares[k] + vr * c.shares[k]);
                if (frame_.ground) {
                    float at = 0;
                    for (int k = 0; k < 3; ++k) {
                        const std::size_t corner = s.triangles[3 * static_cast<std::size_t>(triangle) + k];
                        at += shares[k] * s.positions[3 * corner + 1];
                    }
                    if (at < frame_.ground->height) continue;
                }
                sample = {depth, surface, triangle, shares};
            }
    }

    const Frame& frame_;
    SurfaceMap& map_;
    Pinhole camera_;
    float near_;
    int rows_;
    std::vector<Float3> projected_;
};

}  // namespace

Pinhole::Pinhole(const View& view)
    : eye_(view.eye),
      forward_(unit(difference(view.target, view.eye))),
      center_x_(0.5f * static_cast<float>(view.width)),
      center_y_(0.5f * static_cast<float>(view.height)),
      scale_(center_y_ / std::tan(0.5f * view.field_of_view * std::numbers::pi_v<float> / 180)) {
    right_ = unit(cross(forward_, view.up));
    up_ = cross(right_, forward_);
}

Float3 Pinhole::project(const Float3& point) const {
    const Float3 d = difference(point, eye_);
    const float depth = dot(d, forward_);
    return {center_x_ + scale_ * dot(d, right_) / depth, center_y_ - scale_ * dot(d, up_) / depth, depth};
}

SurfaceMap map_surfaces(const Frame& frame, const View& view, const Window& window) {
    SurfaceMap map;
    map.window = {std::clamp(window.x0, 0, view.width), std::clamp(window.y0, 0, view.height),
                  std::clamp(window.x1, 0, view.width), std::clamp(window.y1, 0, view.height)};
    map.window.x1 = std::max(map.window.x0, map.window.x1);
    map.window.y1 = std::max(map.window.y0, map.window.y1);
    map.width = samples_per_side * (map.window.x1 - map.window.x0);
    map.samples.resize(static_cast<std::size_t>(map.width) *
                       static_cast<std::size_t>(samples_per_side * (map.window.y1 - map.window.y0)));
    Painter painter(frame, view, map);
    for (std::size_t i = 0; i < frame.surfaces.size(); ++i) painter.draw(static_cast<int>(i));
    return map;
}

}  // namespace cloth::render
