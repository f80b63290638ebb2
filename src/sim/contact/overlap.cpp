#include "sim/contact/overlap.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <set>

#include "sim/contact/ccd.h"

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
        const Vec3 place = colliders.point(x, v);
        boxes[v] = MovingBox(place, place, 0.0);
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

namespace {

/// A number by three digits, the last rounded up.
double rounded_up(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    return std::ceil(value / unit - 1e-3) * unit;
}

std::string digits(double value, int count) {
    char text[32];
    std::snprintf(text, sizeof text, "%.*g", count, value);
    return text;
}

/// What is told of overlaps, and where they are.
class Telling {
  public:
    Telling(const Model& model, ContactSet& set, const VecX& x)
        : model_(model), set_(set), mesh_(set.system().mesh), x_(x), triangles_at_(model.vertex_count()) {
        for (int t = 0; t < model.triangle_count(); ++t) {
            for (int k = 0; k < 3; ++k) triangles_at_[model.triangles(t, k)].push_back(t);
        }
        first_vertex_.assign(mesh_.bodies.size(), -1);
        first_face_.assign(mesh_.bodies.size(), -1);
        for (int v = mesh_.vertex_count() - 1; v >= 0; --v) first_vertex_[mesh_.vertex_body[v]] = v;
        for (int f = static_cast<int>(mesh_.faces.size()) - 1; f >= 0; --f) first_face_[body_of_face(f)] = f;
    }

    /// One clause for each two bodies that overlap, cloth first.
    std::string pairs(const std::vector<Overlap>& overlaps) const {
        std::map<std::array<int, 2>, std::vector<Overlap>> crossing, near;
        for (const Overlap& o : overlaps) {
            std::array<int, 2> bodies{cloth_body(o), other_body(o)};
            if (is_cloth(bodies[1])) std::sort(bodies.begin(), bodies.end());
            (o.faces[0] >= 0 ? crossing : near)[bodies].push_back(o);
        }
        std::string text;
        for (auto& [bodies, list] : crossing) text += crossings(list) + "; ";
        for (auto& [bodies, list] : near) text += gaps(bodies, list) + "; ";
        return text.substr(0, text.size() - 2);
    }

    /// How far to move the cloths that overlap so that the start is free; empty where that is not as simple.
    std::string advice(const std::vector<Overlap>& overlaps) const {
        std::map<int, Vec3> ways;  // body of a cloth → direction
        for (const Overlap& o : overlaps) {
            const int other = other_body(o);
            if (other == cloth_body(o)) return "";
            Vec3 up = Vec3::UnitY();
            if (other < 0) {
                const Vec3 normal = set_.colliders().plane(-1 - other).normal;
                if (normal.y() < 0.5) up = normal;
            }
            const auto [way, added] = ways.emplace(moved_body(o), up);
            if (!added && way->second != up) return "";
        }
        std::string text;
        VecX free = x_;
        for (const auto& [body, way] : ways) {
            const double far = rounded_up(distance_to_free(body, way) + 0.01 * set_.system().activation);
            const ClothRange& range = model_.cloths[mesh_.bodies[body].index];
            auto own =
                free.segment(3 * range.first_vertex, 3 * range.vertex_count).reshaped(3, range.vertex_count);
            const double size = (own.rowwise().maxCoeff() - own.rowwise().minCoeff()).norm();
            if (!(far < size)) return "";
            own.colwise() += far * way;
            const Vec3 there = model_.scene.cloths[mesh_.bodies[body].index].transform.translate + far * way;
            const bool up = way == Vec3::UnitY();
            text += std::string("; ") + (up ? "lift " : "move ") + name(body) + " by " +
                    digits(1e3 * far, 3) + " mm, to translate = [" + digits(there.x(), 9) + ", " +
                    digits(there.y(), 9) + ", " + digits(there.z(), 9) + "]";
        }
        return find_overlaps(set_, free, 1).empty() ? text : "";
    }

    /// Cloth's triangles at the overlaps, and the corners of all that are.
    void mark(const std::vector<Overlap>& overlaps, std::vector<int>& triangles,
              std::vector<std::array<Vec3, 3>>& corners) const {
        std::set<int> own, of_colliders;
        for (const Overlap& o : overlaps) {
            for (int f : o.faces) {
                if (f >= 0) (f < model_.triangle_count() ? own : of_colliders).insert(f);
            }
            for (int v : o.points) {
                if (v < 0 || v >= model_.vertex_count()) continue;
                if (o.body_b < 0) {
                    own.insert(triangles_at_[v].begin(), triangles_at_[v].end());
                    continue;
                }
                // The triangle at v that has most of the pair's other vertices
                const auto shared = [&](int t) {
                    return std::count_if(o.points.begin(), o.points.end(), [&](int p) {
                        return p >= 0 && (model_.triangles.row(t).array() == p).any();
                    });
                };
                own.insert(*std::max_element(triangles_at_[v].begin(), triangles_at_[v].end(),
                                             [&](int s, int t) { return shared(s) < shared(t); }));
            }
        }
        triangles.assign(own.begin(), own.end());
        of_colliders.insert(own.begin(), own.end());
        for (int f : of_colliders) {
            corners.emplace_back();
            for (int k = 0; k < 3; ++k) corners.back()[k] = set_.colliders().point(x_, mesh_.faces[f][k]);
        }
    }

