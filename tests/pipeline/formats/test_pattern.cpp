// Sewing patterns: panels filled with triangles, edges of every kind, stitches, and every refusal.

#include "pipeline/formats/pattern.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>

#include "pipeline/formats/obj.h"
#include "pipeline/formats/planar_mesh.h"
#include "pipeline/scene_file/scene_text.h"
#include "support/refusal.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
using nlohmann::json;

namespace {

double area_of(const std::vector<Vec2>& points, const std::array<int, 3>& t) {
    const auto at = [&](int k) { return points[static_cast<std::size_t>(t[static_cast<std::size_t>(k)])]; };
    const Vec2 a = at(1) - at(0), b = at(2) - at(0);
    return 0.5 * (a.x() * b.y() - a.y() * b.x());
}

/// Of all its triangles.
double area_of(const MeshData& mesh) {
    double area = 0.0;
    for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
        const Vec3 a = mesh.positions.row(mesh.triangles(t, 0)), b = mesh.positions.row(mesh.triangles(t, 1)),
                   c = mesh.positions.row(mesh.triangles(t, 2));
        area += 0.5 * (b - a).cross(c - a).norm();
    }
    return area;
}

/// A panel 20 cm wide and 30 cm high.
json rectangle(double width = 20.0) {
    return {{"translation", {0.0, 100.0, 10.0}},
            {"rotation", {0.0, 0.0, 0.0}},
            {"vertices", {{0, 0}, {width, 0}, {width, 30}, {0, 30}}},
            {"edges",
             {{{"endpoints", {0, 1}}},
              {{"endpoints", {1, 2}}},
              {{"endpoints", {2, 3}}},
              {{"endpoints", {3, 0}}}}}};
}

/// Two rectangles, front and back, sewn at the sides.
json shirt() {
    json file;
    file["pattern"]["panels"]["front"] = rectangle();
    file["pattern"]["panels"]["back"] = rectangle();
    file["pattern"]["panels"]["back"]["translation"] = {0.0, 100.0, -10.0};
    file["pattern"]["panels"]["back"]["label"] = "body";
    file["pattern"]["stitches"] = {{{{"panel", "front"}, {"edge", 1}}, {{"panel", "back"}, {"edge", 1}}},
                                   {{{"panel", "front"}, {"edge", 3}}, {{"panel", "back"}, {"edge", 3}}}};
    file["properties"] = {{"units_in_meter", 100}, {"curvature_coords", "relative"}};
    return file;
}

class Place {
  public:
    LoadedMesh read(const json& file, double edge_length = 0.02) const {
        spit(folder_ / "p.json", file.dump());
        return read_pattern(folder_ / "p.json", edge_length);
    }
    std::string told(const std::function<void(json&)>& spoil) const {
        json file = shirt();
        spoil(file);
        return refusal_of([&] { read(file); });
    }
    const TemporaryFolder& folder() const { return folder_; }

  private:
    TemporaryFolder folder_;
};

}  // namespace

TEST_CASE("a polygon is filled with triangles that are nearly equilateral and cover it once", "[pattern]") {
    const double h = 0.03;
    // An L, its edges cut into pieces of about h.
    const std::vector<Vec2> corners{{0, 0}, {0.6, 0}, {0.6, 0.3}, {0.3, 0.3}, {0.3, 0.9}, {0, 0.9}};
    for (const bool clockwise : {false, true}) {
        std::vector<Vec2> polygon;
        for (std::size_t i = 0; i < corners.size(); ++i) {
            const Vec2 a = corners[i], b = corners[(i + 1) % corners.size()];
            const auto parts = static_cast<int>(std::round((b - a).norm() / h));
            for (int k = 0; k < parts; ++k) polygon.push_back(a + (b - a) * k / parts);
        }
        if (clockwise) std::reverse(polygon.begin(), polygon.end());
        const PlanarMesh mesh = fill_polygon(polygon, h);
        double area = 0.0, least_angle = 180.0;
        for (const auto& t : mesh.triangles) {
            CHECK(area_of(mesh.points, t) > 0.0);
            area += area_of(mesh.points, t);
            for (std::size_t k = 0; k < 3; ++k) {
                const auto at = [&](std::size_t i) {
                    return mesh.points[static_cast<std::size_t>(t[i % 3])];
                };
                const Vec2 a = at(k + 1) - at(k), b = at(k + 2) - at(k);
                least_angle = std::min(
                    least_angle, std::acos(a.normalized().dot(b.normalized())) * 180.0 / std::numbers::pi);
            }
        }
        CHECK(area == Approx(0.36));
        CHECK(least_angle > 25.0);
        // As many as equilateral ones of that length would be, give or take.
        CHECK(static_cast<double>(mesh.triangles.size()) == Approx(0.36 / (0.433 * h * h)).epsilon(0.15));
        for (std::size_t i = 0; i < polygon.size(); ++i) CHECK(mesh.points[i] == polygon[i]);
    }
    CHECK(fill_polygon({{0, 0}, {1, 1}, {1, 0}, {0, 1}}, 0.1).triangles.empty());  // crosses itself
}

