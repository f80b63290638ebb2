// Rest shapes of each triangle's own: texture coordinates, parts of other fabrics, seams that do not match.

#include "sim/scene/rest_shape.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <numbers>

#include "sim/energies/energy.h"
#include "sim/model.h"
#include "sim/scene/mesh.h"
#include "sim/scene/mesh_repair.h"
#include "support/energy_battery.h"
#include "support/refusal.h"

using namespace cloth;
using namespace cloth::testing;
using Catch::Contains;

namespace {

/// A grid whose texture coordinates are its own places, `per_metre` to a metre.
MeshData unwrapped(const Grid& grid, double per_metre = 1.0) {
    MeshData mesh = make_grid(grid);
    mesh.uv.resize(3 * mesh.triangles.rows(), 2);
    for (Eigen::Index i = 0; i < mesh.uv.rows(); ++i)
        mesh.uv.row(i) =
            per_metre * mesh.positions.row(mesh.triangles(i / 3, static_cast<int>(i % 3))).head<2>();
    return mesh;
}

/// A tube about the y axis, whose cloth was a rectangle: closed by joining its first and last columns, so
/// that texture coordinates jump there.
MeshData tube(int around, int along, double radius, double length) {
    const MeshData flat = make_grid({.size = {1.0, length}, .resolution = {around + 1, along}});
    MeshData mesh;
    mesh.positions.resize(around * along, 3);
    const auto joined = [&](int v) { return v / (around + 1) * around + v % (around + 1) % around; };
    for (int v = 0; v < flat.positions.rows(); ++v) {
        const double angle = 2.0 * std::numbers::pi * (v % (around + 1)) / around;
        mesh.positions.row(joined(v)) << radius * std::cos(angle), flat.positions(v, 1),
            -radius * std::sin(angle);
    }
    mesh.triangles.resize(flat.triangles.rows(), 3);
    mesh.uv.resize(3 * flat.triangles.rows(), 2);
    const double chord = 2.0 * radius * std::sin(std::numbers::pi / around);
    for (Eigen::Index i = 0; i < mesh.uv.rows(); ++i) {
        const int v = flat.triangles(i / 3, static_cast<int>(i % 3));
        mesh.triangles(i / 3, static_cast<int>(i % 3)) = joined(v);
        mesh.uv.row(i) << chord * (v % (around + 1)), flat.positions(v, 1);
    }
    return mesh;
}

Scene scene_of(const MeshData& mesh) {
    Scene scene;
    scene.simulation.gravity.setZero();
    scene.cloths.emplace_back();
    scene.cloths[0].mesh = mesh;
    scene.cloths[0].rest = RestShape::uv;
    return scene;
}

double value_of(const Model& model, std::string_view name, const VecX& x) {
    double sum = 0.0;
    for (const auto& energy : model.energies)
        if (energy->name() == name) sum += energy->value(x);
    return sum;
}

std::string uv_refusal(const std::function<void(MeshData&)>& spoil) {
    MeshData mesh = unwrapped({.resolution = {3, 3}});
    spoil(mesh);
    return refusal([&] { check_uv(mesh, "cloth[0].rest"); });
}

}  // namespace

TEST_CASE("texture coordinates that are a mesh's own places give its own rest shape, to the bit", "[rest]") {
    const MeshData mesh = unwrapped({.size = {0.7, 0.4}, .resolution = {6, 5}});
    ClothDesc cloth;
    cloth.mesh = mesh;
    const Points as_mesh = rest_corners(cloth, mesh);
    cloth.rest = RestShape::uv;
    cloth.uv_scale = 1.0;
    CHECK(rest_corners(cloth, mesh) == as_mesh);
}

TEST_CASE("uv_scale is found from the mesh's area, and a wrong one is a stretch", "[rest]") {
    const MeshData mesh = unwrapped({.size = {0.7, 0.4}, .resolution = {6, 5}}, 4.0);
    CHECK(natural_uv_scale(mesh) == Approx(0.25));
    Scene scene = scene_of(mesh);
    const Model model = build_model(scene);
    CHECK(*model.scene.cloths[0].uv_scale == Approx(0.25));
    CHECK(model.triangle_areas.sum() == Approx(0.28));
    scene.cloths[0].uv_scale = 0.2;
    std::string key;
    const std::string told = refusal([&] { build_model(scene); }, &key);
    CHECK(key == "cloth[0].uv_scale");
    CHECK_THAT(told, Contains("starts stretched to 1.25") && Contains("with uv_scale = 0.25"));
}

