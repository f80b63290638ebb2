#include <algorithm>

#include "sim/scene/mesh.h"
#include "sim/shapes/surfaces.h"

namespace cloth {
namespace {

class Capsule final : public ColliderShape {
  public:
    explicit Capsule(const ColliderDesc& c)
        : center_(c.center),
          radius_(c.radius),
          height_(c.height),
          R_(rotation_matrix(c.rotate)),
          offset_(c.contact_offset) {}

    Surface surface() const override { return round_surface(ends(), R_, radius_); }
    SurfacePoint distance(const Vec3& point) const override {
        Vec3 q = R_.transpose() * (point - center_);
        q.y() -= std::clamp(q.y(), -0.5 * height_, 0.5 * height_);
        const double r = q.norm();
        return {r - radius_, R_ * (r > 0.0 ? Vec3(q / r) : Vec3(Vec3::UnitX()))};
    }
    ContactPrimitive primitive() const override {
        const auto [low, high] = ends();
        return {.radius = radius_ + offset_, .points = {low, high}, .segments = {{0, 1}}};
    }

  private:
    std::array<Vec3, 2> ends() const {
        const Vec3 half = R_ * Vec3(0.0, 0.5 * height_, 0.0);
        return {center_ - half, center_ + half};
    }

    Vec3 center_;
    double radius_, height_;
    Mat3 R_;
    double offset_;
};

}  // namespace

std::unique_ptr<const ColliderShape> make_capsule(const ColliderDesc& collider) {
    return std::make_unique<Capsule>(collider);
}

}  // namespace cloth
