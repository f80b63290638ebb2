#include "pipeline/picture/frame_builder.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

#include "pipeline/picture/rest_chart.h"
#include "sim/geometry/vertex_normals.h"
#include "sim/motion/placement.h"
#include "sim/shapes/shapes.h"

namespace cloth::pipeline {

namespace {

void append(std::vector<float>& list, const Vec3& v) {
    for (int i = 0; i < 3; ++i) list.push_back(static_cast<float>(v[i]));
}

void append_triangle(std::vector<std::uint32_t>& list, int a, int b, int c) {
    for (const int corner : {a, b, c}) list.push_back(static_cast<std::uint32_t>(corner));
}

Vec3 vector_at(const std::vector<float>& list, int i) {
    const float* p = list.data() + 3 * static_cast<std::size_t>(i);
    return {p[0], p[1], p[2]};
}

/// Across half of a rolled edge: shares of its half thickness outwards and upwards, and the normal there.
struct RimPoint {
    double out, up, normal_out, normal_up;
};
constexpr std::array<RimPoint, 5> rim_profile{{{-3.0, 0.0, 0.0, 1.0},
                                               {-1.3, 0.8, -0.4, 0.92},
                                               {0.0, 1.0, 0.0, 1.0},
                                               {0.71, 0.71, 0.71, 0.71},
                                               {1.0, 0.0, 1.0, 0.0}}};

}  // namespace

FrameBuilder::Rim FrameBuilder::make_rim(const Subdivision& fine, const Mesh& cloth) const {
    // Edges of one triangle, in its direction: from each rim vertex to the next
    std::map<std::pair<int, int>, int> edges;
    for (Eigen::Index t = 0; t < fine.triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) ++edges[{fine.triangles(t, k), fine.triangles(t, (k + 1) % 3)}];
    std::map<int, std::pair<int, int>> links;  // vertex → before, after
    std::vector<std::pair<int, int>> rim_edges;
    for (const auto& [edge, count] : edges)
        if (!edges.contains({edge.second, edge.first})) rim_edges.push_back(edge);
    for (const auto& [a, b] : rim_edges) {
        links.try_emplace(a, a, a).first->second.second = b;
        links.try_emplace(b, b, b).first->second.first = a;
    }
    const auto chart = [&](int i) {
        return Vec2(cloth.coordinates[2 * static_cast<std::size_t>(i)],
                    cloth.coordinates[2 * static_cast<std::size_t>(i) + 1]);
    };
    Rim rim;
    std::map<int, int> number;
    for (const auto& [at, ends] : links) {
        const Vec2 along = chart(ends.second) - chart(ends.first);
        const Vec2 outward = Vec2(along.y(), -along.x());
        number[at] = static_cast<int>(rim.vertices.size());
        rim.vertices.push_back({at, ends.first, ends.second,
                                outward.norm() > 0 ? Vec2(outward.normalized()) : Vec2(Vec2::Zero())});
    }
    constexpr int across = rim_profile.size();
    for (const int half : {0, 1}) {
        Mesh& mesh = rim.halves[half];
        for (const auto& [a, b] : rim_edges)
            for (int k = 0; k + 1 < across; ++k) {
                const int p = across * number.at(a) + k, q = across * number.at(b) + k;
                if (half == 0) {
                    append_triangle(mesh.triangles, p, p + 1, q);
                    append_triangle(mesh.triangles, q, p + 1, q + 1);
                } else {
                    append_triangle(mesh.triangles, p, q, p + 1);
                    append_triangle(mesh.triangles, q, q + 1, p + 1);
                }
            }
    }
    return rim;
}

void FrameBuilder::place_rim(Rim& rim, const Mesh& cloth, const std::vector<double>& half_at) const {
    for (const int half : {0, 1}) {
        Mesh& mesh = rim.halves[half];
        mesh.positions.clear();
        mesh.normals.clear();
        mesh.coordinates.clear();
        for (const Rim::Vertex& v : rim.vertices) {
            const Vec3 up = (half == 0 ? 1.0 : -1.0) * vector_at(cloth.normals, v.at);
            const Vec3 along = vector_at(cloth.positions, v.after) - vector_at(cloth.positions, v.before);
            Vec3 out = (half == 0 ? 1.0 : -1.0) * along.cross(up);
            out = out.norm() > 0 ? Vec3(out.normalized()) : Vec3(Vec3::Zero());
            const double thick = half_at[static_cast<std::size_t>(v.at)];
            for (const RimPoint& r : rim_profile) {
                append(mesh.positions, vector_at(cloth.positions, v.at) + thick * (r.out * out + r.up * up));
                append(mesh.normals, (r.normal_out * out + r.normal_up * up + 1e-9 * up).normalized());
                for (int k = 0; k < 2; ++k)
                    mesh.coordinates.push_back(cloth.coordinates[2 * static_cast<std::size_t>(v.at) + k] +
                                               static_cast<float>(thick * r.out * v.outward[k]));
            }
        }
    }
}

FrameBuilder::FrameBuilder(const SceneFile& file, const Model& model)
    : file_(file),
      model_(model),
      clearance_(model, file.ground ? std::optional<double>(file.ground->height) : std::nullopt) {
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& cloth = model.cloths[c];
        const Triangles own = model.triangles.middleRows(cloth.first_triangle, cloth.triangle_count).array() -
                              cloth.first_vertex;
        subdivisions_.push_back(
            subdivide(model.rest_positions.middleRows(cloth.first_vertex, cloth.vertex_count), own,
                      file.cloth_looks.at(c).subdivisions));
        const Subdivision& fine = subdivisions_.back();
        Mesh mesh;
        for (Eigen::Index t = 0; t < fine.triangles.rows(); ++t)
            append_triangle(mesh.triangles, fine.triangles(t, 0), fine.triangles(t, 1), fine.triangles(t, 2));
        mesh.positions.resize(3 * static_cast<std::size_t>(fine.weights.rows()));
        mesh.normals.resize(mesh.positions.size());
        const Points rest = model.rest_positions.middleRows(cloth.first_vertex, cloth.vertex_count);
        const auto chart = rest_chart(fine.weights * rest, fine.triangles);
        for (Eigen::Index i = 0; i < chart.rows(); ++i)
            for (int k = 0; k < 2; ++k) mesh.coordinates.push_back(static_cast<float>(chart(i, k)));
        rims_.push_back(file.cloth_looks.at(c).hem > 0 ? make_rim(fine, mesh) : Rim{});
        cloths_.push_back(std::move(mesh));
    }
    for (const ColliderDesc& collider : model.scene.colliders) {
        const Surface surface = make_shape(collider)->surface();
        Collider drawn;
        for (Eigen::Index v = 0; v < surface.positions.rows(); ++v) {
            append(drawn.mesh.positions, surface.positions.row(v));
            append(drawn.mesh.normals, surface.normals.row(v));
        }
        for (Eigen::Index t = 0; t < surface.triangles.rows(); ++t) {
            append_triangle(drawn.mesh.triangles, surface.triangles(t, 0), surface.triangles(t, 1),
                            surface.triangles(t, 2));
        }
        drawn.endless = surface.endless;
        const double up = surface.endless ? surface.normals(0, 1) : 0.0;
        drawn.floor = up > 0.5;
        drawn.ground =
            up == 1.0 && collider.path.empty() && collider.spin.x() == 0.0 && collider.spin.z() == 0.0;
        if (!collider.path.empty() || !collider.spin.isZero(0.0) || collider.cache) {
            moving_.push_back({static_cast<int>(colliders_.size()), drawn.mesh});
        }
        colliders_.push_back(std::move(drawn));
    }
}

