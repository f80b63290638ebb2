// Scene files: what they fill, every refusal with its place, overrides, and the resolved text.

#include <stdlib.h>

#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>
#include <string>
#include <vector>

#include "pipeline/formats/error.h"
#include "pipeline/formats/mesh_file.h"
#include "pipeline/picture/frame_builder.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/image/image.h"
#include "sim/model.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "support/temporary_folder.h"

using namespace cloth;
using namespace cloth::pipeline;
using Catch::Matchers::Contains;
namespace fs = std::filesystem;

namespace {

SceneFile parse(const std::string& text, const Overrides& overrides = {}) {
    return parse_scene(text, "s.toml", fs::temp_directory_path(), overrides);
}

/// A sheet and `more`, under the version line: `more` begins at line 3.
std::string sheet(const std::string& more = "") {
    return "version = 1\n[[cloth]]\n" + more;
}

template <class Action>
std::string refusal_of(const Action& action) {
    try {
        action();
    } catch (const Error& e) {
        CHECK(e.code == ExitCode::invalid_scene);
        CHECK(std::string(e.what()).find('\n') == std::string::npos);
        return e.what();
    }
    return "";
}

std::string refusal(const std::string& text, const Overrides& overrides = {}) {
    return refusal_of([&] { parse(text, overrides); });
}

bool same(double a, double b) {
    return std::memcmp(&a, &b, sizeof a) == 0;
}
template <class Matrix>
bool same_matrix(const Matrix& a, const Matrix& b) {
    return a.rows() == b.rows() && a.cols() == b.cols() &&
           std::memcmp(a.data(), b.data(), static_cast<std::size_t>(a.size()) * sizeof(*a.data())) == 0;
}
bool same_material(const render::Material& a, const render::Material& b) {
    return a.front == b.front && a.back == b.back && a.roughness == b.roughness && a.specular == b.specular &&
           a.sheen == b.sheen && a.pattern == b.pattern && a.pattern_scale == b.pattern_scale &&
           a.pattern_colors == b.pattern_colors && a.pattern_on_back == b.pattern_on_back &&
           a.weave == b.weave && a.weave_depth == b.weave_depth &&
           (a.image == nullptr) == (b.image == nullptr);
}

void check_same_selection(const VertexSelection& p, const VertexSelection& q) {
    CHECK(p.vertices == q.vertices);
    CHECK(p.box == q.box);
    CHECK(p.nearest == q.nearest);
    CHECK(p.greatest == q.greatest);
    CHECK(p.edge == q.edge);
    CHECK(same(p.tolerance, q.tolerance));
}

void check_same_fabric(const Fabric& f, const Fabric& g) {
    CHECK(f.name == g.name);
    CHECK(same(f.density, g.density));
    CHECK(same(f.thickness, g.thickness));
    CHECK(f.membrane == g.membrane);
    CHECK(same(f.young_modulus, g.young_modulus));
    CHECK(same(f.poisson_ratio, g.poisson_ratio));
    CHECK(f.young_weft == g.young_weft);
    CHECK(f.shear_modulus == g.shear_modulus);
    CHECK(f.mu == g.mu);
    CHECK(f.lambda == g.lambda);
    CHECK(f.strain_limit == g.strain_limit);
    CHECK(f.bending_model == g.bending_model);
    CHECK(same(f.bending, g.bending));
    CHECK(f.bending_weft == g.bending_weft);
    CHECK(f.bending_bias == g.bending_bias);
    CHECK(f.yield_curvature == g.yield_curvature);
    CHECK(same(f.membrane_damping, g.membrane_damping));
    CHECK(same(f.bending_damping, g.bending_damping));
    CHECK(same(f.friction, g.friction));
}

/// Everything in two scenes agrees, doubles to the bit.
void check_same(const SceneFile& a, const SceneFile& b) {
    const SimulationDesc &s = a.scene.simulation, &t = b.scene.simulation;
    CHECK(same_matrix(s.gravity, t.gravity));
    CHECK(same(s.frame_rate, t.frame_rate));
    CHECK(s.time_step == t.time_step);
    CHECK(s.substeps == t.substeps);
    CHECK(s.integrator == t.integrator);
    CHECK(s.hessian == t.hessian);
    CHECK(s.contact == t.contact);
    CHECK(same(s.contact_stiffness, t.contact_stiffness));
    CHECK(s.sliding_speed == t.sliding_speed);
    CHECK(same(s.contact_activation, t.contact_activation));
    CHECK(s.newton_iterations == t.newton_iterations);
    CHECK(same(s.newton_tolerance, t.newton_tolerance));
    CHECK(same(s.newton_speed, t.newton_speed));
    CHECK(s.retries == t.retries);
    CHECK(same(s.air.density, t.air.density));
    CHECK(same(s.air.drag, t.air.drag));
    CHECK(same(s.air.lift, t.air.lift));
    CHECK(same_matrix(s.air.wind, t.air.wind));
    CHECK(same(s.air.gusts, t.air.gusts));
    CHECK(same(s.air.gust_length, t.air.gust_length));
    CHECK(s.air.seed == t.air.seed);
    REQUIRE(a.scene.cloths.size() == b.scene.cloths.size());
    for (std::size_t i = 0; i < a.scene.cloths.size(); ++i) {
        const ClothDesc &c = a.scene.cloths[i], &d = b.scene.cloths[i];
        CHECK(c.name == d.name);
        CHECK(same_matrix(c.grid.size, d.grid.size));
        CHECK(c.grid.resolution == d.grid.resolution);
        CHECK(c.grid.diagonals == d.grid.diagonals);
        REQUIRE(c.mesh.has_value() == d.mesh.has_value());
        if (c.mesh) CHECK(same_matrix(c.mesh->positions, d.mesh->positions));
        if (c.mesh) CHECK(same_matrix(c.mesh->triangles, d.mesh->triangles));
        REQUIRE(c.pose.has_value() == d.pose.has_value());
        if (c.pose) CHECK(same_matrix(*c.pose, *d.pose));
        CHECK(same(c.transform.scale, d.transform.scale));
        CHECK(same_matrix(c.transform.rotate, d.transform.rotate));
        CHECK(same_matrix(c.transform.translate, d.transform.translate));
        CHECK(same_matrix(c.velocity, d.velocity));
        CHECK(same(c.bump, d.bump));
        CHECK(same_matrix(c.warp, d.warp));
        check_same_fabric(c.fabric, d.fabric);
        CHECK(same_material(a.cloth_looks.at(i).material, b.cloth_looks.at(i).material));
    }
    REQUIRE(a.scene.colliders.size() == b.scene.colliders.size());
    for (std::size_t i = 0; i < a.scene.colliders.size(); ++i) {
        const ColliderDesc &c = a.scene.colliders[i], &d = b.scene.colliders[i];
        CHECK(c.name == d.name);
        CHECK(c.shape == d.shape);
        CHECK(same_matrix(c.center, d.center));
        CHECK(same_matrix(c.normal, d.normal));
        CHECK(same(c.radius, d.radius));
        CHECK(same(c.contact_offset, d.contact_offset));
        CHECK(c.contact_radius == d.contact_radius);
        CHECK(same(c.height, d.height));
        CHECK(same_matrix(c.size, d.size));
        CHECK(same(c.scale, d.scale));
        CHECK(same_matrix(c.rotate, d.rotate));
        CHECK(same_matrix(c.spin, d.spin));
        CHECK(same(c.friction, d.friction));
        CHECK(c.enabled == d.enabled);
        CHECK(c.drawn == d.drawn);
        CHECK(same_material(a.collider_looks.at(i).material, b.collider_looks.at(i).material));
    }
    REQUIRE(a.scene.pins.size() == b.scene.pins.size());
    for (std::size_t i = 0; i < a.scene.pins.size(); ++i) {
        const PinDesc &p = a.scene.pins[i], &q = b.scene.pins[i];
        CHECK(p.cloth == q.cloth);
        check_same_selection(p, q);
        REQUIRE(p.path.size() == q.path.size());
        for (std::size_t k = 0; k < p.path.size(); ++k) {
            CHECK(same(p.path[k].time, q.path[k].time));
            CHECK(same_matrix(p.path[k].translate, q.path[k].translate));
            CHECK(same_matrix(p.path[k].rotate, q.path[k].rotate));
        }
        CHECK(p.center == q.center);
        CHECK(p.until == q.until);
    }
    REQUIRE(a.scene.seams.size() == b.scene.seams.size());
    for (std::size_t i = 0; i < a.scene.seams.size(); ++i) {
        const SeamDesc &p = a.scene.seams[i], &q = b.scene.seams[i];
        for (int side = 0; side < 2; ++side) {
            CHECK(p.sides[side].cloth == q.sides[side].cloth);
            check_same_selection(p.sides[side], q.sides[side]);
        }
        CHECK(p.reverse == q.reverse);
        CHECK(same(p.begin, q.begin));
        CHECK(same(p.close_time, q.close_time));
        CHECK(same(p.stiffness, q.stiffness));
    }
    REQUIRE(a.scene.drags.size() == b.scene.drags.size());
    for (std::size_t i = 0; i < a.scene.drags.size(); ++i) {
        const DragDesc &d = a.scene.drags[i], &e = b.scene.drags[i];
        REQUIRE(d.path.size() == e.path.size());
        for (std::size_t k = 0; k < d.path.size(); ++k) {
            CHECK(same(d.path[k].time, e.path[k].time));
            CHECK(same_matrix(d.path[k].pixel, e.path[k].pixel));
        }
        CHECK(same(d.radius, e.radius));
        CHECK(same(d.stiffness, e.stiffness));
        CHECK(same_matrix(d.viewport, e.viewport));
        CHECK(same_matrix(d.view, e.view));
        CHECK(same_matrix(d.projection, e.projection));
    }
    REQUIRE(a.scene.events.size() == b.scene.events.size());
    for (std::size_t i = 0; i < a.scene.events.size(); ++i) {
        const EventDesc &e = a.scene.events[i], &f = b.scene.events[i];
        CHECK(same(e.time, f.time));
        CHECK(e.collider == f.collider);
        CHECK(e.action == f.action);
        CHECK(e.toggle_integrator == f.toggle_integrator);
        CHECK(e.integrator == f.integrator);
    }
    const render::View &v = a.view, &w = b.view;
    CHECK(v.width == w.width);
    CHECK(v.height == w.height);
    CHECK(v.eye == w.eye);
    CHECK(v.target == w.target);
    CHECK(v.up == w.up);
    CHECK(v.field_of_view == w.field_of_view);
    CHECK(v.light.direction == w.light.direction);
    CHECK(v.light.color == w.light.color);
    CHECK(v.light.intensity == w.light.intensity);
    CHECK(v.light.shadow == w.light.shadow);
    CHECK(v.light.softness == w.light.softness);
    CHECK(v.sky == w.sky);
    CHECK(v.background == w.background);
    CHECK(v.exposure == w.exposure);
    CHECK(v.ambient_occlusion == w.ambient_occlusion);
    REQUIRE(a.ground.has_value() == b.ground.has_value());
    if (a.ground) CHECK(a.ground->height == b.ground->height);
    if (a.ground) CHECK(a.ground->color == b.ground->color);
    CHECK(a.description == b.description);
    CHECK(a.output.width == b.output.width);
    CHECK(a.output.height == b.output.height);
    CHECK(a.output.frames == b.output.frames);
    CHECK(a.output.playback_rate == b.output.playback_rate);
    CHECK(a.output.quality == b.output.quality);
    CHECK(same(a.expect.state_tolerance, b.expect.state_tolerance));
    CHECK(a.expect.frames == b.expect.frames);
    CHECK(a.expect.frames_simulated == b.expect.frames_simulated);
    CHECK(a.resolved == b.resolved);
}

/// Every key of every table, none at its default.
const std::string full_scene = R"(version = 1
description = "A \"full\" scene: ü"

[simulation]
gravity = [0.1, -9.5, 1e-3]
frame_rate = 50
substeps = 3
integrator = "implicit_euler"
hessian = "projected"
contact = "penalty"
contact_stiffness = 210
sliding_speed = 0.002
newton_iterations = 17
newton_tolerance = 1e-7
newton_speed = 0.05
retries = 3

[air]
density = 1.1
drag = 1.2
lift = 0.5
wind = [3, 0, 0.5]
gusts = 0.7
gust_length = 2
seed = 4294967295

[[cloth]]
name = "sheet"
size = [1.1, 0.9]
resolution = [7, 5]
diagonals = "mirrored"
warp = [1, 0.5, 0]
scale = 1.5
rotate = [-90, 10, 5]
translate = [0.1, 0.2, 0.3]
velocity = [1, 2, 3]
bump = 0.01
color = "#336699"
back_color = [0.1, 0.2, 0.3]
roughness = 0.6
specular = 0.05
sheen = 0.2
[cloth.fabric]
name = "sailcloth"
density = 0.2
thickness = 2e-3
membrane = "st_venant_kirchhoff"
young_modulus = 2e5
poisson_ratio = 0.25
young_weft = 1e5
shear_modulus = 3e4
bending_model = "hinges"
bending = 1e-4
bending_weft = 5e-5
bending_bias = 6e-5
yield_curvature = 200
membrane_damping = 0.001
bending_damping = 0.002
friction = 0.35

[[cloth]]
name = "second"
pose = "pose.obj"
mesh = "rest.ply"
fabric = { mu = 142857.14285714287, lambda = 35714.285714285714 }

[[collider]]
name = "ball"
shape = "sphere"
center = [0, 0.1, 0.2]
radius = 0.3
contact_radius = 0.32
friction = 0.4
enabled = false
drawn = false
color = "#ffffff"

[[collider]]
name = "wall"
shape = "plane"
center = [0, -1, 0]
normal = [0, 2, 0.5]
contact_offset = 0.01

[[pin]]
vertices = [0, 3]
center = [0, 0.1, 0]
until = 1.5
[[pin]]
edge = "top"
path = [{ time = 0.25 }, { time = 1, translate = [0, 0.1, 0], rotate = [0, 90, 0] }]
[[pin]]
cloth = "second"
box = [[-9, -9, -9], [9, 9, 9]]
[[pin]]
cloth = 1
nearest = [0, 0, 0]
[[pin]]
greatest = "-x"
tolerance = 0.02

[[seam]]
first = { edge = "left" }
second = { cloth = "sheet", vertices = [6, 13, 20, 27, 34] }
reverse = true
begin = 0.5
close_time = 0.25
stiffness = 300

[[drag]]
path = [[0.1, 320, 240], [0.2, 330.5, 250]]
radius = 0.2
stiffness = 2e4
viewport = [640, 480]

[[event]]
time = 0.5
collider = "wall"
action = "off"
[[event]]
time = 0.6
collider = "ball"
[[event]]
time = 0.7
integrator = "toggle"
[[event]]
time = 0.8
integrator = "linearly_implicit_euler"
[[event]]
time = 0.9
integrator = "tr_bdf2"

[camera]
position = [1, 2, 3]
target = [0, 0.5, 0]
up = [0, 1, 0.1]
field_of_view = 42

[[light]]
direction = [1, 2, 3]
color = "#ffeedd"
intensity = 2.25
shadow = false
softness = 0.02

[ground]
height = -1.25
color = "#808080"

[background]
color = "#c0c8d0"
sky = [0.5, 0.6, 0.7]
exposure = 1.2
ambient_occlusion = false

[output]
size = "640x360"
frames = 42
playback_rate = 25
quality = 20

[expect]
state_tolerance = 1e-5
frames = [3, 9, 6]
)";

