#include "sim/shapes/surfaces.h"

namespace cloth {
namespace {

class Sphere final : public ColliderShape {
  public:
    explicit Sphere(const ColliderDesc& c)
        : center_(c.center),
          radius_(c.radius),
          reach_(c.contact_radius.value_or(c.radius + c.contact_offset)) {}

    Surface surface() const override { return round_surface({center_, center_}, Mat3::Identity(), radius_); }
    SurfacePoint distance(const Vec3& point) const override {
        const Vec3 d = point - center_;
        const double r = d.norm(), distance = r - radius_;
        return {distance, r > 0.0 ? Vec3(d / r) : Vec3(Vec3::UnitY()), distance + radius_};
    }
    ContactPrimitive primitive() const override { return {.radius = reach_, .points = {center_}}; }

  private:
    Vec3 center_;
    double radius_, reach_;
};

}  // namespace

std::unique_ptr<const ColliderShape> make_sphere(const ColliderDesc& collider) {
    return std::make_unique<Sphere>(collider);
}

}  // namespace cloth