  private:
    int body_of_face(int f) const { return mesh_.vertex_body[mesh_.faces[f][0]]; }
    bool is_cloth(int body) const { return body >= 0 && !mesh_.bodies[body].collider; }
    int cloth_body(const Overlap& o) const { return is_cloth(o.body_a) ? o.body_a : o.body_b; }
    int other_body(const Overlap& o) const { return is_cloth(o.body_a) ? o.body_b : o.body_a; }
    std::string name(int body) const {
        if (body < 0) {
            return "collider " + model_.scene.colliders[set_.system().planes[-1 - body].collider].name;
        }
        const ContactBody& b = mesh_.bodies[body];
        return b.collider ? "collider " + model_.scene.colliders[b.index].name
                          : "cloth " + model_.cloths[b.index].name;
    }
    std::string face_text(int f) const {
        const int body = body_of_face(f);
        return name(body) + " triangle " + std::to_string(f - first_face_[body]);
    }

    std::string crossings(const std::vector<Overlap>& list) const {
        constexpr std::size_t most = 3;
        std::string text;
        for (std::size_t i = 0; i < std::min(most, list.size()); ++i) {
            auto [f, g] = list[i].faces;
            if (!is_cloth(body_of_face(f))) std::swap(f, g);
            text += (text.empty() ? "" : "; ") + face_text(f) + " crosses " + face_text(g);
        }
        if (list.size() > most) text += ", and so at " + std::to_string(list.size() - most) + " more places";
        return text;
    }

    std::string gaps(const std::array<int, 2>& bodies, std::vector<Overlap>& list) const {
        constexpr std::size_t most = 8;
        std::stable_sort(list.begin(), list.end(),
                         [](const Overlap& a, const Overlap& b) { return a.gap < b.gap; });
        std::string text = name(bodies[0]) + " and " + (bodies[0] == bodies[1] ? "itself" : name(bodies[1])) +
                           " are " + digits(-1e3 * list.front().gap, 3) +
                           " mm nearer than their contact thickness at vertices";
        for (int body : bodies) {
            if (body < 0 || (body != bodies[0] && mesh_.bodies[body].collider && first_face_[body] < 0))
                continue;
            std::vector<int> vertices;
            for (const Overlap& o : list) {
                for (int v : o.points) {
                    if (v < 0 || mesh_.vertex_body[v] != body) continue;
                    if (std::find(vertices.begin(), vertices.end(), v) == vertices.end())
                        vertices.push_back(v);
                }
            }
            text += body == bodies[0] ? " " : " and ";
            for (std::size_t i = 0; i < std::min(most, vertices.size()); ++i) {
                text += (i ? ", " : "") + std::to_string(vertices[i] - first_vertex_[body]);
            }
            if (vertices.size() > most) text += " and " + std::to_string(vertices.size() - most) + " more";
            text += " of " + name(body);
            if (bodies[0] == bodies[1]) break;
        }
        return text;
    }

    /// Of two cloths the higher one.
    int moved_body(const Overlap& o) const {
        const int a = cloth_body(o), b = other_body(o);
        const auto height = [&](int body) {
            const ClothRange& range = model_.cloths[mesh_.bodies[body].index];
            return x_.segment(3 * range.first_vertex, 3 * range.vertex_count)
                .reshaped(3, range.vertex_count)
                .row(1)
                .mean();
        };
        return is_cloth(b) && height(b) > height(a) ? b : a;
    }

    /// The way `up` to where nothing below is met, looked for from above all that there is.
    double distance_to_free(int body, const Vec3& up) const {
        const ContactSystem& system = set_.system();
        const MovingColliders& colliders = set_.colliders();
        const ClothRange& range = model_.cloths[mesh_.bodies[body].index];
        const int first = range.first_vertex, end = first + range.vertex_count;
        double bottom = std::numeric_limits<double>::infinity(), top = -bottom, above = 0.0;
        for (int v = 0; v < mesh_.vertex_count(); ++v) {
            const bool own = v >= first && v < end;
            if (!colliders.body_on()[mesh_.vertex_body[v]]) continue;
            const double height = up.dot(colliders.point(x_, v));
            if (own) {
                bottom = std::min(bottom, height);
            } else {
                top = std::max(top, height + system.radius_of(v));
            }
        }
        for (std::size_t p = 0; p < system.planes.size(); ++p) {
            const MovingColliders::Plane& plane = colliders.plane(p);
            const double rise = plane.normal.dot(up);
            if (!colliders.on(system.planes[p].collider) || rise < 0.1) continue;
            for (int v = first; v < end; ++v) {
                const double gap = plane.normal.dot(Vec3(x_.segment<3>(3 * v)) - plane.point) -
                                   system.planes[p].radius - system.radius_of(v);
                above = std::max(above, -gap / rise);
            }
        }
        const double radius = mesh_.bodies[body].radius;
        double height = std::max(above, top + radius - bottom) + system.activation;
        if (!std::isfinite(height)) height = above + system.activation;
        VecX way = VecX::Zero(x_.size());
        way.segment(3 * first, 3 * range.vertex_count).reshaped(3, range.vertex_count).colwise() = up;
        for (int k = 0; k < 12; ++k) {
            height -= height * largest_share(set_, x_ + height * way, -height * way);
        }
        return height;
    }

    const Model& model_;
    ContactSet& set_;
    const ContactMesh& mesh_;
    const VecX& x_;
    std::vector<std::vector<int>> triangles_at_;
    std::vector<int> first_vertex_, first_face_;  ///< per body; -1: none
};

}  // namespace

void require_no_overlap(const Model& model, ContactSet& set, const VecX& x, const std::string& occasion) {
    const auto overlaps = find_overlaps(set, x, std::numeric_limits<std::size_t>::max());
    if (overlaps.empty()) return;
    const Telling telling(model, set, x);
    std::vector<int> triangles;
    std::vector<std::array<Vec3, 3>> corners;
    telling.mark(overlaps, triangles, corners);
    throw OverlapError("things overlap" + occasion + ": " + telling.pairs(overlaps) +
                           (occasion.empty() ? telling.advice(overlaps) : ""),
                       triangles, corners);
}

}  // namespace cloth
