#include "pipeline/formats/pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <numbers>
#include <set>
#include <string>
#include <vector>

#include "base/portable_math.h"
#include "base/text.h"
#include "pipeline/formats/json_file.h"
#include "pipeline/formats/planar_mesh.h"
#include "pipeline/formats/triangulate.h"
#include "sim/scene/mesh.h"

namespace cloth::pipeline {
namespace {

using nlohmann::json;

/// An edge of a panel as a fine line from its first to its last point [m].
struct Edge {
    std::array<std::size_t, 2> ends;  ///< panel vertices
    std::vector<Vec2> line;
    double length = 0.0;
    std::size_t segments = 0;
    std::vector<int> vertices;  ///< of the mesh, first to last
};

struct Panel {
    std::string name, label;
    std::vector<Vec2> corners;  ///< [m]
    std::vector<Edge> edges;
    Mat3 rotation = Mat3::Identity();
    Vec3 translation = Vec3::Zero();  ///< [m]

    Vec3 placed(const Vec2& p) const { return rotation * Vec3(p.x(), p.y(), 0.0) + translation; }
};

struct Stitch {
    std::array<std::size_t, 2> panel{}, edge{};
};

/// Reads values by the way to them, which messages tell.
class Node {
  public:
    Node(const json& value, std::string way, const FilePlace& place)
        : value_(&value), way_(std::move(way)), place_(&place) {}

    [[noreturn]] void fail(const std::string& message) const {
        place_->fail(fmt::format("{} {}", way_.empty() ? "the file" : way_, message));
    }
    bool has(const char* key) const { return value_->is_object() && value_->contains(key); }
    Node operator[](const char* key) const {
        if (!has(key)) fail(fmt::format("has no {}, as a pattern has it", key));
        return {(*value_)[key], way_.empty() ? key : way_ + "." + key, *place_};
    }
    Node at(std::size_t i) const {
        if (!value_->is_array() || i >= value_->size()) fail(fmt::format("has no entry {}", i));
        return {(*value_)[i], fmt::format("{}[{}]", way_, i), *place_};
    }
    std::size_t size() const {
        if (!value_->is_array()) fail("is no list");
        return value_->size();
    }
    bool is_list() const { return value_->is_array(); }
    double number() const {
        if (!value_->is_number() || !std::isfinite(value_->get<double>())) fail("is no number");
        return value_->get<double>();
    }
    std::size_t index(std::size_t count, const char* what) const {
        if (!value_->is_number_integer() || value_->get<std::int64_t>() < 0 ||
            value_->get<std::uint64_t>() >= count)
            fail(fmt::format("names {} {}; there are {}, counted from 0", what, value_->dump(), count));
        return value_->get<std::size_t>();
    }
    std::string text() const {
        if (!value_->is_string()) fail("is no text");
        return value_->get<std::string>();
    }
    Vec2 point() const {
        if (size() != 2) fail("is no point of two numbers");
        return {at(0).number(), at(1).number()};
    }
    Vec3 vector() const {
        if (size() != 3) fail("is no vector of three numbers");
        return {at(0).number(), at(1).number(), at(2).number()};
    }
    const json& value() const { return *value_; }