std::vector<FrameBuilder::Sheet> FrameBuilder::sheets(const State& state) const {
    // Of what is left between two surfaces a part stays, so that pictures in floats tell them apart.
    constexpr double used = 0.9;
    std::vector<Sheet> sheets;
    std::vector<double> reach(model_.triangle_count(), 0.0);
    // Calls work(fine vertex, simulated triangle) for all corners of all parts of each triangle.
    const auto for_each_corner = [&](std::size_t c, const auto& work) {
        const Triangles& fine = subdivisions_[c].triangles;
        const Eigen::Index parts = fine.rows() / model_.cloths[c].triangle_count;
        for (Eigen::Index t = 0; t < fine.rows(); ++t)
            for (int k = 0; k < 3; ++k)
                work(fine(t, k), model_.cloths[c].first_triangle + static_cast<int>(t / parts));
    };
    for (std::size_t c = 0; c < cloths_.size(); ++c) {
        const ClothRange& cloth = model_.cloths[c];
        const Eigen::Map<const Points> coarse(state.positions.data() + 3 * cloth.first_vertex,
                                              cloth.vertex_count, 3);
        const double half = 0.5 * file_.cloth_looks.at(c).hem;
        Sheet sheet{subdivisions_[c].weights * coarse, subdivisions_[c].flat * coarse, {}, {}, {}};
        sheet.way = (sheet.smooth - sheet.flat).rowwise().norm();
        sheet.half.assign(static_cast<std::size_t>(sheet.flat.rows()), 0.0);
        for (const Rim::Vertex& v : rims_[c].vertices) sheet.half[static_cast<std::size_t>(v.at)] = half;
        for_each_corner(
            c, [&](int v, int t) { reach[t] = std::max(reach[t], (sheet.way(v) + sheet.half[v]) / used); });
        sheets.push_back(std::move(sheet));
    }
    const Clearance::Room room = clearance_.find(state, reach);
    for (std::size_t c = 0; c < cloths_.size(); ++c) {
        Sheet& sheet = sheets[c];
        std::vector<double> all(sheet.half.size(), std::numeric_limits<double>::infinity()), layers = all;
        for_each_corner(c, [&](int v, int t) {
            all[v] = std::min(all[v], used * room.all[t]);
            layers[v] = std::min(layers[v], used * room.layers[t]);
        });
        sheet.drawn = sheet.smooth;
        for (std::size_t i = 0; i < all.size(); ++i) {
            const auto v = static_cast<Eigen::Index>(i);
            const double taken = std::min(sheet.way(v), all[i]);
            if (taken < sheet.way(v))
                sheet.drawn.row(v) =
                    sheet.flat.row(v) + (taken / sheet.way(v)) * (sheet.smooth.row(v) - sheet.flat.row(v));
            // A rim may stand into a collider: the sheet before it hides that.
            sheet.half[i] = std::min(sheet.half[i], std::max(layers[i] - taken, 0.0));
        }
    }
    return sheets;
}