/// A folder with the meshes of full_scene.
struct FullFolder {
    TemporaryFolder folder;
    FullFolder() {
        MeshData mesh = make_grid({.resolution = {3, 3}});
        write_mesh(mesh, MeshFormat::ply, folder / "rest.ply");
        mesh.positions.array() += 0.1;
        mesh.triangles.resize(0, 3);
        write_mesh(mesh, MeshFormat::obj, folder / "pose.obj");
        spit(folder / "full.toml", full_scene);
    }
};

}  // namespace

// ---------------------------------------------------------------- what is read

TEST_CASE("every key reaches its field", "[scene_file]") {
    const FullFolder place;
    const SceneFile f = load_scene((place.folder / "full.toml").string());
    CHECK(f.name == "full");
    CHECK(f.description == "A \"full\" scene: ü");
    const SimulationDesc& s = f.scene.simulation;
    CHECK(s.gravity == Vec3(0.1, -9.5, 1e-3));
    CHECK(s.frame_rate == 50.0);
    CHECK(!s.time_step);
    CHECK(s.substeps == 3);
    CHECK(s.integrator == IntegratorKind::implicit_euler);
    CHECK(s.hessian == LinearHessian::projected);
    CHECK(s.contact == ContactKind::penalty);
    CHECK(s.contact_stiffness == 210.0);
    CHECK(s.sliding_speed == 0.002);
    CHECK(s.newton_iterations == 17);
    CHECK(s.newton_tolerance == 1e-7);
    CHECK(s.newton_speed == 0.05);
    CHECK(s.retries == 3);
    CHECK(s.air.density == 1.1);
    CHECK(s.air.drag == 1.2);
    CHECK(s.air.lift == 0.5);
    CHECK(s.air.wind == Vec3(3, 0, 0.5));
    CHECK(s.air.gusts == 0.7);
    CHECK(s.air.gust_length == 2.0);
    CHECK(s.air.seed == 4294967295u);

    REQUIRE(f.scene.cloths.size() == 2);
    const ClothDesc& c = f.scene.cloths[0];
    CHECK(c.name == "sheet");
    CHECK(c.grid.size == Vec2(1.1, 0.9));
    CHECK(c.grid.resolution == std::array<int, 2>{7, 5});
    CHECK(c.grid.diagonals == Diagonals::mirrored);
    CHECK(c.warp == Vec3(1, 0.5, 0));
    CHECK(c.transform.scale == 1.5);
    CHECK(c.transform.rotate == Vec3(-90, 10, 5));
    CHECK(c.transform.translate == Vec3(0.1, 0.2, 0.3));
    CHECK(c.velocity == Vec3(1, 2, 3));
    CHECK(c.bump == 0.01);
    CHECK(c.fabric.name == "sailcloth");
    CHECK(c.fabric.density == 0.2);
    CHECK(c.fabric.thickness == 2e-3);
    CHECK(c.fabric.membrane == MembraneKind::st_venant_kirchhoff);
    CHECK(c.fabric.young_weft == 1e5);
    CHECK(c.fabric.shear_modulus == 3e4);
    CHECK(!c.fabric.strain_limit);
    CHECK(c.fabric.bending_model == BendingKind::hinges);
    CHECK(c.fabric.bending_weft == 5e-5);
    CHECK(c.fabric.bending_bias == 6e-5);
    CHECK(c.fabric.yield_curvature == 200.0);
    CHECK(c.fabric.membrane_damping == 0.001);
    CHECK(c.fabric.bending_damping == 0.002);
    CHECK(c.fabric.friction == 0.35);
    CHECK(c.fabric.young_modulus == 2e5);
    CHECK(c.fabric.poisson_ratio == 0.25);
    CHECK(c.fabric.bending == 1e-4);
    CHECK(!c.fabric.mu);
    // IEC 61966-2-1: 0x33/255 = 0.2 → 0.0331048; 0.1 → 0.0100228
    CHECK(f.cloth_looks[0].material.front[0] == Approx(0.0331048));
    CHECK(f.cloth_looks[0].material.back[0] == Approx(0.0100228));
    CHECK(f.cloth_looks[0].material.roughness == 0.6f);
    CHECK(f.cloth_looks[0].material.specular == 0.05f);
    CHECK(f.cloth_looks[0].material.sheen == 0.2f);
    const ClothDesc& d = f.scene.cloths[1];
    REQUIRE(d.mesh);
    CHECK(d.mesh->triangles.rows() == 8);
    REQUIRE(d.pose);
    CHECK((*d.pose)(0, 2) == 0.1);
    CHECK(d.fabric.mu == 142857.14285714287);
    CHECK(d.fabric.lambda == 35714.285714285714);
    CHECK(f.cloth_looks[1].material.front == f.cloth_looks[1].material.back);

    REQUIRE(f.scene.colliders.size() == 2);
    const ColliderDesc &ball = f.scene.colliders[0], &wall = f.scene.colliders[1];
    CHECK(ball.name == "ball");
    CHECK(ball.shape == Shape::sphere);
    CHECK(ball.center == Vec3(0, 0.1, 0.2));
    CHECK(ball.radius == 0.3);
    CHECK(ball.contact_radius == 0.32);
    CHECK(ball.friction == 0.4);
    CHECK_FALSE(ball.enabled);
    CHECK_FALSE(ball.drawn);
    CHECK(f.collider_looks[0].material.front == render::Float3{1.0f, 1.0f, 1.0f});
    CHECK(wall.shape == Shape::plane);
    CHECK(wall.normal == Vec3(0, 2, 0.5));
    CHECK(wall.contact_offset == 0.01);

    REQUIRE(f.scene.pins.size() == 5);
    CHECK(f.scene.pins[0].vertices == std::vector<int>{0, 3});
    CHECK(f.scene.pins[0].cloth == 0);
    CHECK(f.scene.pins[0].path.empty());
    CHECK(*f.scene.pins[0].center == Vec3(0, 0.1, 0));
    CHECK(f.scene.pins[0].until == 1.5);
    CHECK(f.scene.pins[1].edge == "top");
    REQUIRE(f.scene.pins[1].path.size() == 2);
    CHECK(f.scene.pins[1].path[0].time == 0.25);
    CHECK(f.scene.pins[1].path[0].translate == Vec3::Zero());
    CHECK(f.scene.pins[1].path[1].time == 1.0);
    CHECK(f.scene.pins[1].path[1].translate == Vec3(0, 0.1, 0));
    CHECK(f.scene.pins[1].path[1].rotate == Vec3(0, 90, 0));
    CHECK(!f.scene.pins[1].until);
    CHECK(f.scene.pins[2].cloth == 1);
    CHECK((*f.scene.pins[2].box)[1] == Vec3(9, 9, 9));
    CHECK(f.scene.pins[3].cloth == 1);
    CHECK(*f.scene.pins[3].nearest == Vec3(0, 0, 0));
    CHECK(f.scene.pins[4].greatest == "-x");
    CHECK(f.scene.pins[4].tolerance == 0.02);

    REQUIRE(f.scene.seams.size() == 1);
    CHECK(f.scene.seams[0].sides[0].cloth == 0);
    CHECK(f.scene.seams[0].sides[0].edge == "left");
    CHECK(f.scene.seams[0].sides[1].vertices == std::vector<int>{6, 13, 20, 27, 34});
    CHECK(f.scene.seams[0].reverse);
    CHECK(f.scene.seams[0].begin == 0.5);
    CHECK(f.scene.seams[0].close_time == 0.25);
    CHECK(f.scene.seams[0].stiffness == 300.0);

    REQUIRE(f.scene.drags.size() == 1);
    CHECK(f.scene.drags[0].path[1].time == 0.2);
    CHECK(f.scene.drags[0].path[1].pixel == Vec2(330.5, 250));
    CHECK(f.scene.drags[0].radius == 0.2);
    CHECK(f.scene.drags[0].stiffness == 2e4);
    CHECK(f.scene.drags[0].viewport == Vec2(640, 480));

    REQUIRE(f.scene.events.size() == 5);
    CHECK(f.scene.events[0].time == 0.5);
    CHECK(f.scene.events[0].collider == 1);
    CHECK(f.scene.events[0].action == Switch::off);
    CHECK(f.scene.events[1].collider == 0);
    CHECK(f.scene.events[1].action == Switch::toggle);
    CHECK(f.scene.events[2].toggle_integrator);
    CHECK(f.scene.events[3].integrator == IntegratorKind::linearly_implicit_euler);
    CHECK(f.scene.events[4].integrator == IntegratorKind::tr_bdf2);

    CHECK(f.view.eye == render::Float3{1, 2, 3});
    CHECK(f.view.target == render::Float3{0, 0.5f, 0});
    CHECK(f.view.up == render::Float3{0, 1, 0.1f});
    CHECK(f.view.field_of_view == 42.0f);
    CHECK(f.view.light.direction == render::Float3{1, 2, 3});
    CHECK(f.view.light.color[0] == 1.0f);
    CHECK(f.view.light.intensity == 2.25f);
    CHECK_FALSE(f.view.light.shadow);
    CHECK(f.view.light.softness == 0.02f);
    CHECK(f.view.sky[0] == Approx(0.2140411));
    CHECK(f.view.background[0] == Approx(0.5271151));
    CHECK(f.view.exposure == 1.2f);
    CHECK_FALSE(f.view.ambient_occlusion);
    REQUIRE(f.ground);
    CHECK(f.ground->height == -1.25f);
    CHECK(f.ground->color[1] == Approx(0.2158605));
    CHECK(f.view.width == 640);
    CHECK(f.output.height == 360);
    CHECK(f.output.frames == 42);
    CHECK(f.output.playback_rate == 25.0);
    CHECK(f.output.quality == 20);
    CHECK(f.expect.state_tolerance == 1e-5);
    CHECK(f.expect.frames == std::vector<int>{3, 9, 6});
    CHECK(f.expect.frames_simulated == 10);
}

