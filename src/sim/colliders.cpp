#include "sim/colliders.h"

#include <algorithm>
#include <cstdio>

#include "sim/mesh.h"
#include "sim/portable_math.h"

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

/// Turn by |degrees| about the axis `degrees`.
Mat3 turn(const Vec3& degrees) {
    const double angle = degrees.norm();
    if (angle == 0.0) return Mat3::Identity();
    const Vec3 k = degrees / angle;
    const double c = cos_degrees(angle), s = sin_degrees(angle);
    Mat3 K;
    K << 0.0, -k.z(), k.y(), k.z(), 0.0, -k.x(), -k.y(), k.x(), 0.0;
    return c * Mat3::Identity() + s * K + (1.0 - c) * k * k.transpose();
}

double contact_radius(const ColliderDesc& c) {
    switch (c.shape) {
        case Shape::sphere:
            return c.contact_radius.value_or(c.radius + c.contact_offset);
        case Shape::capsule:
            return c.radius + c.contact_offset;
        default:
            return c.contact_offset;
    }
}

}  // namespace

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

Placement placement_at(const ColliderDesc& collider, double time) {
    if (collider.path.empty() && collider.spin.isZero(0.0)) return {};
    const MotionKey key = motion_at(collider.path, time);
    Placement p;
    p.rotation = rotation_matrix(key.rotate) * turn(time * collider.spin);
    p.translation = collider.center + key.translate - p.rotation * collider.center;
    return p;
}

std::vector<Placement> placements_at(const std::vector<ColliderDesc>& colliders, double time) {
    std::vector<Placement> all;
    for (const ColliderDesc& c : colliders) all.push_back(placement_at(c, time));
    return all;
}

ContactSystem make_contact_system(const Model& model) {
    const Scene& scene = model.scene;
    ContactSystem s;
    std::vector<Vec3> rest;
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        std::vector<std::array<int, 3>> triangles;
        for (int t = range.first_triangle; t < range.first_triangle + range.triangle_count; ++t) {
            triangles.push_back({model.triangles(t, 0) - range.first_vertex,
                                 model.triangles(t, 1) - range.first_vertex,
                                 model.triangles(t, 2) - range.first_vertex});
        }
        s.mesh.add_body({false, static_cast<int>(c), 0.5 * scene.cloths[c].contact_thickness},
                        range.vertex_count, triangles);
        s.friction.push_back(scene.cloths[c].fabric.friction);
    }
    s.cloth_vertices = model.vertex_count();
    for (int v = 0; v < s.cloth_vertices; ++v) rest.push_back(model.rest_positions.row(v));
    s.mass.assign(model.vertex_mass.begin(), model.vertex_mass.end());
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        const ColliderDesc& collider = scene.colliders[c];
        const ContactBody body{true, static_cast<int>(c), contact_radius(collider)};
        switch (collider.shape) {
            case Shape::plane:
                s.planes.push_back({static_cast<int>(c), collider.center, collider.normal.normalized(),
                                    body.radius, collider.friction});
                continue;
            case Shape::sphere:
                s.mesh.add_body(body, 1, {});
                rest.push_back(collider.center);
                break;
            case Shape::capsule:
                s.mesh.add_body(body, 2, {}, {{0, 1}});
                for (const Vec3& end : capsule_ends(collider)) rest.push_back(end);
                break;
            default: {
                const MeshData surface = collider_surface(collider);
                std::vector<std::array<int, 3>> triangles;
                for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
                    triangles.push_back(
                        {surface.triangles(t, 0), surface.triangles(t, 1), surface.triangles(t, 2)});
                }
                s.mesh.add_body(body, static_cast<int>(surface.positions.rows()), triangles);
                for (Eigen::Index v = 0; v < surface.positions.rows(); ++v) {
                    rest.push_back(surface.positions.row(v));
                }
            }
        }
        s.friction.push_back(collider.friction);
    }
    s.rest.resize(3 * rest.size());
    for (std::size_t v = 0; v < rest.size(); ++v) s.rest.segment<3>(3 * v) = rest[v];
    s.activation = scene.simulation.contact_activation;
    s.sliding_speed = scene.simulation.sliding_speed.value_or(1e-5);
    s.acceleration = scene.simulation.gravity.norm() + s.activation / (model.time_step * model.time_step);
    return s;
}

void require_no_overlap(const Model& model, const BarrierContact& contact, const VecX& x) {
    const auto overlaps = contact.overlaps(x, 10);
    if (overlaps.empty()) return;
    const ContactMesh& mesh = contact.system().mesh;
    auto name = [&](int body) {
        if (body < 0)
            return "collider " + model.scene.colliders[contact.system().planes[-1 - body].collider].name;
        const ContactBody& b = mesh.bodies[body];
        return b.collider ? "collider " + model.scene.colliders[b.index].name
                          : "cloth " + model.cloths[b.index].name;
    };
    auto first_face = [&](int body) {
        for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
            if (mesh.vertex_body[mesh.faces[f][0]] == body) return static_cast<int>(f);
        }
        return 0;
    };
    std::string text;
    auto next = [&] { return std::string(text.empty() ? "things overlap: " : "; "); };
    std::vector<int> triangles;
    std::vector<std::array<Vec3, 3>> corners;
    for (const Overlap& o : overlaps) {
        if (o.faces[0] >= 0) {
            corners.insert(corners.end(), o.corners.begin(), o.corners.end());
            text += next() + name(o.body_a) + " triangle " +
                    std::to_string(o.faces[0] - first_face(o.body_a)) + " crosses " + name(o.body_b) +
                    " triangle " + std::to_string(o.faces[1] - first_face(o.body_b));
            for (int f : o.faces) {
                if (f < model.triangle_count()) triangles.push_back(f);
            }
            continue;
        }
        char gap[32];
        std::snprintf(gap, sizeof gap, "%.3g", -1e3 * o.gap);
        text += next() + name(o.body_a) + " and " + name(o.body_b) + " are " + gap +
                " mm nearer than their contact thickness at vertices";
        for (int v : o.points) {
            if (v < 0) continue;
            int first = v;
            while (first > 0 && mesh.vertex_body[first - 1] == mesh.vertex_body[v]) --first;
            text += " " + std::to_string(v - first);
            if (v >= model.vertex_count()) continue;
            // The triangle at v that has most of the pair's other vertices
            int chosen = -1, most = 0;
            for (int t = 0; t < model.triangle_count(); ++t) {
                if (!(model.triangles.row(t).array() == v).any()) continue;
                int shared = 0;
                for (int p : o.points) shared += p >= 0 && (model.triangles.row(t).array() == p).any();
                if (shared > most) {
                    chosen = t;
                    most = shared;
                }
            }
            if (chosen < 0) continue;
            triangles.push_back(chosen);
            corners.emplace_back();
            for (int k = 0; k < 3; ++k) corners.back()[k] = x.segment<3>(3 * model.triangles(chosen, k));
        }
    }
    if (overlaps.size() == 10) text += "; and maybe more";
    std::sort(triangles.begin(), triangles.end());
    triangles.erase(std::unique(triangles.begin(), triangles.end()), triangles.end());
    throw OverlapError(text, triangles, corners);
}

}  // namespace cloth
