// Grids, and every refusal of a mesh or a scene by its message.

#include <catch2/catch.hpp>
#include <functional>
#include <limits>

#include "base/portable_math.h"
#include "sim/model.h"
#include "sim/scene/mesh.h"
#include "sim/scene/scene.h"
#include "support/refusal.h"

using namespace cloth;
using Catch::Contains;

namespace {

MeshData triangle() {
    MeshData mesh;
    mesh.positions.resize(3, 3);
    mesh.positions << 0, 0, 0, 1, 0, 0, 0, 1, 0;
    mesh.triangles.resize(1, 3);
    mesh.triangles << 0, 1, 2;
    return mesh;
}

std::string mesh_refusal(const std::function<void(MeshData&)>& spoil) {
    MeshData mesh = triangle();
    spoil(mesh);
    return refusal([&] { check_cloth_mesh(mesh, "cloth[0].mesh"); });
}

Scene good_scene() {
    Scene scene;
    scene.cloths.emplace_back();
    scene.colliders.emplace_back();
    PinDesc pin;
    pin.vertices = {0};
    scene.pins.push_back(pin);
    DragDesc drag;
    drag.path = {{0.0, {0, 0}}, {1.0, {1, 1}}};
    scene.drags.push_back(drag);
    scene.events.push_back({.time = 0.5, .collider = 0});
    return scene;
}

}  // namespace

TEST_CASE("a grid has the asked size, count, orientation and area", "[mesh]") {
    for (Diagonals diagonals : {Diagonals::uniform, Diagonals::alternating}) {
        const MeshData mesh = make_grid({.size = {2.0, 1.0}, .resolution = {5, 4}, .diagonals = diagonals});
        REQUIRE(mesh.positions.rows() == 20);
        REQUIRE(mesh.triangles.rows() == 24);
        CHECK_NOTHROW(check_cloth_mesh(mesh, "m"));
        CHECK(mesh.positions.row(0) == Eigen::RowVector3d(-1.0, -0.5, 0.0));
        CHECK(mesh.positions.row(19) == Eigen::RowVector3d(1.0, 0.5, 0.0));
        double area = 0.0;
        for (int t = 0; t < 24; ++t) {
            const Vec3 a = mesh.positions.row(mesh.triangles(t, 0)),
                       b = mesh.positions.row(mesh.triangles(t, 1)),
                       c = mesh.positions.row(mesh.triangles(t, 2));
            const double z = (b - a).cross(c - a).z();
            CHECK(z > 0.0);
            area += 0.5 * z;
        }
        CHECK(area == Approx(2.0).epsilon(1e-14));
    }
    // The assignment's sheet: 400 vertices, 722 triangles.
    const MeshData seed = make_grid({.diagonals = Diagonals::uniform});
    CHECK(seed.positions.rows() == 400);
    CHECK(seed.triangles.rows() == 722);
}

TEST_CASE("a mesh that is no cloth is refused with the reason", "[mesh]") {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    CHECK(mesh_refusal([](MeshData&) {}) == "accepted");
    CHECK_THAT(mesh_refusal([](MeshData& m) { m.triangles.resize(0, 3); }), Contains("no triangle"));
    CHECK_THAT(mesh_refusal([&](MeshData& m) { m.positions(1, 2) = nan; }),
               Contains("vertex 1") && Contains("finite"));
    CHECK_THAT(mesh_refusal([](MeshData& m) { m.triangles(0, 2) = 3; }), Contains("outside 0 … 2"));
    CHECK_THAT(mesh_refusal([](MeshData& m) { m.triangles(0, 2) = -1; }), Contains("outside 0 … 2"));
    CHECK_THAT(mesh_refusal([](MeshData& m) { m.triangles(0, 2) = 1; }), Contains("repeated corner"));
    CHECK_THAT(mesh_refusal([](MeshData& m) { m.positions.row(2) << 2, 0, 0; }), Contains("degenerate"));
    CHECK_THAT(mesh_refusal([](MeshData& m) {
                   m.triangles.resize(2, 3);
                   m.triangles << 0, 1, 2, 1, 2, 0;
               }),
               Contains("triangle 1") && Contains("repeats triangle 0"));
    CHECK_THAT(mesh_refusal([](MeshData& m) {
                   m.positions.resize(5, 3);
                   m.positions << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1, 0, 0, 0, 1;
                   m.triangles.resize(3, 3);
                   m.triangles << 0, 1, 2, 1, 0, 3, 0, 1, 4;
               }),
               Contains("vertices 0 and 1") && Contains("more than two triangles"));
    CHECK_THAT(mesh_refusal([](MeshData& m) {
                   m.positions.conservativeResize(4, 3);
                   m.positions.row(3) << 5, 5, 5;
               }),
               Contains("vertex 3") && Contains("no triangle"));
    CHECK_THAT(mesh_refusal([](MeshData& m) {
                   m.positions.conservativeResize(4, 3);
                   m.positions.row(3) << 1, 1, 0;
                   m.triangles.resize(2, 3);
                   m.triangles << 0, 1, 2, 1, 2, 3;
               }),
               Contains("vertices 1 and 2") && Contains("face opposite ways"));
}

