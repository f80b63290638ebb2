#include "sim/shapes/surfaces.h"

#include <cmath>
#include <numbers>

namespace cloth {
namespace {

/// Chord error 0.03 % of the radius: below a pixel up to 8k pictures' width.
constexpr int meridians = 128, parallels = 64;

}  // namespace

Surface round_surface(const std::array<Vec3, 2>& ends, const Mat3& turn, double radius) {
    Surface s;
    // Rings from pole to pole; the poles are rings of coinciding vertices.
    s.positions.resize((parallels + 1) * meridians, 3);
    s.normals.resize(s.positions.rows(), 3);
    for (int j = 0; j <= parallels; ++j) {
        for (int i = 0; i < meridians; ++i) {
            const double polar = std::numbers::pi * j / parallels;
            const double azimuth = 2.0 * std::numbers::pi * i / meridians;
            const Vec3 normal = turn * Vec3(std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                            -std::sin(polar) * std::sin(azimuth));
            s.positions.row(j * meridians + i) = (ends[2 * j <= parallels] + radius * normal).transpose();
            s.normals.row(j * meridians + i) = normal.transpose();
        }
    }
    s.triangles.resize(2 * (parallels - 1) * meridians, 3);
    Eigen::Index t = 0;
    for (int j = 0; j < parallels; ++j) {
        for (int i = 0; i < meridians; ++i) {
            const int next = (i + 1) % meridians;
            const int a = j * meridians + i, b = j * meridians + next;
            const int c = a + meridians, d = b + meridians;
            if (j > 0) s.triangles.row(t++) << a, c, b;
            if (j + 1 < parallels) s.triangles.row(t++) << b, c, d;
        }
    }
    return s;
}

Surface flat_surface(const MeshData& mesh) {
    Surface s;
    const Eigen::Index count = mesh.triangles.rows();
    s.positions.resize(3 * count, 3);
    s.normals.resize(3 * count, 3);
    s.triangles.resize(count, 3);
    for (Eigen::Index t = 0; t < count; ++t) {
        for (int k = 0; k < 3; ++k) {
            s.positions.row(3 * t + k) = mesh.positions.row(mesh.triangles(t, k));
            s.triangles(t, k) = static_cast<int>(3 * t + k);
        }
        const Vec3 a = s.positions.row(3 * t), b = s.positions.row(3 * t + 1), c = s.positions.row(3 * t + 2);
        const Vec3 normal = (b - a).cross(c - a).normalized();
        for (int k = 0; k < 3; ++k) s.normals.row(3 * t + k) = normal.transpose();
    }
    return s;
}

MeshData placed(MeshData mesh, const Vec3& center, const Mat3& R, double scale) {
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v) {
        const Vec3 p = mesh.positions.row(v);
        mesh.positions.row(v) = (center + R * (scale * p)).transpose();
    }
    return mesh;
}

ContactPrimitive triangle_primitive(const MeshData& mesh, double radius) {
    ContactPrimitive primitive{radius};
    for (Eigen::Index v = 0; v < mesh.positions.rows(); ++v)
        primitive.points.push_back(mesh.positions.row(v));
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        primitive.triangles.push_back({mesh.triangles(t, 0), mesh.triangles(t, 1), mesh.triangles(t, 2)});
    }
    return primitive;
}

}  // namespace cloth