TEST_CASE("a resolved scene loads to the same scene, bit for bit", "[scene_file]") {
    const auto check_round_trip = [](const SceneFile& file) {
        INFO(file.resolved);
        // Read elsewhere: meshes have to be named absolutely.
        const TemporaryFolder elsewhere;
        check_same(parse_scene(file.resolved, file.name + ".toml", elsewhere.path()), file);
    };
    SECTION("with every key given") {
        const FullFolder place;
        check_round_trip(load_scene((place.folder / "full.toml").string()));
    }
    SECTION("with no key given") {
        check_round_trip(parse(sheet()));
    }
    SECTION("with numbers that are hard to write") {
        check_round_trip(parse(
            sheet(), {"cloth.translate=[-0.0, 5e-324, 1.7976931348623157e308]", "simulation.frame_rate=0.1",
                      "cloth.bump=1e22", "cloth.scale=0.30000000000000004", "cloth.name=a \"b\" \\ c\x7f\x01",
                      "cloth.color=[0, 1, 0.123456789]", "light.softness=0.1", "camera.up=[0.1, 0.7, 0.3]"}));
    }
    SECTION("the scenes of the project") {
        for (const char* name : {"seed_sheet", "seed_kick", "seed_drag", "drape_sphere", "hanging_sheet"}) {
            INFO(name);
            check_round_trip(load_scene(name));
        }
    }
}

