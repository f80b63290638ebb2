#include <algorithm>
#include <cmath>

#include "base/portable_math.h"
#include "sim/scene/mesh.h"
#include "sim/shapes/surfaces.h"

namespace cloth {
namespace {

/// A prism of 64 sides through the mean of its inner and outer radius: off by 0.06 % of the radius at most.
/// Axis along y.
MeshData cylinder_mesh(double radius, double height) {
    constexpr int sides = 64;
    // A prism's corners at r, its sides at r cos(π/sides): mean equal to the radius asked for.
    const double r = 2.0 * radius / (1.0 + cos_degrees(180.0 / sides));
    MeshData mesh;
    mesh.positions.resize(2 * sides + 2, 3);
    mesh.triangles.resize(4 * sides, 3);
    const int bottom = 2 * sides, top = 2 * sides + 1;
    mesh.positions.row(bottom) << 0.0, -0.5 * height, 0.0;
    mesh.positions.row(top) << 0.0, 0.5 * height, 0.0;
    for (int i = 0; i < sides; ++i) {
        const double a = 360.0 * i / sides;
        mesh.positions.row(2 * i) << r * sin_degrees(a), -0.5 * height, r * cos_degrees(a);
        mesh.positions.row(2 * i + 1) << r * sin_degrees(a), 0.5 * height, r * cos_degrees(a);
        const int b = 2 * i, t = 2 * i + 1, next_b = 2 * ((i + 1) % sides), next_t = next_b + 1;
        mesh.triangles.row(4 * i) << b, next_b, next_t;
        mesh.triangles.row(4 * i + 1) << b, next_t, t;
        mesh.triangles.row(4 * i + 2) << bottom, next_b, b;
        mesh.triangles.row(4 * i + 3) << top, t, next_t;
    }
    return mesh;
}

class Cylinder final : public ColliderShape {
  public:
    explicit Cylinder(const ColliderDesc& c)
        : center_(c.center),
          radius_(c.radius),
          height_(c.height),
          R_(rotation_matrix(c.rotate)),
          offset_(c.contact_offset) {}

    Surface surface() const override {
        Surface s = flat_surface(mesh());
        const Vec3 axis = R_.col(1);
        for (Eigen::Index v = 0; v < s.positions.rows(); ++v) {
            if (std::abs(Vec3(s.normals.row(v)).dot(axis)) >= 0.5) continue;  // an end
            const Vec3 out = Vec3(s.positions.row(v)) - center_;
            s.normals.row(v) = (out - axis * axis.dot(out)).normalized().transpose();
        }
        return s;
    }
    SurfacePoint distance(const Vec3& point) const override {
        const Vec3 own = R_.transpose() * (point - center_);
        const double r = std::hypot(own.x(), own.z());
        const Vec2 d(r - radius_, std::abs(own.y()) - 0.5 * height_);  // beyond the side, beyond an end
        const Vec2 outside = d.cwiseMax(0.0);
        Vec2 normal = d.x() > d.y() ? Vec2::UnitX() : Vec2::UnitY();
        if (d.maxCoeff() > 0.0) normal = outside.normalized();
        const Vec3 out = r > 0.0 ? Vec3(own.x() / r, 0.0, own.z() / r) : Vec3(Vec3::UnitX());
        const Vec3 along = own.y() < 0.0 ? Vec3(-Vec3::UnitY()) : Vec3(Vec3::UnitY());
        return {outside.norm() + std::min(d.maxCoeff(), 0.0), R_ * (normal.x() * out + normal.y() * along)};
    }
    ContactPrimitive primitive() const override { return triangle_primitive(mesh(), offset_); }

  private:
    MeshData mesh() const { return placed(cylinder_mesh(radius_, height_), center_, R_); }

    Vec3 center_;
    double radius_, height_;
    Mat3 R_;
    double offset_;
};

}  // namespace

std::unique_ptr<const ColliderShape> make_cylinder(const ColliderDesc& collider) {
    return std::make_unique<Cylinder>(collider);
}

}  // namespace cloth