TEST_CASE("a tube of a flat pattern is bent as a plate is, across its seam too", "[rest]") {
    const double radius = 0.1, length = 0.3;
    Scene scene = scene_of(tube(48, 10, radius, length));
    scene.cloths[0].uv_scale = 1.0;
    scene.cloths[0].fabric = {.bending = 2e-5};
    const Model model = build_model(scene);
    const VecX x = start_state(model).positions;
    // It is as long around as its pattern: nothing is stretched, at the seam neither.
    CHECK(value_of(model, "membrane", x) < 1e-20);
    const double area = model.triangle_areas.sum();
    CHECK(area == Approx(2.0 * std::numbers::pi * radius * length).epsilon(2e-3));
    // The rim's rows bend no differently: a cylinder's curvature is the same everywhere.
    CHECK(value_of(model, "bending", x) == Approx(0.5 * 2e-5 * area / (radius * radius)).epsilon(5e-3));
    // At rest as the tube stands there would be no energy in its hinges.
    scene.cloths[0].rest = RestShape::mesh;
    scene.cloths[0].uv_scale.reset();
    scene.cloths[0].fabric.bending_model = BendingKind::hinges;
    const Model curved = build_model(scene);
    State state = start_state(curved);
    for (auto& energy : make_stage_energies(curved)) {
        energy->begin({{{1.0, state.positions}}, 1.0, 0.0, state});
        CHECK(energy->value(state.positions) < 1e-20);
    }
}

TEST_CASE("energies across a seam whose sides do not match pass the battery", "[rest][energy]") {
    // The right half's map is mirrored, away from the left one, and shrunk along the seam or not.
    for (const double shrunk : {1.0, 0.8}) {
        MeshData mesh = unwrapped({.size = {0.2, 0.2}, .resolution = {3, 3}});
        for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
            double middle = 0.0;
            for (int k = 0; k < 3; ++k) middle += mesh.positions(mesh.triangles(t, k), 0) / 3.0;
            if (middle < 0.0) continue;
            for (Eigen::Index i = 3 * t; i < 3 * t + 3; ++i)
                mesh.uv.row(i) << 5.0 - mesh.uv(i, 0), shrunk * mesh.uv(i, 1);
        }
        Scene scene = scene_of(mesh);
        scene.cloths[0].uv_scale = 1.0;
        scene.cloths[0].fabric = {.bending = 1e-4};
        const Model model = build_model(scene);
        const VecX x = start_state(model).positions;
        VecX bent = x;
        for (int i = 0; i < 9; ++i)
            bent.segment<3>(3 * i) += 0.02 * Vec3(std::sin(3.0 * i), std::cos(i), std::sin(i));
        for (const auto& energy : model.energies) {
            if (energy->name() == "bending")
                check_energy(*energy, 9, {x, bent},
                             {.length = 0.02, .force_scale = 1e-3, .stiffness_scale = 1e-1});
        }
        CHECK(value_of(model, "bending", bent) > 1e-7);
        if (shrunk == 1.0) {
            CHECK(value_of(model, "bending", x) < 1e-20);  // the seam rests flat
            CHECK(value_of(model, "membrane", x) < 1e-20);
        } else {
            CHECK(value_of(model, "membrane", x) > 1e-4);  // stretched along the seam
        }
    }
}

TEST_CASE("texture coordinates that are no rest shape are refused by triangle", "[rest]") {
    CHECK(uv_refusal([](MeshData&) {}) == "accepted");
    CHECK_THAT(uv_refusal([](MeshData& m) { m.uv.resize(0, 2); }), Contains("has no texture coordinates"));
    CHECK_THAT(uv_refusal([](MeshData& m) { m.uv(7, 1) = std::nan(""); }),
               Contains("triangle 2 (counted from 0) has no texture coordinates"));
    CHECK_THAT(uv_refusal([](MeshData& m) { m.uv.row(4) = m.uv.row(3); }),
               Contains("triangle 1 (counted from 0) has no area there"));
    CHECK_THAT(uv_refusal([](MeshData& m) {
                   // Triangle 1 is b d c beside 0, a b c: d goes to the other side of b c.
                   m.uv.row(4) = m.uv.row(0) + 0.1 * (m.uv.row(1) - m.uv.row(0));
               }),
               Contains("triangle 1 (counted from 0) lies folded over triangle 0"));
    // A mirrored island is none of these.
    CHECK(uv_refusal([](MeshData& m) { m.uv.col(0) *= -1.0; }) == "accepted");
}