TEST_CASE("a scene that makes no sense is refused with key, value, range and unit", "[scene]") {
    CHECK(refusal([] { validate(good_scene()); }) == "accepted");
    const double nan = std::numeric_limits<double>::quiet_NaN(),
                 inf = std::numeric_limits<double>::infinity();
    const Spoiled cases[] = {
        {"cloth", "no [[cloth]]", [](Scene& s) { s.cloths.clear(); }},
        {"simulation.gravity", "finite", [&](Scene& s) { s.simulation.gravity.x() = inf; }},
        {"simulation.frame_rate", "is 0; must be 0.001 … 1000000 1/s",
         [](Scene& s) { s.simulation.frame_rate = 0; }},
        {"simulation.frame_rate", "must be 0.001 … 1000000 1/s",
         [](Scene& s) { s.simulation.frame_rate = 1e7; }},
        {"simulation.time_step", "is -0.1; must be 1e-9 … 1000 s",
         [](Scene& s) { s.simulation.time_step = -0.1; }},
        {"simulation.time_step", "million steps", [](Scene& s) { s.simulation.time_step = 1e-9; }},
        {"simulation.time_step", "give one of the two",
         [](Scene& s) {
             s.simulation.time_step = 0.1;
             s.simulation.substeps = 2;
         }},
        {"simulation.substeps", "is 0; must be 1", [](Scene& s) { s.simulation.substeps = 0; }},
        {"simulation.newton_iterations", "is 0; must be 1 … 1000000",
         [](Scene& s) { s.simulation.newton_iterations = 0; }},
        {"simulation.newton_tolerance", "between 0 and 1",
         [](Scene& s) { s.simulation.newton_tolerance = 1.0; }},
        {"simulation.newton_speed", "must be 0 … 10000 m/s",
         [](Scene& s) { s.simulation.newton_speed = -1.0; }},
        {"cloth[0].size", "is -1; must be 1e-6 … 1000000 m",
         [](Scene& s) { s.cloths[0].grid.size.y() = -1; }},
        {"cloth[0].resolution", "is 1; must be 2 … 4096",
         [](Scene& s) { s.cloths[0].grid.resolution[1] = 1; }},
        {"cloth[0].pose", "has 1 vertices; the rest shape has 400",
         [](Scene& s) { s.cloths[0].pose = Points::Zero(1, 3); }},
        {"cloth[0].pose", "not finite", [&](Scene& s) { s.cloths[0].pose = Points::Constant(400, 3, nan); }},
        {"cloth[0].scale", "is 0; must be 1e-6 … 1000000", [](Scene& s) { s.cloths[0].transform.scale = 0; }},
        {"cloth[0].rotate", "finite", [&](Scene& s) { s.cloths[0].transform.rotate.x() = nan; }},
        {"cloth[0].translate", "finite", [&](Scene& s) { s.cloths[0].transform.translate.x() = nan; }},
        {"cloth[0].velocity", "finite", [&](Scene& s) { s.cloths[0].velocity.x() = inf; }},
        {"cloth[0].bump", "finite", [&](Scene& s) { s.cloths[0].bump = inf; }},
        {"cloth[0].fabric.density", "is 0; must be 1e-6 … 1000000 kg/m²",
         [](Scene& s) { s.cloths[0].fabric.density = 0; }},
        {"cloth[0].fabric.thickness", "is -1; must be 1e-9 … 1000 m",
         [](Scene& s) { s.cloths[0].fabric.thickness = -1; }},
        {"cloth[0].fabric.young_modulus", "is nan, not finite; must be 1e-6 … 1e15 Pa",
         [&](Scene& s) { s.cloths[0].fabric.young_modulus = nan; }},
        {"cloth[0].fabric.poisson_ratio", "is 1; must lie between -1 and 1",
         [](Scene& s) { s.cloths[0].fabric.poisson_ratio = 1; }},
        {"cloth[0].fabric.mu", "together", [](Scene& s) { s.cloths[0].fabric.mu = 1.0; }},
        {"cloth[0].fabric.lambda", "together", [](Scene& s) { s.cloths[0].fabric.lambda = 1.0; }},
        {"cloth[0].fabric.mu", "is -1; must be 1e-6 … 1e15 Pa",
         [](Scene& s) {
             s.cloths[0].fabric.mu = -1.0;
             s.cloths[0].fabric.lambda = 1.0;
         }},
        {"cloth[0].fabric.lambda", "mu + lambda",
         [](Scene& s) {
             s.cloths[0].fabric.mu = 1.0;
             s.cloths[0].fabric.lambda = -2.0;
         }},
        {"collider[0].center", "finite", [&](Scene& s) { s.colliders[0].center.x() = nan; }},
        {"collider[0].normal", "is zero",
         [](Scene& s) {
             s.colliders[0].shape = Shape::plane;
             s.colliders[0].normal.setZero();
         }},
        {"collider[0].radius", "is 0; must be 1e-6 … 1000000 m", [](Scene& s) { s.colliders[0].radius = 0; }},
        {"collider[0].contact_offset", "is -1; must be 0 … 1000000 m",
         [](Scene& s) { s.colliders[0].contact_offset = -1; }},
        {"collider[0].contact_radius", "is 0; must be 1e-6 … 1000000 m",
         [](Scene& s) { s.colliders[0].contact_radius = 0; }},
        {"collider[0].contact_radius", "give one of the two",
         [](Scene& s) {
             s.colliders[0].contact_radius = 0.2;
             s.colliders[0].contact_offset = 0.1;
         }},
        {"collider[0].rotate", "give its normal",
         [](Scene& s) {
             s.colliders[0].shape = Shape::plane;
             s.colliders[0].rotate = {90.0, 0.0, 0.0};
         }},
        {"collider[0].contact_radius", "belongs to a sphere",
         [](Scene& s) {
             s.colliders[0].shape = Shape::plane;
             s.colliders[0].contact_radius = 0.2;
         }},
        {"collider[0].friction", "is -0.1; must be 0 … 1000",
         [](Scene& s) { s.colliders[0].friction = -0.1; }},
        {"pin[0].cloth", "no such cloth", [](Scene& s) { s.pins[0].cloth = 3; }},
        {"pin[0]", "exactly one of", [](Scene& s) { s.pins[0].greatest = "y"; }},
        {"pin[0]", "exactly one of", [](Scene& s) { s.pins[0].vertices.clear(); }},
        {"pin[0].box", "lower corner above",
         [](Scene& s) {
             s.pins[0].vertices.clear();
             s.pins[0].box = {Vec3(0, 1, 0), Vec3(1, 0, 1)};
         }},
        {"pin[0].greatest", "must be one of x, y, z",
         [](Scene& s) {
             s.pins[0].vertices.clear();
             s.pins[0].greatest = "up";
         }},
        {"pin[0].tolerance", "is -1; must be 0 … 1000000 m", [](Scene& s) { s.pins[0].tolerance = -1; }},
        {"drag[0].path", "at least two keys", [](Scene& s) { s.drags[0].path.resize(1); }},
        {"drag[0].path", "do not increase", [](Scene& s) { s.drags[0].path[1].time = 0.0; }},
        {"drag[0].path", "finite", [&](Scene& s) { s.drags[0].path[1].pixel.x() = nan; }},
        {"drag[0].path", "at least 0 s", [](Scene& s) { s.drags[0].path[0].time = -1.0; }},
        {"drag[0].radius", "is -1; must be 0 … 1000000 m", [](Scene& s) { s.drags[0].radius = -1; }},
        {"drag[0].stiffness", "is 0; must be 1e-9 … 1e15 N/m", [](Scene& s) { s.drags[0].stiffness = 0; }},
        {"drag[0].viewport", "is 0; must be 1 … 1000000 pixel",
         [](Scene& s) { s.drags[0].viewport.x() = 0; }},
        {"event[0].time", "is -1; must be 0 … 1e9 s", [](Scene& s) { s.events[0].time = -1; }},
        {"event[0].collider", "no such collider", [](Scene& s) { s.events[0].collider = 1; }},
        {"event[0]", "either a collider or an integrator",
         [](Scene& s) { s.events[0].toggle_integrator = true; }},
    };
    for (const Spoiled& c : cases) {
        Scene scene = good_scene();
        c.spoil(scene);
        std::string key;
        CAPTURE(c.key, c.message);
        CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains(c.message));
        CHECK(key == c.key);
    }
}

