#include "sim/shapes/shapes.h"

#include "base/portable_math.h"
#include "sim/scene/mesh.h"

namespace cloth {
namespace {

MeshData box_surface(const Vec3& size) {
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

/// Axis along y.
MeshData cylinder_surface(double radius, double height) {
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

}  // namespace

double contact_reach(const ColliderDesc& c) {
    switch (c.shape) {
        case Shape::sphere:
            return c.contact_radius.value_or(c.radius + c.contact_offset);
        case Shape::capsule:
            return c.radius + c.contact_offset;
        default:
            return c.contact_offset;
    }
}

MeshData collider_surface(const ColliderDesc& collider) {
    MeshData mesh;
    if (collider.shape == Shape::box) mesh = box_surface(collider.size);
    if (collider.shape == Shape::cylinder) mesh = cylinder_surface(collider.radius, collider.height);
    if (collider.shape == Shape::mesh) mesh = *collider.mesh;
    const double scale = collider.shape == Shape::mesh ? collider.scale : 1.0;
    const Mat3 R = rotation_matrix(collider.rotate);
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
        const Vec3 p = mesh.positions.row(v);
        mesh.positions.row(v) = (collider.center + R * (scale * p)).transpose();
    }
    return mesh;
}

std::array<Vec3, 2> capsule_ends(const ColliderDesc& collider) {
    const Vec3 half = rotation_matrix(collider.rotate) * Vec3(0.0, 0.5 * collider.height, 0.0);
    return {collider.center - half, collider.center + half};
}

}  // namespace cloth