TEST_CASE("panels stand where the pattern has them, in metres, with their own coordinates and names",
          "[pattern]") {
    const Place place;
    json file = shirt();
    file["pattern"]["panels"]["back"]["rotation"] = {0.0, 90.0, 0.0};
    const LoadedMesh loaded = place.read(file);
    const MeshData& mesh = loaded.mesh;
    CHECK(mesh.pattern);
    CHECK(area_of(mesh) == Approx(2 * 0.06));
    REQUIRE(mesh.parts.size() == 3);
    CHECK(mesh.parts[0].name == "back");
    CHECK(mesh.parts[1].name == "body");
    CHECK(mesh.parts[2].name == "front");
    CHECK(mesh.parts[0].triangles == mesh.parts[1].triangles);
    for (const int t : mesh.parts[2].triangles) {
        for (int k = 0; k < 3; ++k) {
            const Vec3 p = mesh.positions.row(mesh.triangles(t, k));
            CHECK((p - Vec3(mesh.uv(3 * t + k, 0), mesh.uv(3 * t + k, 1) + 1.0, 0.1)).norm() < 1e-12);
        }
    }
    for (const int t : mesh.parts[0].triangles) {
        for (int k = 0; k < 3; ++k) {  // x goes to -z
            const Vec3 p = mesh.positions.row(mesh.triangles(t, k));
            CHECK((p - Vec3(0.0, mesh.uv(3 * t + k, 1) + 1.0, -mesh.uv(3 * t + k, 0) - 0.1)).norm() < 1e-12);
        }
    }
}

TEST_CASE("curved edges have the area and length that their curves have", "[pattern]") {
    const Place place;
    const auto area_with = [&](const json& curvature) {
        json file = shirt();
        file["pattern"].erase("stitches");
        file["pattern"]["panels"].erase("back");
        file["pattern"]["panels"]["front"]["edges"][0]["curvature"] = curvature;
        return area_of(place.read(file, 0.002).mesh);
    };
    // The lower edge runs from left to right: its right side is below, outside.
    const double half_disc = 0.5 * std::numbers::pi * 0.01;
    CHECK(area_with({{"type", "circle"}, {"params", {10.0, 0, 1}}}) ==
          Approx(0.06 + half_disc).epsilon(1e-3));
    CHECK(area_with({{"type", "circle"}, {"params", {10.0, 0, 0}}}) ==
          Approx(0.06 - half_disc).epsilon(1e-3));
    // Large and small arc of a radius of 12.5 cm over 20 cm: segments of 2·atan(10/7.5).
    const double angle = 2.0 * std::atan2(10.0, 7.5),
                 segment = 0.5 * 0.125 * 0.125 * (angle - std::sin(angle));
    CHECK(area_with({{"type", "circle"}, {"params", {12.5, 0, 1}}}) == Approx(0.06 + segment).epsilon(1e-3));
    CHECK(area_with({{"type", "circle"}, {"params", {12.5, 1, 1}}}) ==
          Approx(0.06 + std::numbers::pi * 0.125 * 0.125 - segment).epsilon(1e-3));
    // A parabola's segment is two thirds of its triangle; a cubic with both controls at one height h: 0.6 w
    // h.
    CHECK(area_with({{"type", "quadratic"}, {"params", {{0.5, -0.5}}}}) ==
          Approx(0.06 + 2.0 / 3.0 * 0.5 * 0.2 * 0.1).epsilon(1e-3));
    CHECK(area_with({0.5, -0.5}) == Approx(0.06 + 2.0 / 3.0 * 0.5 * 0.2 * 0.1).epsilon(1e-3));
    CHECK(area_with({{"type", "cubic"}, {"params", {{0.0, -0.25}, {1.0, -0.25}}}}) ==
          Approx(0.06 + 0.6 * 0.2 * 0.05).epsilon(1e-3));
}

TEST_CASE("stitches sew row to row, the nearer way round, and gather what is longer", "[pattern]") {
    const Place place;
    json file = shirt();
    // The back is seen from behind: its edge 1 is still at x = 20, but runs as it did.
    file["pattern"]["panels"]["back"]["vertices"] = {{0, 0}, {20, 0}, {20, 36}, {0, 36}};
    const LoadedMesh loaded = place.read(file);
    REQUIRE(loaded.mesh.stitches.size() == 2);
    for (const auto& [a, b] : loaded.mesh.stitches) {
        REQUIRE(a.size() == 19);  // 36 cm in pieces of 2 cm
        REQUIRE(b.size() == 19);
        for (std::size_t k = 0; k < a.size(); ++k) {
            CHECK(loaded.mesh.positions(a[k], 0) == Approx(loaded.mesh.positions(b[k], 0)).margin(1e-12));
            CHECK(1.2 * (loaded.mesh.positions(a[k], 1) - 1.0) ==
                  Approx(loaded.mesh.positions(b[k], 1) - 1.0).margin(1e-12));
        }
    }
    CHECK_THAT(loaded.notes.front(), Contains("sews 0.3 m to 0.36 m: gathered"));
    CHECK_THAT(loaded.notes.back(), Contains("2 panels with 2 seams"));
}