TEST_CASE("a cloth's pattern, threads, hem and the light's size reach the renderer", "[scene_file]") {
    const SceneFile f = parse(sheet(R"(color = "#ffffff"
pattern = "tartan"
pattern_scale = 0.3
pattern_colors = ["#ff0000", [0.0, 1.0, 0.0]]
weave = 0.002
weave_depth = 0.25
hem = 0.004
[[light]]
angle = 7.5
)"));
    const render::Material& m = f.cloth_looks[0].material;
    CHECK(m.pattern == render::Pattern::tartan);
    CHECK(m.pattern_scale == 0.3f);
    CHECK(m.pattern_colors[0] == render::Float3{1, 0, 0});
    CHECK(m.pattern_colors[1] == render::Float3{0, 1, 0});
    CHECK(m.pattern_colors[2] == render::Float3{0, 1, 0});  // the last one is repeated
    CHECK(m.pattern_on_back);
    CHECK(m.weave == 0.002f);
    CHECK(m.weave_depth == 0.25f);
    CHECK(f.cloth_looks[0].hem == 0.004);
    CHECK(f.view.light.angle == 7.5f);
    check_same(parse(f.resolved), f);
    CHECK_FALSE(parse(sheet("pattern = \"dots\"\nback_color = \"#000000\"\n"))
                    .cloth_looks[0]
                    .material.pattern_on_back);

    const TemporaryFolder folder;
    render::write_png({2, 1, {255, 0, 0, 255, 0, 255, 0, 255}}, folder / "print.png");
    const SceneFile printed = parse_scene(sheet("texture = \"print.png\"\n"), "s.toml", folder.path(), {});
    CHECK(printed.cloth_looks[0].material.pattern == render::Pattern::image);
    CHECK(printed.cloth_looks[0].material.image->width == 2);
}

TEST_CASE("a cloth hangs with a rolled rim that keeps to its outline", "[frame_builder]") {
    const SceneFile f = parse(sheet("resolution = 5\nhem = 0.01\nsubdivisions = 0\n"));
    const Model model = build_model(f.scene);
    FrameBuilder builder(f, model);
    const render::Frame frame = builder.build(start_state(model));
    REQUIRE(frame.surfaces.size() == 3);  // the sheet, and its rim's two halves
    for (const std::size_t half : {1u, 2u}) {
        const render::Surface& rim = frame.surfaces[half];
        CHECK_FALSE(rim.casts_shadow);
        CHECK(rim.positions.size() == 3 * 5 * 16);  // 16 rim vertices, 5 points across
        float low = 0, high = 0, outermost = 0;
        for (std::size_t i = 0; i < rim.positions.size(); i += 3) {
            low = std::min(low, rim.positions[i + 2]);
            high = std::max(high, rim.positions[i + 2]);
            outermost = std::max(outermost, std::abs(rim.positions[i]));
            const float length = std::hypot(rim.normals[i], rim.normals[i + 1], rim.normals[i + 2]);
            CHECK(length == Approx(1).margin(1e-5));
        }
        CHECK(high == Approx(half == 1 ? 0.005 : 0).margin(1e-6));  // half the thickness to each side
        CHECK(low == Approx(half == 1 ? 0 : -0.005).margin(1e-6));
        CHECK(outermost == Approx(0.505).margin(1e-6));
    }
    // Rest coordinates go on over the rim: there they are the positions too.
    for (const render::Surface& s : frame.surfaces)
        for (std::size_t v = 0; 2 * v < s.coordinates.size(); ++v)
            for (std::size_t k = 0; k < 2; ++k)
                CHECK(s.coordinates[2 * v + k] == Approx(s.positions[3 * v + k]).margin(1e-6));
    const SceneFile plain = parse(sheet("hem = 0.0\n"));
    const Model plain_model = build_model(plain.scene);
    CHECK(FrameBuilder(plain, plain_model).build(start_state(plain_model)).surfaces.size() == 1);
}

TEST_CASE("a level plane is drawn as the ground, another one as a surface", "[frame_builder]") {
    const auto frame_of = [](const std::string& plane, const std::string& rest = "") {
        const SceneFile f =
            parse(sheet("hem = 0.0\n") + "[[collider]]\nshape = \"plane\"\ncolor = [1, 0, 0]\n" +
                  "center = [0, -0.75, 0]\n" + plane + rest +
                  "[simulation]\nintegrator = \"implicit_euler\"\ncontact = \"barrier\"\n");
        const Model model = build_model(f.scene);
        return FrameBuilder(f, model).build(start_state(model));
    };
    for (const std::string level : {"", "spin = [0, 90, 0]\n", "normal = [0, 3, 0]\n"}) {
        CAPTURE(level);
        const render::Frame frame = frame_of(level);
        CHECK(frame.surfaces.size() == 1);
        CHECK(frame.ground == render::Ground{-0.75f, {1, 0, 0}});
    }
    for (const std::string other : {"normal = [0.1, 1, 0]\n", "spin = [90, 0, 0]\n", "normal = [0, -1, 0]\n",
                                    "path = [{ time = 0 }, { time = 1, translate = [0, 1, 0] }]\n"}) {
        CAPTURE(other);
        const render::Frame frame = frame_of(other);
        CHECK(frame.surfaces.size() == 2);
        CHECK_FALSE(frame.ground.has_value());
    }
    CHECK(frame_of("", "[ground]\nheight = -2.0\n").surfaces.size() ==
          2);  // it has the ground that it asks for
    CHECK_FALSE(frame_of("enabled = false\n").ground.has_value());
}

TEST_CASE("the assignment's scenes hold the assignment's numbers", "[scene_file]") {
    for (const std::string name : {"seed_sheet", "seed_kick", "seed_drag"}) {
        INFO(name);
        const SceneFile f = load_scene(name);
        const Scene& s = f.scene;
        CHECK(s.simulation.gravity == Vec3(0, -1800.8, 0));
        CHECK(s.simulation.steps_per_frame() == 1);
        CHECK(same(s.simulation.step_size(), 0.001));
        CHECK(s.simulation.integrator == IntegratorKind::linearly_implicit_euler);
        CHECK(s.simulation.hessian == LinearHessian::assignment);
        CHECK(s.simulation.contact == ContactKind::velocity_filter);
        REQUIRE(s.cloths.size() == 1);
        CHECK(s.cloths[0].grid.size == Vec2(1, 1));
        CHECK(s.cloths[0].grid.resolution == std::array<int, 2>{20, 20});
        CHECK(s.cloths[0].grid.diagonals == Diagonals::uniform);
        CHECK(s.cloths[0].velocity == Vec3(0, 0, name == "seed_kick" ? 30 : 0));
        CHECK(s.cloths[0].fabric.density == 1.0);
        CHECK(s.cloths[0].fabric.thickness == 1.0);
        // E/((1+ν)(1-2ν)) ν and E/(2(1+ν)) for E = 1e5, ν = 0.4
        CHECK(*s.cloths[0].fabric.mu == Approx(1e5 * 0.4 / (1.4 * 0.2)).epsilon(1e-15));
        CHECK(*s.cloths[0].fabric.lambda == Approx(1e5 / 2.8).epsilon(1e-15));
        REQUIRE(s.colliders.size() == 1);
        CHECK(s.colliders[0].center == Vec3(0, 0, 0.4));
        CHECK(s.colliders[0].radius == 0.2);
        CHECK(*s.colliders[0].contact_radius == 0.22);
        CHECK(s.colliders[0].enabled == (name == "seed_kick"));
        CHECK(s.colliders[0].friction == 0.0);
        CHECK(f.output.playback_rate == 50.0);
        const Model model = build_model(s);
        CHECK(model.triangle_count() == 722);
        CHECK(model.pinned.size() == 20);
    }
}

TEST_CASE("a drag sees through the scene's camera as OpenGL does", "[scene_file]") {
    const SceneFile f =
        parse(sheet("[camera]\nposition = [1, 2, 3]\ntarget = [0, 0.5, -1]\nfield_of_view = 90\n"
                    "[[drag]]\nviewport = [200, 100]\npath = [[0, 1, 1], [1, 2, 2]]\n"));
    const DragDesc& d = f.scene.drags[0];
    const auto project = [&](const Vec3& p) -> Vec3 {
        return (d.projection * d.view * p.homogeneous()).hnormalized();
    };
    // The target stands in the middle of the picture.
    CHECK(project(Vec3(0, 0.5, -1)).head<2>().norm() == Approx(0.0).margin(1e-14));
    // 90 degrees from lower to upper edge: what is as far up as ahead lies on the upper edge (y = 1).
    const Vec3 ahead = (Vec3(0, 0.5, -1) - Vec3(1, 2, 3)).normalized();
    const Vec3 right = ahead.cross(Vec3::UnitY()).normalized(), up = right.cross(ahead);
    const Vec3 upper = project(Vec3(1, 2, 3) + 2 * ahead + 2 * up);
    CHECK(upper.x() == Approx(0.0).margin(1e-14));
    CHECK(upper.y() == Approx(1.0));
    // Twice as wide as high, so the right edge (x = 1) is twice as far aside.
    CHECK(project(Vec3(1, 2, 3) + 2 * ahead + 4 * right).x() == Approx(1.0));
    // Between the clip planes depth grows with distance.
    const double near = project(Vec3(1, 2, 3) + 0.5 * ahead).z(),
                 far = project(Vec3(1, 2, 3) + 5 * ahead).z();
    CHECK(-1.0 < near);
    CHECK(near < far);
    CHECK(far < 1.0);
}

// ---------------------------------------------------------------- what is refused

TEST_CASE("errors name file, line, column, key and what would be right", "[scene_file]") {
    struct Case {
        std::string text, message;
    };
    const std::vector<Case> cases = {
        // what is not TOML
        {"version = 1\n[simulation\n", "s.toml:2:"},
        {"version = 1\nversion = 1\n", "s.toml:2:"},
        {"version = 1\nx = \"\\q\"\n", "s.toml:2:"},
        {"version = 1\nx = 99999999999999999999\n", "s.toml:2:"},
        // version
        {"", "s.toml:1:1: version: is missing; write version = 1"},
        {"version = 2\n", "s.toml:1:11: version: is 2; this program reads version 1"},
        {"version = \"1\"\n", "s.toml:1:11: version: is a string; must be a whole number"},
        // unknown keys
        {sheet("fabric = { densty = 1 }\n"),
         "s.toml:3:12: cloth[0].fabric.densty: unknown key; did you mean \"density\" [kg/m²]?"},
        {sheet("wibble = 1\n"), "s.toml:3:1: cloth[0].wibble: unknown key; known here: "},
        {sheet("[simulaton]\n"), "s.toml:3:2: simulaton: unknown key; did you mean \"simulation\"?"},
        {sheet("[simulation]\n  frame_rte = 1\n"),
         "s.toml:4:3: simulation.frame_rte: unknown key; did you mean "
         "\"frame_rate\" [1/s]?"},
        {sheet("[camera]\nzoom_in = 1\n"),
         "s.toml:4:1: camera.zoom_in: unknown key; known here: position, target"},
        // types
        {sheet("size = 1\n"), "s.toml:3:8: cloth[0].size: is a whole number; must be [x, y] [m]"},
        {sheet("size = [1, 2, 3]\n"), "s.toml:3:8: cloth[0].size: has 3 entries; must be [x, y] [m]"},
        {sheet("size = [1, \"a\"]\n"), "cloth[0].size: is a string; must be a number [m]"},
        {sheet("resolution = 20.5\n"), "cloth[0].resolution: is a number; must be a whole number or"},
        {sheet("resolution = 5000000000\n"), "is 5000000000; must be between -2147483648 and 2147483647"},
        {sheet("bump = true\n"), "cloth[0].bump: is a boolean; must be a number [m]"},
        {sheet("bump = \"high\"\n"), "cloth[0].bump: is a string; must be a number [m]"},
        {sheet("bump = 1979-05-27\n"), "cloth[0].bump: is a date or time; must be a number [m]"},
        {sheet("name = 3\n"), "cloth[0].name: is a whole number; must be a string"},
        {sheet("fabric = 3\n"),
         "s.toml:3:10: cloth[0].fabric: is a whole number; must be a fabric's name "
         "or a table"},
        {sheet("[[collider]]\nenabled = 1\n"),
         "collider[0].enabled: is a whole number; must be true or false"},
        {sheet("[[pin]]\nvertices = 3\n"), "pin[0].vertices: is a whole number; must be an array"},
        {sheet("[[pin]]\nbox = [[1, 2, 3]]\n"), "pin[0].box: has 1 entries; must be two entries [m]"},
        {sheet("[[drag]]\npath = [[1, 2]]\n"), "drag[0].path: has 2 entries; must be [time, x, y]"},
        {sheet("[[camera]]\n"), "camera: is an array; must be a table, [camera]"},
        {"version = 1\n[cloth]\n", "s.toml:2:1: cloth: is a table; must be a list of tables, [[cloth]]"},
        {"version = 1\ncloth = [1]\n", "cloth: is a whole number; must be a table, [[cloth]]"},
        // colours and sizes
        {sheet("color = \"red\"\n"),
         "cloth[0].color: is a string; must be \"#rrggbb\" or [red, green, blue]"},
        {sheet("color = [0, 0, 1.5]\n"), "cloth[0].color: is out of range; must be \"#rrggbb\""},
        {sheet("color = [0, 0]\n"), "cloth[0].color: must be \"#rrggbb\""},
        {sheet("[output]\nsize = \"640\"\n"),
         "output.size: is \"640\"; must be \"WIDTHxHEIGHT\" or [width, height]"},
        {sheet("[output]\nsize = \"99999999999x9\"\n"), "must be \"WIDTHxHEIGHT\" or [width, height]"},
        {sheet("[output]\nsize = 640\n"), "output.size: is a whole number; must be \"WIDTHxHEIGHT\""},
        {sheet("[output]\nsize = [0, 360]\n"), "output.size: has a side of 0 pixel; must be 16 … 8192"},
        {sheet("[output]\nsize = \"640x10000\"\n"),
         "output.size: has a side of 10000 pixel; must be 16 … 8192"},
        // numbers that are none
        {sheet("bump = nan\n"), "s.toml:3:8: cloth[0].bump: is not finite; must be a finite number [m]"},
        {sheet("translate = [0, inf, 0]\n"),
         "cloth[0].translate: is not finite; must be a finite number [m]"},
        {sheet("[camera]\nfield_of_view = -inf\n"), "camera.field_of_view: is not finite"},
        // words
        {sheet("diagonals = \"unifrom\"\n"),
         "s.toml:3:13: cloth[0].diagonals: is \"unifrom\"; did you mean \"uniform\"? (one of uniform, "
         "mirrored, alternating)"},
        {sheet("diagonals = \"zigzag-ish\"\n"),
         "is \"zigzag-ish\"; must be one of uniform, mirrored, alternating"},
        {sheet("[simulation]\nintegrator = \"implict_euler\"\n"), "did you mean \"implicit_euler\"?"},
        {sheet("[simulation]\nhessian = \"none at all\"\n"), "must be one of assignment, projected"},
        {sheet("[simulation]\ncontact = \"penality\"\n"), "did you mean \"penalty\"?"},
        {sheet("[[collider]]\nshape = \"spere\"\n"),
         "collider[0].shape: is \"spere\"; did you mean \"sphere\"?"},
        {sheet("[[event]]\naction = \"of\"\n"), "event[0].action: is \"of\"; did you mean"},
        {sheet("[[event]]\nintegrator = \"euler\"\n"),
         "s.toml:4:14: event[0].integrator: is \"euler\"; must be one of "
         "toggle, linearly_implicit_euler, implicit_euler, tr_bdf2, implicit_midpoint"},
        // ranges, most of them known to the simulation alone
        {sheet("[simulation]\ntime_step = 0\n"),
         "s.toml:4:13: simulation.time_step: is 0; must be greater than 0 s"},
        {sheet("[simulation]\ntime_step = -0.01\n"),
         "simulation.time_step: is -0.01; must be greater than 0 s"},
        {sheet("[simulation]\nsubsteps = 0\n"), "simulation.substeps: is 0; must be 1 … 1000000"},
        {sheet("[simulation]\nframe_rate = -1\n"),
         "simulation.frame_rate: is -1; must be greater than 0 1/s"},
        {sheet("[simulation]\ntime_step = 0.1\nsubsteps = 2\n"),
         "s.toml:4:13: simulation.time_step: stands beside simulation.substeps; give one of the two"},
        {sheet("size = [0, 1]\n"), "s.toml:3:8: cloth[0].size: is 0; must be greater than 0 m"},
        {sheet("resolution = 1\n"), "s.toml:3:14: cloth[0].resolution: is 1; must be 2 … 4096 vertices"},
        {sheet("resolution = [-4, 3]\n"), "cloth[0].resolution: is -4; must be 2 … 4096 vertices"},
        {sheet("scale = 0\n"), "cloth[0].scale: is 0; must be greater than 0"},
        {sheet("fabric.density = -1\n"),
         "s.toml:3:18: cloth[0].fabric.density: is -1; must be greater than 0 kg/m²"},
        {sheet("fabric.mu = 1\n"), "cloth[0].fabric.mu: mu and lambda are given together or not at all"},
        {sheet("fabric = { mu = 1, lambda = 1, young_modulus = 2 }\n"),
         "cloth[0].fabric.young_modulus: stands beside mu and lambda"},
        {sheet("[[collider]]\nshape = \"box\"\n"), "collider[0].shape: needs contact = \"barrier\""},
        {sheet("[[collider]]\nspin = [0, 90, 0]\n"), "collider[0].spin: needs contact = \"barrier\""},
        {sheet("[[collider]]\nmesh = \"a.obj\"\n"), "collider[0].mesh: belongs to shape = \"mesh\""},
        {sheet("[simulation]\ncontact = \"barrier\"\nintegrator = \"implicit_euler\"\n"
               "[[collider]]\nshape = \"mesh\"\n"),
         "collider[0].mesh: is missing"},
        {sheet("[simulation]\ncontact = \"barrier\"\nintegrator = \"implicit_midpoint\"\n"),
         "simulation.contact: is \"barrier\", which needs integrator = \"implicit_euler\" or"},
        {sheet("[simulation]\ncontact_activation = 0\n"),
         "simulation.contact_activation: is 0; must be greater than 0 m"},
        {sheet("contact_thickness = 0\n"), "cloth[0].contact_thickness: is 0; must be greater than 0 m"},
        {sheet("[[collider]]\nradius = -1\n"), "collider[0].radius: is -1; must be greater than 0 m"},
        {sheet("[[collider]]\ncontact_radius = 0.3\ncontact_offset = 0.1\n"),
         "collider[0].contact_radius: stands beside contact_offset; give one of the two"},
        {sheet("[[collider]]\nshape = \"plane\"\nnormal = [0, 0, 0]\n"), "collider[0].normal: is zero"},
        {sheet("[camera]\nfield_of_view = 180\n"),
         "s.toml:4:17: camera.field_of_view: is 180; must be 1 … 160 degree"},
        {sheet("[camera]\ntarget = [0, 0, 1]\nposition = [0, 0, 1]\n"),
         "s.toml:4:10: camera.target: is where the camera"},
        {sheet("[camera]\nup = [0, 0, 0]\n"), "camera.up: points along the view"},
        {sheet("[camera]\nposition = [0, 1, 0]\n"), "camera.up: points along the view"},
        {sheet("[[light]]\ndirection = [0, 0, 0]\n"), "s.toml:4:13: light[0].direction: is zero"},
        {sheet("[light]\nintensity = -1\n"), "light[0].intensity: is -1; must be 0 … "},
        {sheet("[[light]]\n[[light]]\n"), "s.toml:4:1: light[1]: there is one light"},
        {sheet("roughness = 1.5\n"), "s.toml:3:13: cloth[0].roughness: is 1.5; must be 0 … 1"},
        {sheet("[[collider]]\nspecular = -0.5\n"), "collider[0].specular: is -0.5; must be 0 … 1"},
        {sheet("sheen = -1\n"), "cloth[0].sheen: is -1; must be 0 … 10"},
        {sheet("pattern = \"tartn\"\n"),
         "s.toml:3:11: cloth[0].pattern: is \"tartn\"; did you mean \"tartan\"?"},
        {sheet("pattern_scale = 0\n"), "cloth[0].pattern_scale: is 0; must be 0.0001 … 1000 m"},
        {sheet("pattern_colors = []\n"),
         "cloth[0].pattern_colors: has 0 entries; must be one to three colours"},
        {sheet("pattern_colors = [\"red\"]\n"), "cloth[0].pattern_colors: is a string; must be \"#rrggbb\""},
        {sheet("texture = \"none.png\"\n"), "s.toml:3:11: cloth[0].texture: "},
        {sheet("texture = \"a.png\"\npattern = \"dots\"\n"),
         "cloth[0].pattern: stands beside texture, which takes its place; give one or the other"},
        {sheet("weave = -1\n"), "cloth[0].weave: is -1; must be 0 … 1 m"},
        {sheet("weave_depth = 3\n"), "cloth[0].weave_depth: is 3; must be 0 … 2"},
        {sheet("hem = 1\n"), "cloth[0].hem: is 1; must be 0 … 0.1 m"},
        {sheet("[[light]]\nangle = 90\n"), "light[0].angle: is 90; must be 0 … 45 degree"},
        {sheet("[background]\nexposure = 0\n"), "background.exposure: is 0; must be "},
        {sheet("[output]\nframes = 0\n"), "s.toml:4:10: output.frames: is 0; must be 1 … "},
        {sheet("[output]\nquality = 52\n"), "output.quality: is 52; must be 0 … 51"},
        {sheet("[output]\nplayback_rate = 0\n"), "output.playback_rate: is 0; must be 0.01 … 1000 1/s"},
        {sheet("[expect]\nframes = [-1]\n"), "s.toml:4:10: expect.frames: is -1; must be 0 … "},
        {sheet("[expect]\nstate_tolerance = 0\n"), "expect.state_tolerance: is 0; must be "},
        // references
        {"version = 1\n", "cloth: the scene has no [[cloth]]"},
        {sheet("name = \"a\"\n[[cloth]]\nname = \"a\"\n"),
         "s.toml:5:8: cloth[1].name: \"a\" is taken; names must differ"},
        {sheet("[[collider]]\nname = \"a\"\n[[collider]]\nname = \"a\"\n"),
         "collider[1].name: \"a\" is taken"},
        {sheet("[[event]]\ncollider = \"ball\"\n"),
         "s.toml:4:12: event[0].collider: there is no collider \"ball\"; the scene has none"},
        {sheet("[[collider]]\nname = \"ball\"\n[[event]]\ncollider = \"bal\"\n"),
         "event[0].collider: there is no collider \"bal\"; did you mean \"ball\"?"},
        {sheet("[[collider]]\nname = \"ball\"\n[[event]]\ncollider = \"somewhere\"\n"), "known: ball"},
        {sheet("[[event]]\naction = \"on\"\n"),
         "event[0].action: acts on a collider; name one with collider"},
        {sheet("[[event]]\ntime = 1\n"), "s.toml:3:1: event[0]: give either a collider or an integrator"},
        {sheet("[[event]]\ntime = -1\nintegrator = \"toggle\"\n"),
         "event[0].time: is -1; must be at least 0 s"},
        {sheet("[[pin]]\ncloth = \"other\"\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: there is no cloth \"other\""},
        {sheet("[[pin]]\ncloth = 1\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is 1; the scene has 1 [[cloth]], counted from 0"},
        {sheet("[[pin]]\ncloth = -1\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is -1; the scene has 1 [[cloth]]"},
        {sheet("[[pin]]\ncloth = 0.5\nnearest = [0, 0, 0]\n"),
         "pin[0].cloth: is a number; must be a cloth's name or its index"},
        {sheet("[[pin]]\n"), "s.toml:3:1: pin[0]: give exactly one of vertices, box, nearest, greatest"},
        {sheet("[[pin]]\nvertices = []\n"), "pin[0].vertices: is empty"},
        {sheet("[[pin]]\nvertices = [400]\n"),
         "s.toml:4:12: pin[0].vertices: vertex 400 does not exist; the cloth has "
         "vertices 0 … 399"},
        {sheet("[[pin]]\nbox = [[5, 5, 5], [6, 6, 6]]\n"), "s.toml:3:1: pin[0]: selects no vertex"},
        {sheet("[[pin]]\ngreatest = \"w\"\n"),
         "pin[0].greatest: is \"w\"; must be one of x, y, z, -x, -y, -z"},
        {sheet("[[pin]]\nedge = \"up\"\n"),
         "s.toml:4:8: pin[0].edge: is \"up\"; must be one of left, right, bottom, top"},
        {sheet("[[pin]]\nedge = \"top\"\ngreatest = \"y\"\n"), "pin[0]: give exactly one of"},
        {sheet("[[pin]]\nedge = \"top\"\nuntil = 0\n"),
         "s.toml:5:9: pin[0].until: is 0; must be greater than 0 s"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [1]\n"),
         "s.toml:5:9: pin[0].path[0]: is a whole number; must be { time, translate, rotate }"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0 }, { translate = [0, 1, 0] }]\n"),
         "s.toml:5:23: pin[0].path[1]: has no time [s]"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0, tranlate = [0, 1, 0] }]\n"),
         "s.toml:5:21: pin[0].path[0].tranlate: unknown key; did you mean \"translate\" [m]?"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 0, rotate = 90 }]\n"),
         "s.toml:5:30: pin[0].path[0].rotate: is a whole number; must be [x, y, z] [degree]"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = 1 }, { time = 1 }]\n"),
         "s.toml:5:8: pin[0].path: has times that do not increase"},
        {sheet("[[pin]]\nedge = \"top\"\npath = [{ time = -1 }]\n"),
         "pin[0].path: is -1; must be at least 0 s"},
        // seams
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\n"),
         "s.toml:3:1: seam[0]: has no second; give the vertices of both sides"},
        {sheet("[[seam]]\nfirst = \"left\"\n"),
         "s.toml:4:9: seam[0].first: is a string; must be a table such as { edge = \"left\" }"},
        {sheet("[[seam]]\nfirst = { egde = \"left\" }\n"),
         "s.toml:4:11: seam[0].first.egde: unknown key; did you mean \"edge\"?"},
        {sheet("[[seam]]\nfrist = { edge = \"left\" }\n"),
         "s.toml:4:1: seam[0].frist: unknown key; did you mean \"first\"?"},
        {sheet("[[seam]]\nfirst = { edge = \"left\", cloth = \"shed\" }\nsecond = { edge = \"left\" }\n"),
         "s.toml:4:34: seam[0].first.cloth: there is no cloth \"shed\""},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { edge = \"left\", cloth = 1 }\n"),
         "seam[0].second.cloth: is 1; the scene has 1 [[cloth]]"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { vertices = [] }\n"),
         "seam[0].second.vertices: is empty"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { vertices = [1, 2, 3] }\n"),
         "s.toml:5:10: seam[0].second: has 3 vertices, the first side 20; a seam sews one to one"},
        {sheet("[[seam]]\nfirst = {}\nsecond = { edge = \"left\" }\n"),
         "s.toml:4:9: seam[0].first: give exactly one of vertices, box, nearest, greatest, edge"},
        {sheet("[[seam]]\nfirst = { edge = \"left\" }\nsecond = { edge = \"right\" }\nclose_time = 0\n"),
         "s.toml:6:14: seam[0].close_time: is 0; must be greater than 0 s"},
        // air
        {sheet("[air]\nlift = 0.5\n"), "s.toml:4:8: air.lift: is 0.5; must be at most the drag, 0"},
        {sheet("[air]\ndensity = 0\n"), "air.density: is 0; must be greater than 0 kg/m³"},
        {sheet("[air]\nseed = -1\n"), "s.toml:4:8: air.seed: is -1; must be 0 … 4294967295"},
        {sheet("[air]\nseed = 0.5\n"), "air.seed: is a number; must be a whole number"},
        {sheet("[air]\nwinds = [1, 0, 0]\n"), "air.winds: unknown key; did you mean \"wind\" [m/s]?"},
        {sheet("[[air]]\n"), "air: is an array; must be a table, [air]"},
        // fabrics
        {sheet("fabric = \"coton\"\n"),
         "s.toml:3:10: cloth[0].fabric: there is no fabric \"coton\"; did you mean \"cotton\"? known: "
         "cotton, "
         "denim, jersey, "},
        {sheet("fabric = \"quite another\"\n"), "there is no fabric \"quite another\"; known: cotton, "},
        {sheet("fabric = { base = \"wol\" }\n"),
         "s.toml:3:19: cloth[0].fabric.base: there is no fabric \"wol\"; did you mean \"wool\"?"},
        {sheet("fabric = { base = 3 }\n"),
         "s.toml:3:19: cloth[0].fabric.base: is a whole number; must be a fabric's name"},
        {sheet("fabric = { bse = \"wool\" }\n"),
         "s.toml:3:12: cloth[0].fabric.bse: unknown key; did you mean \"base\"?"},
        {sheet("fabric = \"cotton\"\n"),
         "cloth[0].fabric.strain_limit: needs integrator = \"implicit_euler\""},
        {sheet("fabric = { base = \"denim\", poisson_ratio = 1.5, strain_limit = 0 }\n"),
         "cloth[0].fabric.poisson_ratio: is 1.5; must lie between -1 and 1"},
        {sheet("fabric = { base = \"cotton\", density = -0.2, strain_limit = 0 }\n"),
         "cloth[0].fabric.density: is -0.2; must be greater than 0 kg/m²"},
        {sheet("fabric = { base = \"cotton\", mu = 1, lambda = 1, young_modulus = 1, strain_limit = 0 }\n"),
         "cloth[0].fabric.young_modulus: stands beside mu and lambda"},
        {sheet("fabric.membrane = \"neo_hokean\"\n"),
         "s.toml:3:19: cloth[0].fabric.membrane: is \"neo_hokean\"; did you mean \"neo_hookean\"?"},
        {sheet("fabric.bending_model = \"plates\"\n"), "must be one of quadratic, hinges"},
        {sheet("fabric.young_weft = 1e5\n"),
         "s.toml:3:21: cloth[0].fabric.young_weft: needs membrane = \"st_venant_kirchhoff\""},
        {sheet("fabric = { strain_limit = 0.9 }\n[simulation]\nintegrator = \"implicit_euler\"\n"),
         "s.toml:3:27: cloth[0].fabric.strain_limit: is 0.9; must be above 1, a stretch such as 1.05"},
        {sheet("fabric.strain_limit = 1.05\n"),
         "cloth[0].fabric.strain_limit: needs integrator = \"implicit_euler\" or \"tr_bdf2\""},
        {sheet("fabric.yield_curvature = 100\n"),
         "cloth[0].fabric.yield_curvature: needs bending_model = \"hinges\""},
        {sheet("fabric.friction = -0.1\n"), "cloth[0].fabric.friction: is -0.1; must be at least 0"},
        {sheet("warp = [0, 0, 0]\n"), "s.toml:3:8: cloth[0].warp: is zero; must point along the rest shape"},
        {sheet("[simulation]\nretries = -1\n"), "simulation.retries: is -1; must be 0 … 20"},
        {sheet("[[drag]]\npath = [[0, 1, 1]]\n"), "s.toml:4:8: drag[0].path: needs at least two keys"},
        {sheet("[[drag]]\npath = [[1, 1, 1], [0.5, 1, 1]]\n"),
         "drag[0].path: has times that do not increase"},
        {sheet("[[drag]]\npath = [[0, 1, 1], [1, 1, 1]]\nviewport = [0, 1]\n"),
         "drag[0].viewport: is 0; must be greater than 0 pixel"},
        // meshes
        {sheet("mesh = \"none.obj\"\n"), "s.toml:3:8: cloth[0].mesh: "},
        {sheet("mesh = \"none.obj\"\nresolution = 3\n"),
         "s.toml:4:14: cloth[0].resolution: belongs to a grid, but the cloth has a mesh; give one of the "
         "two"},
        {sheet("pose = \"none.obj\"\n"), "s.toml:3:8: cloth[0].pose: "},
        {sheet("radius = 0.15\nresolution = 3\n"),
         "s.toml:4:14: cloth[0].resolution: belongs to a grid, but the cloth has a radius; give one of the "
         "two"},
        {sheet("rings = 4\n"), "s.toml:3:9: cloth[0].rings: belongs to a disc; give its radius too"},
        {sheet("radius = 0.15\nrings = 0\n"), "s.toml:4:9: cloth[0].rings: is 0; must be 1 … 1000"},
        {sheet("radius = -1\n"), "cloth[0].radius: is -1; must be greater than 0 m"},
        {sheet("radius = 0.15\nmesh = \"none.obj\"\n"),
         "s.toml:3:10: cloth[0].radius: belongs to a disc, but the cloth has a mesh; give one of the two"},
        {sheet("radius = 0.15\n[[pin]]\nedge = \"top\"\n"), "names a grid's edge; this cloth is no grid"},
    };
    for (const Case& c : cases) {
        INFO(c.text);
        const std::string message = refusal(c.text);
        CHECK_THAT(message, Contains(c.message));
        CHECK_THAT(message, Catch::StartsWith("s.toml:"));
    }
}

