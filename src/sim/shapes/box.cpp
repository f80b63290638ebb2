#include "sim/scene/mesh.h"
#include "sim/shapes/surfaces.h"

namespace cloth {
namespace {

MeshData box_mesh(const Vec3& size) {
    MeshData mesh;
    mesh.positions.resize(8, 3);
    for (int v = 0; v < 8; ++v) {
        for (int a = 0; a < 3; ++a) mesh.positions(v, a) = ((v >> a) & 1 ? 0.5 : -0.5) * size(a);
    }
    // Corner v has bit a set where its coordinate a is the greater one. Each side twice, counter-clockwise.
    const int sides[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4},
                             {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};
    mesh.triangles.resize(12, 3);
    for (int s = 0; s < 6; ++s) {
        mesh.triangles.row(2 * s) << sides[s][0], sides[s][1], sides[s][2];
        mesh.triangles.row(2 * s + 1) << sides[s][0], sides[s][2], sides[s][3];
    }
    return mesh;
}

class BoxShape final : public ColliderShape {
  public:
    explicit BoxShape(const ColliderDesc& c)
        : center_(c.center), size_(c.size), R_(rotation_matrix(c.rotate)), offset_(c.contact_offset) {}

    Surface surface() const override { return flat_surface(mesh()); }
    SurfacePoint distance(const Vec3& point) const override {
        const Vec3 own = R_.transpose() * (point - center_);
        const Vec3 d = own.cwiseAbs() - 0.5 * size_;  // beyond each pair of sides
        const Vec3 outside = d.cwiseMax(0.0);
        int nearest_side = 0;
        const double deepest = d.maxCoeff(&nearest_side);
        Vec3 normal = deepest > 0.0 ? Vec3(outside.normalized()) : Vec3(Vec3::Unit(nearest_side));
        for (int a = 0; a < 3; ++a) {
            if (own(a) < 0.0) normal(a) = -normal(a);
        }
        return {outside.norm() + std::min(deepest, 0.0), R_ * normal};
    }
    ContactPrimitive primitive() const override { return triangle_primitive(mesh(), offset_); }

  private:
    MeshData mesh() const { return placed(box_mesh(size_), center_, R_); }

    Vec3 center_, size_;
    Mat3 R_;
    double offset_;
};

}  // namespace

std::unique_ptr<const ColliderShape> make_box(const ColliderDesc& collider) {
    return std::make_unique<BoxShape>(collider);
}

}  // namespace cloth
