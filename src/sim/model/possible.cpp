#include "sim/model/possible.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <queue>
#include <string>
#include <utility>

#include "sim/energies/membrane.h"
#include "sim/model.h"
#include "sim/motion/pins.h"
#include "sim/motion/placement.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"
#include "sim/scene/schema.h"
#include "sim/shapes/shapes.h"

namespace cloth {
namespace {

std::string cloth_key(std::size_t cloth, const char* key) {
    return "cloth[" + std::to_string(cloth) + "]." + key;
}

std::string place_text(const Vec3& p) {
    return "(" + number_text(p.x()) + ", " + number_text(p.y()) + ", " + number_text(p.z()) + ")";
}

/// "; strain limit 1.05 (cloth[0].fabric.strain_limit)"; `part`: whose fabric it is, -1: the cloth's.
std::string limit_text(std::size_t cloth, int part, double limit) {
    const std::string key = part < 0 ? cloth_key(cloth, "fabric.strain_limit")
                                     : "part[" + std::to_string(part) + "].fabric.strain_limit";
    return "; strain limit " + number_text(limit) + " (" + key + ")";
}

/// Strain limit of each triangle of a cloth, infinite where there is none.
std::vector<double> strain_limits(const Scene& scene, std::size_t cloth, const std::vector<int>& part) {
    std::vector<double> limits;
    for (const int p : part)
        limits.push_back(
            (p < 0 ? scene.cloths[cloth].fabric : scene.parts[static_cast<std::size_t>(p)].fabric)
                .strain_limit.value_or(std::numeric_limits<double>::infinity()));
    return limits;
}

// ---------------------------------------------------------------- the start

struct Stretched {
    double stretch = 0.0, limit = 1.0;
    int triangle = 0;
    Vec3 place = Vec3::Zero();  ///< its middle [m]
};

/// The triangle whose stretch at `x` is greatest against its limit.
Stretched most_stretched(const Points& rest_corners, const MeshData& rest, const Points& x,
                         const std::vector<double>& limits) {
    Stretched most;
    const auto corner = [&](Eigen::Index t, int k) { return Vec3(x.row(rest.triangles(t, k))); };
    for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
        const Points& X = rest_corners;
        const TriangleRest triangle =
            make_triangle_rest(X.row(3 * t), X.row(3 * t + 1), X.row(3 * t + 2), 1.0, 1.0, 1.0);
        Vec9 q;
        q << corner(t, 0), corner(t, 1), corner(t, 2);
        const double stretch = membrane_stretch(triangle, q), limit = limits[static_cast<std::size_t>(t)];
        // What is beyond its limit by most; without any, what is stretched most.
        if (!(stretch * most.limit > most.stretch * limit)) continue;
        most = {stretch, limit, static_cast<int>(t), q.reshaped(3, 3).rowwise().mean()};
    }
    return most;
}

// ---------------------------------------------------------------- pins

/// Shortest way along edges from `source` to every vertex; infinite where there is none [m].
std::vector<double> ways_along_edges(const Points& rest_corners, const MeshData& rest, int source) {
    struct Edge {
        int to;
        double length;  ///< [m]
    };
    std::vector<std::vector<Edge>> edges(rest.positions.rows());
    for (Eigen::Index t = 0; t < rest.triangles.rows(); ++t) {
        for (int k = 0; k < 3; ++k) {
            const int a = rest.triangles(t, k), b = rest.triangles(t, (k + 1) % 3);
            const double length =
                (rest_corners.row(3 * t + (k + 1) % 3) - rest_corners.row(3 * t + k)).norm();
            edges[a].push_back({b, length});
            edges[b].push_back({a, length});
        }
    }
    std::vector<double> way(rest.positions.rows(), std::numeric_limits<double>::infinity());
    using Entry = std::pair<double, int>;
    std::priority_queue<Entry, std::vector<Entry>, std::greater<>> open;
    way[source] = 0.0;
    open.push({0.0, source});
    while (!open.empty()) {
        const auto [length, v] = open.top();
        open.pop();
        if (length > way[v]) continue;
        for (const auto& [w, edge] : edges[v]) {
            const double further = length + edge;
            if (further < way[w]) {
                way[w] = further;
                open.push({further, w});
            }
        }
    }
    return way;
}

/// A vertex that a pin holds, by its number in its cloth and its place in the group.
struct Held {
    int vertex;
    std::size_t in_group;
};

/// Some of a group's vertices, evenly among them, that no other group before it holds.
std::vector<Held> some_of(const std::vector<PinGroup>& groups, std::size_t g, int first_vertex) {
    constexpr std::size_t most = 32;
    std::vector<Held> own;
    for (std::size_t i = 0; i < groups[g].vertices.size(); ++i) {
        const int v = groups[g].vertices[i];
        const bool taken = std::any_of(
            groups.begin(), groups.begin() + static_cast<std::ptrdiff_t>(g), [&](const PinGroup& before) {
                return std::find(before.vertices.begin(), before.vertices.end(), v) != before.vertices.end();
            });
        if (!taken) own.push_back({v - first_vertex, i});
    }
    if (own.size() <= most) return own;
    std::vector<Held> some;
    for (std::size_t i = 0; i < most; ++i) some.push_back(own[i * (own.size() - 1) / (most - 1)]);
    return some;
}

/// Two pins of one cloth, and the stretch that they ask of it.
struct Pull {
    double stretch = 0.0, time = 0.0, apart = 0.0, at_rest = 0.0;
    std::int64_t frame = 0;
    std::array<int, 2> vertices{};
    std::array<Vec3, 2> places{Vec3::Zero(), Vec3::Zero()};
};

/// Refuses what pins g < h, both of `cloth`, ask for.
void require_reachable(const Scene& scene, const MeshData& rest, const std::vector<PinGroup>& groups,
                       std::size_t g, std::size_t h, int first_vertex, double last) {
    const std::size_t cloth = static_cast<std::size_t>(scene.pins[g].cloth);
    const std::vector<int> part = part_of_triangles(scene, cloth, rest);
    const std::vector<double> limits = strain_limits(scene, cloth, part);
    const auto loosest = std::max_element(limits.begin(), limits.end());
    const double limit = *loosest;
    if (std::isinf(limit)) return;
    const Points corners = rest_corners(scene.cloths[cloth], rest);
    const bool flat = !scene.cloths[cloth].mesh;  // and convex: the shortest way is straight
    const std::vector<Held> a = some_of(groups, g, first_vertex), b = some_of(groups, h, first_vertex);
    std::vector<double> at_rest;
    for (const Held& p : a) {
        const std::vector<double> ways =
            flat ? std::vector<double>() : ways_along_edges(corners, rest, p.vertex);
        for (const Held& q : b) {
            at_rest.push_back(flat ? (rest.positions.row(p.vertex) - rest.positions.row(q.vertex)).norm()
                                   : ways[q.vertex]);
        }
    }
    Pull first, most;
    const SimulationDesc& options = scene.simulation;
    const double until = std::min(groups[g].until.value_or(last), groups[h].until.value_or(last));
    const auto frames = static_cast<std::int64_t>(std::floor(last * options.frame_rate + 1e-6));
    for (std::int64_t frame = 1; frame <= frames; ++frame) {
        const double time = static_cast<double>(frame) / options.frame_rate;
        if (time > until) break;
        const std::vector<Vec3> places_a = groups[g].places(time), places_b = groups[h].places(time);
        Pull now;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const Vec3 p = places_a[a[i].in_group];
            for (std::size_t j = 0; j < b.size(); ++j) {
                const Vec3 q = places_b[b[j].in_group];
                const double way = at_rest[i * b.size() + j], apart = (q - p).norm();
                if (!(apart > now.stretch * way)) continue;
                now = {apart / way, time, apart, way, frame, {a[i].vertex, b[j].vertex}, {p, q}};
            }
        }
        if (now.stretch >= limit && first.frame == 0) first = now;
        if (now.stretch > most.stretch) most = now;
    }
    if (first.frame == 0) return;
    const std::size_t moves = groups[h].moves() ? h : g;
    const std::string name = scene.cloths[cloth].name;
    throw SceneError(
        "pin[" + std::to_string(moves) + (groups[moves].carrier ? "].collider" : "].path"),
        "asks for a stretch of " + number_text(first.stretch) + " at " + number_text(first.time) +
            " s (frame " + std::to_string(first.frame) + "): vertices " + std::to_string(first.vertices[0]) +
            " and " + std::to_string(first.vertices[1]) + " of cloth " + name + ", held by pin[" +
            std::to_string(g) + "] and pin[" + std::to_string(h) + "], are to be " +
            number_text(first.apart) + " m apart, at " + place_text(first.places[0]) + " and " +
            place_text(first.places[1]) + ", where at rest the way is " + number_text(first.at_rest) + " m" +
            (most.stretch > first.stretch
                 ? ", and asks for " + number_text(most.stretch) + " at " + number_text(most.time) + " s"
                 : "") +
            limit_text(cloth, part[loosest - limits.begin()], limit) +
            "; shorten the pins' ways, or set the limit to 0 to leave it out");
}