TEST_CASE("a mesh's fault is told with the scene's place and the mesh's line", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "quad.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n");
    spit(folder / "flat.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n");
    spit(folder / "twice.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 2 3 1\n");
    spit(folder / "good.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    spit(folder / "four.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 1\n");
    const auto told = [&](const std::string& keys) {
        return refusal_of([&] { parse_scene(sheet(keys), "s.toml", folder.path()); });
    };
    CHECK_THAT(told("mesh = \"none.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: ") && Contains("none.obj: there is no such file"));
    CHECK_THAT(told("mesh = \"quad.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: ") && Contains("quad.obj:5: face 0"));
    CHECK_THAT(told("mesh = \"flat.obj\"\n"),
               Contains("s.toml:3:8: cloth[0].mesh: triangle 0") && Contains("degenerate"));
    CHECK_THAT(told("mesh = \"twice.obj\"\n"), Contains("triangle 1") && Contains("repeats triangle 0"));
    CHECK_THAT(told("mesh = \".\"\n"), Contains("is a folder"));
    CHECK_THAT(told("mesh = \"good.obj\"\npose = \"four.obj\"\n"),
               Contains("s.toml:4:8: cloth[0].pose: has 4 vertices; the rest shape has 3"));
    CHECK_THAT(told("mesh = \"good.obj\"\n[[pin]]\nedge = \"top\"\n"),
               Contains("s.toml:5:8: pin[0].edge: names a grid's edge; this cloth is no grid"));
    CHECK(told("mesh = \"good.obj\"\n") == "");
}