TEST_CASE("a part has its own fabric, and is pinned by its name", "[rest]") {
    MeshData mesh = make_grid({.size = {1.0, 1.0}, .resolution = {5, 5}});
    MeshPart hem{"hem", {}};
    for (int t = 0; t < 8; ++t) hem.triangles.push_back(t);  // the lowest row
    mesh.parts = {hem};
    Scene scene;
    scene.cloths.emplace_back();
    scene.cloths[0].mesh = mesh;
    scene.cloths[0].fabric = {.density = 0.1};
    scene.parts.push_back({.cloth = 0, .name = "hem", .fabric = {.density = 0.9}});
    PinDesc pin;
    pin.part = "hem";
    scene.pins.push_back(pin);
    const Model model = build_model(scene);
    CHECK(model.vertex_mass.sum() == Approx(0.75 * 0.1 + 0.25 * 0.9));
    CHECK(model.fabric(7).density == 0.9);
    CHECK(model.fabric(8).density == 0.1);
    CHECK(model.pinned == std::vector<int>{0, 1, 2, 3, 4, 5, 6, 7, 8, 9});

    std::string key;
    scene.parts[0].name = "collar";
    CHECK_THAT(refusal([&] { build_model(scene); }, &key),
               Contains("has no part \"collar\"; its parts: hem"));
    CHECK(key == "part[0].name");
    scene.parts.clear();
    scene.pins[0].part = "cuff";
    CHECK_THAT(refusal([&] { build_model(scene); }, &key), Contains("has no part \"cuff\"; its parts: hem"));
    CHECK(key == "pin[0].part");
    scene.cloths[0].mesh->parts.clear();
    CHECK_THAT(refusal([&] { build_model(scene); }), Contains("its mesh names none"));
}

TEST_CASE("a bad part or rest shape is refused by its key", "[rest]") {
    std::string key;
    Scene scene;
    scene.cloths.emplace_back();
    scene.parts.push_back({.cloth = 1, .name = "x"});
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("there is no such cloth"));
    CHECK(key == "part[0].cloth");
    scene.parts[0] = {.cloth = 0, .name = "x"};
    scene.parts[0].fabric.density = -1.0;
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("is -1"));
    CHECK(key == "part[0].fabric.density");
    scene.parts.clear();
    scene.cloths[0].rest = RestShape::uv;
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("belongs to a mesh"));
    CHECK(key == "cloth[0].rest");
    scene.cloths[0].rest = RestShape::mesh;
    scene.cloths[0].uv_scale = 1.0;
    CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains("belongs to rest = \"uv\""));
    CHECK(key == "cloth[0].uv_scale");
}

TEST_CASE("mending a mesh takes texture coordinates, parts and seams along", "[rest][repair]") {
    MeshData mesh;
    mesh.positions.resize(7, 3);
    mesh.positions << 9, 9, 9, 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1,
        0;  // 4 is 2, 6 is 3; 0 loose
    mesh.triangles.resize(3, 3);
    mesh.triangles << 1, 2, 3, 2, 4, 3, 4, 6, 5;  // the second collapses, the third is turned
    mesh.uv.resize(9, 2);
    for (int i = 0; i < 9; ++i) mesh.uv.row(i) << i, 10 * i;
    mesh.parts = {{"all", {0, 1, 2}}, {"gone", {1}}};
    mesh.pattern = true;
    mesh.stitches = {{{{0, 2, 1}, {1, 4, 5}}}};
    const MeshRepair repair = repair_cloth_mesh(mesh, nullptr, true);
    REQUIRE(repair.mesh.triangles.rows() == 2);
    REQUIRE(repair.turned == 1);
    CHECK(repair.mesh.triangles.row(1) == Eigen::RowVector3i(1, 3, 2));
    CHECK(repair.mesh.uv.col(0).transpose() == (Eigen::RowVectorXd(6) << 0, 1, 2, 6, 8, 7).finished());
    REQUIRE(repair.mesh.parts.size() == 1);
    CHECK(repair.mesh.parts[0].triangles == std::vector<int>{0, 1});
    CHECK(repair.mesh.pattern);
    CHECK(repair.mesh.stitches[0][0] == std::vector<int>{0});
    CHECK(repair.mesh.stitches[0][1] == std::vector<int>{3});
}