/// Refuses colliders that run into what a pin holds, or the other way round. Shapes alone whose distance is
/// exact, and no events: those are told of when they happen.
void require_free_pins(const Scene& scene, const std::vector<PinGroup>& groups, std::size_t g,
                       int first_vertex, double last) {
    const ClothDesc& cloth = scene.cloths[scene.pins[g].cloth];
    const double rate = scene.simulation.frame_rate, until = groups[g].until.value_or(last);
    const auto frames = static_cast<std::int64_t>(std::floor(last * rate + 1e-6));
    const std::vector<Held> held = some_of(groups, g, first_vertex);
    for (std::size_t k = 0; k < scene.colliders.size(); ++k) {
        const ColliderDesc& collider = scene.colliders[k];
        if (scene.pins[g].collider && static_cast<std::size_t>(*scene.pins[g].collider) == k) continue;
        const bool moves = !collider.path.empty() || !collider.spin.isZero(0.0);
        const bool switched = std::any_of(scene.events.begin(), scene.events.end(), [&](const EventDesc& e) {
            return e.collider && static_cast<std::size_t>(*e.collider) == k;
        });
        if (!collider.touchable || !collider.enabled || switched || (!groups[g].moves() && !moves)) continue;
        if (collider.shape == Shape::mesh || collider.shape == Shape::cylinder) continue;
        const auto shape = make_shape(collider);
        const double thickness =
            0.5 * cloth.contact_thickness.value_or(0.0) + shape->primitive().radius -
            (collider.shape == Shape::sphere || collider.shape == Shape::capsule ? collider.radius : 0.0);
        for (std::int64_t frame = 1; frame <= frames; ++frame) {
            const double time = static_cast<double>(frame) / rate;
            if (time > until) break;
            const Placement placement = placement_at(collider, time);
            const std::vector<Vec3> places = groups[g].places(time);
            for (const Held& pin : held) {
                const Vec3 p = places[pin.in_group];
                const double gap =
                    shape->distance(placement.rotation.transpose() * (p - placement.translation)).distance -
                    thickness;
                if (!(gap < -1e-6)) continue;
                throw SceneError(
                    !groups[g].moves()
                        ? "collider[" + std::to_string(k) + "]" + (collider.path.empty() ? ".spin" : ".path")
                        : "pin[" + std::to_string(g) + (groups[g].carrier ? "].collider" : "].path"),
                    "pin[" + std::to_string(g) + "] holds vertex " + std::to_string(pin.vertex) +
                        " of cloth " + cloth.name + " at " + place_text(p) + " at " + number_text(time) +
                        " s (frame " + std::to_string(frame) + "), " +
                        number_text(1e3 * std::round(-gap * 1e6) / 1e6) + " mm nearer to collider " +
                        collider.name + " than contact lets it be; nothing can get there");
            }
        }
    }
}

}  // namespace