// ---------------------------------------------------------------- overrides

TEST_CASE("overrides reach every kind of key", "[scene_file]") {
    const std::string text = sheet(
        "[[cloth]]\nname = \"b\"\n[simulation]\ntime_step = 0.01\n[[collider]]\n"
        "contact_offset = 0.1\n");
    const SceneFile f =
        parse(text, {"cloth.fabric.density=0.2", "cloth[1].resolution=[3, 4]", "cloth[1].diagonals=uniform",
                     "simulation.substeps=4", "camera.position=[0, 1, 3]", "output.size=640x360",
                     "collider[0].contact_radius = 0.4", "light.softness=0.5", "ground.height=-2",
                     "description=two words", "cloth.color=#336699", "expect.frames=[1]",
                     "cloth[1].fabric={mu = 2.0, lambda = 1.0}", "cloth.bump=1", "cloth.bump=0.25"});
    CHECK(f.scene.cloths[0].fabric.density == 0.2);
    CHECK(f.scene.cloths[1].grid.resolution == std::array<int, 2>{3, 4});
    CHECK(f.scene.cloths[1].grid.diagonals == Diagonals::uniform);
    CHECK(f.scene.simulation.substeps == 4);
    CHECK(!f.scene.simulation.time_step);
    CHECK(f.view.eye == render::Float3{0, 1, 3});
    CHECK(f.view.width == 640);
    CHECK(f.scene.colliders[0].contact_radius == 0.4);
    CHECK(f.scene.colliders[0].contact_offset == 0.0);
    CHECK(f.view.light.softness == 0.5f);
    CHECK(f.ground->height == -2.0f);
    CHECK(f.description == "two words");
    CHECK(f.scene.cloths[1].fabric.mu == 2.0);
    CHECK(f.scene.cloths[0].bump == 0.25);  // the last one counts
    CHECK(parse(text, {"simulation.time_step=0.02"}).scene.simulation.time_step == 0.02);
    // Young's modulus takes the place of mu and lambda, and the other way round.
    const std::string given = sheet("fabric = { mu = 2, lambda = 1 }\n");
    CHECK(!parse(given, {"cloth.fabric.young_modulus=3"}).scene.cloths[0].fabric.mu);
    CHECK(parse(sheet("fabric.young_modulus = 7\n"), {"cloth.fabric.mu=2", "cloth.fabric.lambda=1"})
              .scene.cloths[0]
              .fabric.lambda == 1.0);
}