TEST_CASE("a pattern is a cloth: flat at rest, sewn, and kept as a mesh with seams", "[pattern]") {
    const Place place;
    spit(place.folder() / "shirt.json", shirt().dump());
    const std::string text = sheet("mesh = \"shirt.json\"\nedge_length = 0.05\n");
    const SceneFile file = parse_scene(text, "s.toml", place.folder().path());
    const ClothDesc& cloth = file.scene.cloths[0];
    CHECK(cloth.rest == RestShape::uv);
    CHECK(*cloth.uv_scale == 1.0);
    REQUIRE(file.scene.seams.size() == 2);
    CHECK(file.scene.seams[0].sides[0].vertices.size() == 7);
    // Written with the pattern it has the pattern's seams once; with a mesh in its place, as runs keep it,
    // too.
    CHECK(difference(file, parse_scene(file.resolved(), "again.toml", "/")).empty());
    spit(place.folder() / "kept.obj", obj_text(*cloth.mesh));
    const std::string kept = file.resolved({{"cloth[0].mesh", "kept.obj"}});
    CHECK(difference(file, parse_scene(kept, "kept.toml", place.folder().path())).empty());
    CHECK_THAT(
        refusal_of([&] { parse_scene(sheet("edge_length = 0.05\n"), "s.toml", place.folder().path()); }),
        Contains("edge_length: belongs to a sewing pattern"));
}

TEST_CASE("a pattern that cannot be sewn is refused by the way to what is wrong", "[pattern]") {
    const Place place;
    const auto front = [](json& f) -> json& { return f["pattern"]["panels"]["front"]; };
    CHECK_THAT(place.told([](json& f) { f.erase("pattern"); }), Contains("the file has no pattern"));
    CHECK_THAT(place.told([](json& f) { f["pattern"]["panels"] = json::object(); }),
               Contains("pattern.panels holds no panel"));
    CHECK_THAT(place.told([&](json& f) { front(f).erase("vertices"); }),
               Contains("pattern.panels.front has no vertices"));
    CHECK_THAT(place.told([&](json& f) { front(f)["vertices"][2] = {1}; }),
               Contains("pattern.panels.front.vertices[2] is no point of two numbers"));
    CHECK_THAT(place.told([&](json& f) {
        front(f)["edges"][1]["endpoints"] = {1, 9};
    }),
               Contains("edges[1].endpoints[1] names vertex 9; there are 4"));
    CHECK_THAT(place.told([&](json& f) {
        front(f)["edges"][1]["endpoints"] = {0, 2};
    }),
               Contains("begin elsewhere than the edge before ends"));
    CHECK_THAT(place.told([&](json& f) { front(f)["edges"].erase(3); }), Contains("are no closed loop"));
    CHECK_THAT(place.told([&](json& f) {
        front(f)["edges"][0]["curvature"] = {{"type", "spiral"}, {"params", {1}}};
    }),
               Contains("curvature.type is \"spiral\"; must be one of quadratic, cubic, circle"));
    CHECK_THAT(place.told([&](json& f) {
        front(f)["vertices"] = {{0, 0}, {20, 30}, {20, 0}, {0, 30}};
    }),
               Contains("panel \"front\" crosses itself"));
    CHECK_THAT(place.told([](json& f) { f["pattern"]["stitches"][0][1]["panel"] = "hood"; }),
               Contains("pattern.stitches[0][1].panel names panel \"hood\", which there is not"));
    CHECK_THAT(place.told([](json& f) { f["pattern"]["stitches"][0][1]["edge"] = 4; }),
               Contains("stitches[0][1].edge names edge 4; there are 4"));
    CHECK_THAT(place.told([](json& f) { f["pattern"]["stitches"][1] = f["pattern"]["stitches"][0]; }),
               Contains("stitches[1][0] is sewn twice"));
    CHECK_THAT(place.told([&](json& f) {
        front(f)["vertices"] = {{0, 0}, {20, 0}, {20, 1}, {0, 30}};
    }),
               Contains("sews 0.01 m to 0.3 m: edges that do not fit"));
    CHECK_THAT(place.told([](json& f) { f["properties"]["units_in_meter"] = 0; }),
               Contains("units_in_meter is not greater than 0"));
}