  private:
    const json* value_;
    std::string way_;
    const FilePlace* place_;
};

constexpr int fine = 256;  // points of a curved edge before it is cut into equal parts

/// Points of a Bézier curve, by de Casteljau.
std::vector<Vec2> bezier(const std::vector<Vec2>& controls) {
    std::vector<Vec2> line;
    for (int i = 0; i <= fine; ++i) {
        const double t = static_cast<double>(i) / fine;
        std::vector<Vec2> p = controls;
        for (std::size_t left = p.size() - 1; left > 0; --left)
            for (std::size_t k = 0; k < left; ++k) p[k] = (1.0 - t) * p[k] + t * p[k + 1];
        line.push_back(p[0]);
    }
    line.front() = controls.front();
    line.back() = controls.back();
    return line;
}

/// An arc from a to b of the radius: the large one or the small, on the right of the way or on its left, as
/// SVG has it.
std::vector<Vec2> arc(const Vec2& a, const Vec2& b, double radius, bool large, bool right) {
    const Vec2 way = b - a, left(-way.y(), way.x());
    const double chord = way.norm(), r = std::max(radius, 0.5 * chord);
    const double off = std::sqrt(std::max(0.0, r * r - 0.25 * chord * chord));
    // The arc bulges to one side; of a small one the centre lies on the other.
    const double side = right ? -1.0 : 1.0;
    const Vec2 centre = 0.5 * (a + b) + (large ? side : -side) * off / chord * left;
    const double half = std::atan2(0.5 * chord, off), angle = large ? std::numbers::pi - half : half;
    std::vector<Vec2> line;
    const Vec2 from = a - centre;
    for (int i = 0; i <= fine; ++i) {
        const double turn = -side * 2.0 * angle * i / fine * 180.0 / std::numbers::pi;
        const double c = cos_degrees(turn), s = sin_degrees(turn);
        line.push_back(centre + Vec2(c * from.x() - s * from.y(), s * from.x() + c * from.y()));
    }
    line.front() = a;
    line.back() = b;
    return line;
}

std::vector<Vec2> line_of(const Node& edge, const Vec2& a, const Vec2& b, bool relative, double metres) {
    if (!edge.has("curvature")) return {a, b};
    const Node curvature = edge["curvature"];
    const Vec2 way = b - a, left(-way.y(), way.x());
    const auto control = [&](const Node& point) {
        const Vec2 p = point.point();
        return relative ? Vec2(a + p.x() * way + p.y() * left) : Vec2(metres * p);
    };
    if (curvature.is_list()) return bezier({a, control(curvature), b});  // as older files have it
    const std::string type = curvature["type"].text();
    const Node params = curvature["params"];
    if (type == "quadratic") return bezier({a, control(params.at(0)), b});
    if (type == "cubic") return bezier({a, control(params.at(0)), control(params.at(1)), b});
    if (type == "circle")
        return arc(a, b, metres * params.at(0).number(), params.at(1).number() != 0.0,
                   params.at(2).number() != 0.0);
    curvature["type"].fail(fmt::format("is \"{}\"; must be one of quadratic, cubic, circle", type));
}

double length_of_line(const std::vector<Vec2>& line) {
    double length = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
    return length;
}

/// Points that cut a line into equal parts, without its last.
std::vector<Vec2> cut(const Edge& edge) {
    std::vector<Vec2> points{edge.line.front()};
    const double part = edge.length / static_cast<double>(edge.segments);
    double passed = 0.0;
    for (std::size_t i = 1; i < edge.line.size() && points.size() < edge.segments; ++i) {
        const double piece = (edge.line[i] - edge.line[i - 1]).norm();
        while (points.size() < edge.segments && passed + piece > part * static_cast<double>(points.size())) {
            const double share = (part * static_cast<double>(points.size()) - passed) / piece;
            points.push_back((1.0 - share) * edge.line[i - 1] + share * edge.line[i]);
        }
        passed += piece;
    }
    return points;
}

Panel read_panel(const std::string& name, const Node& node, bool relative, double metres) {
    Panel panel;
    panel.name = name;
    if (node.has("label") && node["label"].value().is_string()) panel.label = node["label"].text();
    panel.translation = metres * node["translation"].vector();
    panel.rotation = rotation_matrix(node["rotation"].vector());
    const Node vertices = node["vertices"], edges = node["edges"];
    for (std::size_t i = 0; i < vertices.size(); ++i)
        panel.corners.push_back(metres * vertices.at(i).point());
    if (edges.size() < 2) edges.fail("are fewer than two; a panel is a closed loop of edges");
    for (std::size_t i = 0; i < edges.size(); ++i) {
        const Node ends = edges.at(i)["endpoints"];
        Edge edge;
        for (std::size_t k = 0; k < 2; ++k) edge.ends[k] = ends.at(k).index(panel.corners.size(), "vertex");
        if (i > 0 && edge.ends[0] != panel.edges.back().ends[1])
            ends.fail("begin elsewhere than the edge before ends; the edges of a panel are one closed loop");
        edge.line =
            line_of(edges.at(i), panel.corners[edge.ends[0]], panel.corners[edge.ends[1]], relative, metres);
        edge.length = length_of_line(edge.line);
        if (!(edge.length > 0.0)) edges.at(i).fail("has no length");
        panel.edges.push_back(std::move(edge));
    }
    if (panel.edges.back().ends[1] != panel.edges.front().ends[0])
        edges.fail("are no closed loop: the last one ends elsewhere than the first begins");
    return panel;
}

std::vector<Stitch> read_stitches(const Node& pattern, const std::vector<Panel>& panels) {
    std::vector<Stitch> stitches;
    if (!pattern.has("stitches")) return stitches;
    const Node list = pattern["stitches"];
    std::set<std::array<std::size_t, 2>> sewn;
    for (std::size_t i = 0; i < list.size(); ++i) {
        Stitch stitch;
        for (std::size_t side = 0; side < 2; ++side) {
            const Node end = list.at(i).at(side);
            const std::string name = end["panel"].text();
            const auto panel =
                std::find_if(panels.begin(), panels.end(), [&](const Panel& p) { return p.name == name; });
            if (panel == panels.end())
                end["panel"].fail(fmt::format("names panel \"{}\", which there is not", name));
            stitch.panel[side] = static_cast<std::size_t>(panel - panels.begin());
            stitch.edge[side] = end["edge"].index(panel->edges.size(), "edge");
            if (!sewn.insert({stitch.panel[side], stitch.edge[side]}).second)
                end.fail("is sewn twice; an edge has one stitch");
        }
        stitches.push_back(stitch);
    }
    return stitches;
}

/// Fills a panel and adds it to the mesh.
void add_panel(Panel& panel, double edge_length, const FilePlace& place, MeshDraft& draft) {
    const auto first = static_cast<int>(draft.positions.size());
    std::vector<Vec2> polygon;
    for (Edge& edge : panel.edges) {
        for (const Vec2& p : cut(edge)) {
            edge.vertices.push_back(first + static_cast<int>(polygon.size()));
            polygon.push_back(p);
        }
    }
    for (std::size_t e = 0; e < panel.edges.size(); ++e)
        panel.edges[e].vertices.push_back(panel.edges[(e + 1) % panel.edges.size()].vertices.front());
    if (polygon.size() > most_corners)
        place.fail(
            fmt::format("panel \"{}\" has {} vertices on its rim, more than {}: give a larger edge_length",
                        panel.name, polygon.size(), most_corners));
    const PlanarMesh mesh = polygon.size() < 3 ? PlanarMesh{} : fill_polygon(polygon, edge_length);
    if (mesh.triangles.empty())
        place.fail(fmt::format("panel \"{}\" crosses itself or has no area", panel.name));
    for (const Vec2& p : mesh.points) {
        const Vec3 x = panel.placed(p);
        draft.positions.push_back({x.x(), x.y(), x.z()});
    }
    for (const auto& triangle : mesh.triangles) {
        for (const std::string& name : std::set<std::string>{panel.name, panel.label})
            if (!name.empty()) draft.parts[name].push_back(draft.face_count());
        std::array<std::int64_t, 3> corners{};
        for (std::size_t k = 0; k < 3; ++k) {
            corners[k] = first + triangle[k];
            const Vec2& p = mesh.points[static_cast<std::size_t>(triangle[k])];
            draft.uv.push_back({p.x(), p.y()});
        }
        draft.add_face(corners);
    }
}

}  // namespace

LoadedMesh read_pattern(const std::filesystem::path& path, double edge_length) {
    const FilePlace place{path};
    const json file = read_json_object(path);
    const Node root(file, "", place), pattern = root["pattern"], panel_nodes = pattern["panels"];
    double metres = 0.01;
    bool relative = true;
    if (root.has("properties")) {
        const Node properties = root["properties"];
        if (properties.has("units_in_meter")) {
            const double units = properties["units_in_meter"].number();
            if (!(units > 0.0)) properties["units_in_meter"].fail("is not greater than 0");
            metres = 1.0 / units;
        }
        if (properties.has("curvature_coords"))
            relative = properties["curvature_coords"].text() != "absolute";
    }
    if (!panel_nodes.value().is_object() || panel_nodes.value().empty()) panel_nodes.fail("holds no panel");
    std::vector<Panel> panels;
    for (const auto& [name, value] : panel_nodes.value().items())
        panels.push_back(read_panel(name, panel_nodes[name.c_str()], relative, metres));
    const std::vector<Stitch> stitches = read_stitches(pattern, panels);

    MeshDraft draft;
    const auto segments = [&](double length) {
        return static_cast<std::size_t>(std::max(1.0, std::round(length / edge_length)));
    };
    for (Panel& panel : panels)
        for (Edge& edge : panel.edges) edge.segments = segments(edge.length);
    for (std::size_t i = 0; i < stitches.size(); ++i) {
        Edge& a = panels[stitches[i].panel[0]].edges[stitches[i].edge[0]];
        Edge& b = panels[stitches[i].panel[1]].edges[stitches[i].edge[1]];
        const double longer = std::max(a.length, b.length), shorter = std::min(a.length, b.length);
        constexpr double most_gathered = 10.0, told = 1.05;
        if (longer > most_gathered * shorter)
            place.fail(fmt::format("pattern.stitches[{}] sews {:.3g} m to {:.3g} m: edges that do not fit", i,
                                   a.length, b.length));
        if (longer > told * shorter)
            draft.notes.push_back(
                fmt::format("stitch {} sews {:.3g} m to {:.3g} m: gathered", i, a.length, b.length));
        a.segments = b.segments = segments(longer);
    }
    for (Panel& panel : panels) add_panel(panel, edge_length, place, draft);

    std::vector<std::array<std::vector<int>, 2>> rows;
    for (const Stitch& stitch : stitches) {
        std::array<std::vector<int>, 2> row{panels[stitch.panel[0]].edges[stitch.edge[0]].vertices,
                                            panels[stitch.panel[1]].edges[stitch.edge[1]].vertices};
        // The way round that lets the ends be nearer.
        const auto apart = [&](int v, int w) {
            const auto &p = draft.positions[static_cast<std::size_t>(v)],
                       &q = draft.positions[static_cast<std::size_t>(w)];
            return (Vec3(p[0], p[1], p[2]) - Vec3(q[0], q[1], q[2])).norm();
        };
        if (apart(row[0].front(), row[1].back()) + apart(row[0].back(), row[1].front()) <
            apart(row[0].front(), row[1].front()) + apart(row[0].back(), row[1].back()))
            std::reverse(row[1].begin(), row[1].end());
        // The point of a dart is one vertex.
        for (std::size_t k = row[0].size(); k-- > 0;) {
            if (row[0][k] != row[1][k]) continue;
            row[0].erase(row[0].begin() + static_cast<std::ptrdiff_t>(k));
            row[1].erase(row[1].begin() + static_cast<std::ptrdiff_t>(k));
        }
        rows.push_back(std::move(row));
    }
    draft.notes.push_back(fmt::format("{} with {} and {}", plural(panels.size(), "panel"),
                                      plural(stitches.size(), "seam"),
                                      plural(draft.face_count(), "triangle")));
    LoadedMesh loaded = checked_mesh(std::move(draft), path, true);
    loaded.mesh.stitches = std::move(rows);
    loaded.mesh.pattern = true;
    return loaded;
}

}  // namespace cloth::pipeline