TEST_CASE("an override's choice of vertices takes the place of the file's", "[scene_file]") {
    const std::string text = sheet(
        "[[pin]]\nnearest = [0, 0, 0]\n[[seam]]\nfirst = { edge = \"left\" }\nsecond = { greatest = \"x\" "
        "}\n");
    const SceneFile f = parse(text, {"pin.edge=top", "seam.second.edge=right", "seam.stiffness=5",
                                     "pin.path=[{ time = 1, translate = [0, 1, 0] }]"});
    CHECK(f.scene.pins[0].edge == "top");
    CHECK(!f.scene.pins[0].nearest);
    CHECK(f.scene.pins[0].path[0].translate == Vec3(0, 1, 0));
    CHECK(f.scene.seams[0].sides[1].edge == "right");
    CHECK(!f.scene.seams[0].sides[1].greatest);
    CHECK(f.scene.seams[0].stiffness == 5.0);
}

TEST_CASE("a fabric is given by name, or by a name and what differs", "[scene_file]") {
    const std::string implicit = "[simulation]\nintegrator = \"implicit_euler\"\n";
    const auto fabric = [&](const std::string& value, const Overrides& overrides = {}) {
        const SceneFile file = parse(sheet("fabric = " + value + "\n" + implicit), overrides);
        INFO(file.resolved);
        // The resolved scene holds the numbers, whatever becomes of the table.
        CHECK_THAT(file.resolved, !Contains("base"));
        check_same_fabric(parse(file.resolved).scene.cloths[0].fabric, file.scene.cloths[0].fabric);
        return file.scene.cloths[0].fabric;
    };
    for (const NamedFabric& named : named_fabrics()) {
        INFO(named.fabric.name);
        check_same_fabric(fabric("\"" + named.fabric.name + "\""), named.fabric);
    }
    const Fabric& cotton = find_fabric("cotton")->fabric;
    Fabric heavier = cotton;
    heavier.density = 0.2;
    check_same_fabric(fabric("{ density = 0.2, base = \"cotton\" }"), heavier);
    heavier.name = "canvas";
    check_same_fabric(fabric("{ base = \"cotton\", density = 0.2, name = \"canvas\" }"), heavier);
    // Overrides know both ways of writing.
    CHECK(fabric("\"cotton\"", {"cloth.fabric.density=0.3"}).density == 0.3);
    CHECK(fabric("\"cotton\"", {"cloth.fabric.density=0.3"}).bending == cotton.bending);
    CHECK(fabric("{ density = 0.2 }", {"cloth.fabric=silk"}).name == "silk");
    CHECK(fabric("{ base = \"cotton\", density = 0.2 }", {"cloth.fabric.base=silk"}).name == "silk");
    CHECK(fabric("{ base = \"cotton\", density = 0.2 }", {"cloth.fabric.base=silk"}).density == 0.2);
    CHECK_THAT(refusal(sheet("fabric = \"cotton\"\n" + implicit), {"cloth.fabric=silc"}),
               Catch::StartsWith("--set cloth.fabric=silc: cloth[0].fabric: there is no fabric"));
}

