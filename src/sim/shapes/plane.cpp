#include <cmath>

#include "sim/shapes/shapes.h"

namespace cloth {
namespace {

constexpr double half_width = 10.0;  // as drawn [m]
constexpr int cells = 64;            // along a side
constexpr double grading = 3.9;      // cells of 5 cm at the middle

class Plane final : public ColliderShape {
  public:
    explicit Plane(const ColliderDesc& c)
        : center_(c.center), normal_(c.normal.normalized()), offset_(c.contact_offset) {}

    /// A grid, finest at its middle: vertices carry how much of the sky they see past what lies there.
    Surface surface() const override {
        const Vec3 aside = std::abs(normal_.x()) < 0.9 ? Vec3::UnitX() : Vec3::UnitZ();
        const Vec3 u = normal_.cross(aside).normalized();
        const Vec3 v = normal_.cross(u);
        const auto line = [](int i) {
            const double part = 2.0 * i / cells - 1;
            return half_width * std::sinh(grading * part) / std::sinh(grading);
        };
        Surface s;
        s.endless = true;
        s.positions.resize((cells + 1) * (cells + 1), 3);
        s.normals.resize(s.positions.rows(), 3);
        for (int j = 0; j <= cells; ++j) {
            for (int i = 0; i <= cells; ++i) {
                const int at = j * (cells + 1) + i;
                s.positions.row(at) = (center_ + line(i) * u + line(j) * v).transpose();
                s.normals.row(at) = normal_.transpose();
            }
        }
        s.triangles.resize(2 * cells * cells, 3);
        Eigen::Index t = 0;
        for (int j = 0; j < cells; ++j) {
            for (int i = 0; i < cells; ++i) {
                const int at = j * (cells + 1) + i, above = at + cells + 1;
                s.triangles.row(t++) << at, at + 1, above + 1;
                s.triangles.row(t++) << at, above + 1, above;
            }
        }
        return s;
    }
    SurfacePoint distance(const Vec3& point) const override {
        return {normal_.dot(point - center_), normal_};
    }
    ContactPrimitive primitive() const override {
        return {.radius = offset_, .half_space = ContactPrimitive::HalfSpace{center_, normal_}};
    }

  private:
    Vec3 center_, normal_;
    double offset_;
};

}  // namespace

std::unique_ptr<const ColliderShape> make_plane(const ColliderDesc& collider) {
    return std::make_unique<Plane>(collider);
}

}  // namespace cloth