TEST_CASE("a disc has rings of six more vertices each and fills its polygon", "[mesh]") {
    for (int rings : {1, 2, 7}) {
        const MeshData mesh = make_disc({.radius = 0.3, .rings = rings});
        CHECK(mesh.positions.rows() == 1 + 3 * rings * (rings + 1));
        CHECK(mesh.triangles.rows() == 6 * rings * rings);
        CHECK_NOTHROW(check_cloth_mesh(mesh, "cloth[0]"));
        double area = 0.0;
        for (int t = 0; t < mesh.triangles.rows(); ++t) {
            const Vec3 a = mesh.positions.row(mesh.triangles(t, 0)),
                       b = mesh.positions.row(mesh.triangles(t, 1)),
                       c = mesh.positions.row(mesh.triangles(t, 2));
            const double z = (b - a).cross(c - a).z();
            CHECK(z > 0.0);
            area += 0.5 * z;
        }
        // The rim is a polygon of 6 rings corners.
        CHECK(area == Approx(3.0 * rings * 0.09 * sin_degrees(60.0 / rings)));
    }
}

TEST_CASE("pins select by index, box, nearest point and extreme", "[scene]") {
    Points p(4, 3);
    p << 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1.0005, 0;
    PinDesc pin;
    pin.vertices = {2, 0};
    CHECK(select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]") == std::vector<int>{2, 0});
    pin.vertices = {4};
    CHECK_THAT(refusal([&] { select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]"); }),
               Contains("vertex 4 does not exist") && Contains("0 … 3"));
    pin = {};
    pin.box = {Vec3(0.5, -1, -1), Vec3(2, 0.5, 1)};
    CHECK(select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]") == std::vector<int>{1});
    pin.box = {Vec3(5, 5, 5), Vec3(6, 6, 6)};
    CHECK_THAT(refusal([&] { select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]"); }),
               Contains("selects no vertex"));
    pin = {};
    pin.nearest = Vec3(0.9, 0.8, 0.3);
    CHECK(select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]") == std::vector<int>{2});
    pin = {};
    pin.greatest = "y";
    CHECK(select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]") == std::vector<int>{2, 3});
    pin.greatest = "-x";
    CHECK(select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]") == std::vector<int>{0, 3});
}

TEST_CASE("steps per frame follow from time step or substeps", "[scene]") {
    SimulationDesc s;
    CHECK(s.steps_per_frame() == 1);
    s.time_step = 1.0 / 60.0;
    CHECK(s.steps_per_frame() == 1);
    s.time_step = 0.004166667;
    CHECK(s.steps_per_frame() == 4);
    s.time_step = 0.004;
    CHECK(s.steps_per_frame() == 5);
    s.frame_rate = 1000.0;
    s.time_step = 0.001;
    CHECK(s.step_size() == 0.001);
    s.time_step.reset();
    s.substeps = 3;
    CHECK(s.steps_per_frame() == 3);
}