render::Frame FrameBuilder::build(const State& state) {
    if (state.positions.size() != 3 * static_cast<Eigen::Index>(model_.vertex_count()) ||
        state.collider_on.size() != colliders_.size())
        throw std::invalid_argument("the state does not fit the scene");
    render::Frame frame;
    frame.ground = file_.ground;
    const std::vector<Sheet> drawn = sheets(state);
    for (std::size_t c = 0; c < cloths_.size(); ++c) {
        Mesh& mesh = cloths_[c];
        const Subdivision& fine = subdivisions_[c];
        const Points& positions = drawn[c].drawn;
        const Points normals = vertex_normals(drawn[c].smooth, fine.triangles);
        for (Eigen::Index i = 0; i < positions.rows(); ++i) {
            for (int k = 0; k < 3; ++k) {
                mesh.positions[3 * static_cast<std::size_t>(i) + k] = static_cast<float>(positions(i, k));
                mesh.normals[3 * static_cast<std::size_t>(i) + k] = static_cast<float>(normals(i, k));
            }
        }
        frame.surfaces.push_back(
            {mesh.positions, mesh.normals, mesh.triangles, file_.cloth_looks.at(c).material, true});
        frame.surfaces.back().coordinates = mesh.coordinates;
    }
    for (const auto& [c, start] : moving_) {
        const Placement placement = placement_at(model_.scene.colliders[c], state.time);
        Mesh& mesh = colliders_[c].mesh;
        if (placement.bent) {
            const Surface surface = make_shape(model_.scene.colliders[c], placement)->surface();
            mesh.positions.clear();
            mesh.normals.clear();
            for (Eigen::Index v = 0; v < surface.positions.rows(); ++v) {
                append(mesh.positions, placement(surface.positions.row(v)));
                append(mesh.normals, placement.rotation * Vec3(surface.normals.row(v)));
            }
            continue;
        }
        for (std::size_t i = 0; i + 2 < start.positions.size(); i += 3) {
            const Vec3 p =
                placement(Vec3(start.positions[i], start.positions[i + 1], start.positions[i + 2]));
            const Vec3 n =
                placement.rotation * Vec3(start.normals[i], start.normals[i + 1], start.normals[i + 2]);
            for (int k = 0; k < 3; ++k) {
                mesh.positions[i + k] = static_cast<float>(p[k]);
                mesh.normals[i + k] = static_cast<float>(n[k]);
            }
        }
    }
    for (std::size_t c = 0; c < colliders_.size(); ++c) {
        const ColliderDesc& collider = model_.scene.colliders[c];
        const Collider& shown = colliders_[c];
        if (!collider.drawn || state.collider_on[c] == 0) continue;
        const render::Material& material = file_.collider_looks.at(c).material;
        if (!frame.ground && shown.ground) {
            frame.ground = render::Ground{static_cast<float>(collider.center.y()), material.front};
            continue;
        }
        const Mesh& mesh = shown.mesh;
        frame.surfaces.push_back({mesh.positions, mesh.normals, mesh.triangles, material, false});
        if (!shown.endless) continue;
        frame.surfaces.back().casts_shadow = false;  // its metres would take all of the shadow map
        if (shown.floor) frame.floor_color = material.front;
    }
    for (std::size_t c = 0; c < cloths_.size(); ++c) {
        const Look& look = file_.cloth_looks.at(c);
        if (rims_[c].vertices.empty()) continue;
        place_rim(rims_[c], cloths_[c], drawn[c].half);
        for (const int half : {0, 1}) {
            const Mesh& mesh = rims_[c].halves[half];
            render::Material material = look.material;
            if (half == 1) {
                material.front = material.back;
                if (!material.pattern_on_back) material.pattern = render::Pattern::plain;
            }
            frame.surfaces.push_back({mesh.positions, mesh.normals, mesh.triangles, material, false});
            frame.surfaces.back().coordinates = mesh.coordinates;
            frame.surfaces.back().casts_shadow = false;  // the cloth's own is as wide
        }
    }
    return frame;
}

}  // namespace cloth::pipeline