void require_start_within_limits(const Scene& scene, const std::vector<MeshData>& rest) {
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
        ClothDesc cloth = scene.cloths[c];
        const std::vector<int> part = part_of_triangles(scene, c, rest[c]);
        const std::vector<double> limits = strain_limits(scene, c, part);
        const Points corners = rest_corners(cloth, rest[c]);
        const auto found_now = [&] {
            return most_stretched(corners, rest[c], start_positions(cloth, rest[c]), limits);
        };
        const auto within = [](const Stretched& s) { return s.stretch < s.limit * (1.0 - 1e-9); };
        const Stretched found = found_now();
        if (within(found)) continue;
        const double scale = std::exchange(cloth.transform.scale, 1.0);
        const bool by_scale = within(found_now());
        std::string advice = "; the start must be nearer the rest shape";
        if (by_scale && cloth.rest_grid()) {
            const Vec2 size = scale * cloth.grid.size;
            advice = "; a sheet that is as large at rest has size = [" + number_text(size.x()) + ", " +
                     number_text(size.y()) + "]";
        } else if (by_scale) {
            advice = "; scale is of the start pose, the rest shape keeps its size";
        } else if (cloth.rest == RestShape::uv) {
            advice = "; the mesh is as large as its texture coordinates with uv_scale = " +
                     number_text(natural_uv_scale(rest[c]));
        }
        throw SceneError(cloth_key(c, by_scale                      ? "scale"
                                      : cloth.rest == RestShape::uv ? "uv_scale"
                                      : cloth.pose                  ? "pose"
                                                                    : "bump"),
                         "cloth " + cloth.name + " starts stretched to " + number_text(found.stretch) +
                             " (triangle " + std::to_string(found.triangle) + " at " +
                             place_text(found.place) + ")" +
                             limit_text(c, part[static_cast<std::size_t>(found.triangle)], found.limit) +
                             advice + ", or set the limit to 0 to leave it out");
    }
}

void require_reachable_pins(const Scene& scene, const std::vector<MeshData>& rest, double last) {
    const std::vector<PinGroup> groups = make_pin_groups(scene, rest);
    for (std::size_t h = 0; h < groups.size(); ++h) {
        const int cloth = scene.pins[h].cloth;
        int first_vertex = 0;
        for (int c = 0; c < cloth; ++c) first_vertex += static_cast<int>(rest[c].positions.rows());
        if (scene.simulation.contact == ContactKind::barrier)
            require_free_pins(scene, groups, h, first_vertex, last);
        for (std::size_t g = 0; g < h; ++g) {
            if (scene.pins[g].cloth != cloth || (!groups[g].moves() && !groups[h].moves())) continue;
            require_reachable(scene, rest[cloth], groups, g, h, first_vertex, last);
        }
    }
}

}  // namespace cloth