TEST_CASE("what changes a base leaves none of its values without a meaning", "[scene_file]") {
    const auto fabric = [](const std::string& keys) {
        return parse(sheet("fabric = { strain_limit = 0, " + keys + " }\n")).scene.cloths[0].fabric;
    };
    const Fabric plain = fabric("base = \"cotton\", membrane = \"neo_hookean\"");
    CHECK(!plain.young_weft);
    CHECK(!plain.shear_modulus);
    CHECK(plain.young_modulus == find_fabric("cotton")->fabric.young_modulus);
    CHECK(!fabric("base = \"cotton\", mu = 1, lambda = 1").young_weft);
    CHECK(!fabric("base = \"cotton\", bending = 1e-3").bending_bias);
    CHECK(fabric("base = \"cotton\", bending = 1e-3, bending_bias = 5e-4").bending_bias == 5e-4);
    CHECK(fabric("base = \"cotton\", friction = 0.1").bending_bias);
    CHECK(!fabric("base = \"paper\", bending_model = \"quadratic\"").yield_curvature);
    CHECK(fabric("base = \"paper\"").yield_curvature);
}

TEST_CASE("zero leaves out a strain limit or a yield", "[scene_file]") {
    const std::string text = sheet(
        "fabric = { strain_limit = 1.05, bending_model = \"hinges\", yield_curvature = 90 }\n"
        "[simulation]\nintegrator = \"tr_bdf2\"\n");
    CHECK(parse(text).scene.cloths[0].fabric.strain_limit == 1.05);
    CHECK_THAT(parse(text).resolved, Contains("strain_limit = 1.05"));
    const SceneFile f = parse(text, {"cloth.fabric.strain_limit=0", "cloth.fabric.yield_curvature=0"});
    CHECK(!f.scene.cloths[0].fabric.strain_limit);
    CHECK(!f.scene.cloths[0].fabric.yield_curvature);
    CHECK_THAT(f.resolved, Contains("strain_limit = 0.0"));
}

TEST_CASE("an override's mesh takes the grid's place", "[scene_file]") {
    const TemporaryFolder folder;
    spit(folder / "m.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    const std::string text = sheet("size = [2, 2]\nresolution = 9\ndiagonals = \"uniform\"\n");
    const SceneFile f = parse_scene(text, "s.toml", folder.path(), {"cloth.mesh=m.obj"});
    REQUIRE(f.scene.cloths[0].mesh);
    CHECK(f.scene.cloths[0].mesh->positions.rows() == 3);
    CHECK_THAT(f.resolved, Contains((folder / "m.obj").string()));
}

TEST_CASE("a refused override is named as it was given", "[scene_file]") {
    struct Case {
        std::string override, message;
    };
    const std::vector<Case> cases = {
        {"nonsense", "--set nonsense: must be KEY=VALUE"},
        {"=3", "--set =3: must be KEY=VALUE"},
        {"cloth.bump=", "--set cloth.bump=: cloth.bump: has no value"},
        {"cloth..bump=1", "a part of the key is empty"},
        {"cloth[x].bump=1", "an index is written [0], [1], …"},
        {"cloth[0.bump=1", "an index is written [0], [1], …"},
        {"cloth=1", "names a whole table; name one of its keys"},
        {"cloth.densty=1", "--set cloth.densty=1: cloth[0].densty: unknown key; known here: "},
        {"cloth.fabric.densty=1",
         "--set cloth.fabric.densty=1: cloth[0].fabric.densty: unknown key; did you mean \"density\" "
         "[kg/m²]?"},
        {"cloth.fabric={densty=1}",
         "--set cloth.fabric={densty=1}: cloth[0].fabric.densty: unknown key; did you mean"},
        {"wibble.x=1", "--set wibble.x=1: wibble: unknown key"},
        {"cloth[1].bump=1",
         "--set cloth[1].bump=1: cloth[1].bump: the scene has 1 [[cloth]], counted from 0"},
        {"collider.radius=1", "the scene has 0 [[collider]], counted from 0"},
        {"simulation[0].substeps=1", "\"simulation\" is no list of tables"},
        {"version.x=1", "\"version\" is no table"},
        {"cloth.bump=high", "--set cloth.bump=high: cloth[0].bump: is a string; must be a number [m]"},
        {"cloth.bump=1\ncloth.size = 3", "cloth[0].bump: is a string; must be a number [m]"},
        {"cloth.bump=nan", "--set cloth.bump=nan: cloth[0].bump: is not finite"},
        {"simulation.time_step=0",
         "--set simulation.time_step=0: simulation.time_step: is 0; must be greater than 0 s"},
        {"cloth.resolution=1",
         "--set cloth.resolution=1: cloth[0].resolution: is 1; must be 2 … 4096 vertices"},
        {"cloth.mesh=none.obj", "--set cloth.mesh=none.obj: cloth[0].mesh: "},
        {"pin.path=[{ time = 0, roatte = 1 }]", "the scene has 0 [[pin]], counted from 0"},
        {"air.drag=-1", "--set air.drag=-1: air.drag: is -1; must be at least 0"},
        {"cloth.name=\xff\xfe", "has a value that is not UTF-8 text"},
    };
    for (const Case& c : cases) {
        INFO(c.override);
        const std::string message = refusal(sheet(), {c.override});
        CHECK_THAT(message, Contains(c.message));
        CHECK_THAT(message, Catch::StartsWith("--set "));
    }
}

// ---------------------------------------------------------------- finding scenes

TEST_CASE("scenes are found by name and by path", "[scene_file]") {
    const TemporaryFolder assets;
    fs::create_directories(assets / "scenes");
    spit(assets / "scenes/mine.toml", "description = \"My own\"\n" + sheet());
    spit(assets / "scenes/drape_sphere.toml", "description = \"Mine comes first\"\n" + sheet());
    spit(assets / "scenes/broken.toml", "version = \n");
    setenv("CLOTH_ASSETS", assets.path().c_str(), 1);
    CHECK(load_scene("mine").description == "My own");
    CHECK(load_scene("drape_sphere").description == "Mine comes first");
    CHECK(load_scene("seed_sheet").name == "seed_sheet");
    CHECK(load_scene((assets / "scenes/mine.toml").string()).name == "mine");
    const auto told = [](const std::string& name) { return refusal_of([&] { load_scene(name); }); };
    CHECK_THAT(told("drape_spere"),
               Contains("unknown scene \"drape_spere\"; did you mean \"drape_sphere\"?") &&
                   Contains("known: ") && Contains("mine") && Contains("seed_kick"));
    CHECK_THAT(told("quite different"), Contains("unknown scene \"quite different\"; (known: "));
    CHECK_THAT(told("none.toml"), Contains("none.toml: there is no such scene file"));
    CHECK_THAT(told(assets.path().string()), Contains("is a folder; a scene is a .toml file"));
    CHECK_THAT(told("broken"), Contains("broken.toml:1:"));
    const auto list = list_scenes();
    CHECK(std::is_sorted(list.begin(), list.end()));
    const auto row = [&](const std::string& name, const std::string& description) {
        return std::count(list.begin(), list.end(), std::array<std::string, 2>{name, description}) == 1;
    };
    CHECK(row("mine", "My own"));
    CHECK(row("drape_sphere", "Mine comes first"));
    CHECK(row("broken", "(cannot be read)"));
    unsetenv("CLOTH_ASSETS");
    CHECK(load_scene("drape_sphere").description != "Mine comes first");
}

TEST_CASE("a relative mesh is looked for beside the scene", "[scene_file]") {
    const FullFolder place;
    const fs::path before = fs::current_path();
    fs::current_path(place.folder.path().parent_path());
    const std::string path = place.folder.path().filename().string() + "/full.toml";
    CHECK(load_scene(path).scene.cloths[1].mesh.has_value());
    // Else in the working folder.
    fs::current_path(place.folder.path());
    CHECK(parse_scene(sheet("mesh = \"rest.ply\"\n"), "s.toml", "/nonexistent")
              .scene.cloths[0]
              .mesh.has_value());
    fs::current_path(before);
}

TEST_CASE("the key reference names every key with unit and default", "[scene_file]") {
    const std::string text = key_reference();
    for (const char* part :
         {"[simulation]", "[[cloth]]",      "[[collider]]",      "[[pin]]",      "[[drag]]",    "[[event]]",
          "[camera]",     "[[light]]",      "[ground]",          "[background]", "[output]",    "[expect]",
          "[air]",        "[[seam]]",       "[seam.first]",      "strain_limit", "gust_length", "density",
          "[kg/m²]",      "contact_radius", "default [0.0, -9.8"}) {
        CHECK_THAT(text, Contains(part));
    }
}
