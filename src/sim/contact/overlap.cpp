#include "sim/contact/overlap.h"

#include <algorithm>
#include <cstdio>

namespace cloth {

std::vector<Overlap> find_overlaps(const ContactSet& set, const VecX& x, std::size_t most) {
    std::vector<Overlap> found;
    const ContactMesh& mesh = set.system().mesh;
    const MovingColliders& colliders = set.colliders();
    auto corners_of = [&](const std::array<int, 3>& face) {
        return std::array<Vec3, 3>{colliders.point(x, face[0]), colliders.point(x, face[1]),
                                   colliders.point(x, face[2])};
    };
    std::vector<MovingBox> boxes(mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        boxes[v].start.add(colliders.point(x, v));
        boxes[v].end = boxes[v].start;
    }
    for (const auto& [f, g] : set.candidates().broad_phase().face_pairs(mesh, boxes, colliders.body_on())) {
        if (found.size() >= most) return found;
        const auto a = corners_of(mesh.faces[f]), b = corners_of(mesh.faces[g]);
        if (!triangles_cross(a, b)) continue;
        Overlap o;
        o.faces = {f, g};
        o.body_a = mesh.vertex_body[mesh.faces[f][0]];
        o.body_b = mesh.vertex_body[mesh.faces[g][0]];
        o.corners = {a, b};
        found.push_back(o);
    }
    std::vector<Contact> memory;
    for (const Contact& c : set.contacts(x, memory)) {
        if (found.size() >= most) return found;
        if (c.gap > 0.0) continue;
        Overlap o;
        o.points = c.points;
        o.gap = c.gap;
        o.body_a = mesh.vertex_body[c.points[0]];
        o.body_b = c.plane >= 0 ? -1 - c.plane : mesh.vertex_body[c.points[c.split()]];
        found.push_back(o);
    }
    return found;
}

void require_no_overlap(const Model& model, const ContactSet& set, const VecX& x) {
    const auto overlaps = find_overlaps(set, x, 10);
    if (overlaps.empty()) return;
    const ContactMesh& mesh = set.system().mesh;
    auto name = [&](int body) {
        if (body < 0)
            return "collider " + model.scene.colliders[set.system().planes[-1 - body].collider].name;
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
