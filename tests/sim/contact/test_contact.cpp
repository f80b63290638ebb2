// Barrier contact: its derivatives, its guarantee, friction.

#include <random>

#include <catch2/catch.hpp>

#include "base/portable_math.h"
#include "sim/contact/barrier_contact.h"
#include "sim/contact/contact_system.h"
#include "sim/contact/overlap.h"
#include "sim/shapes/shapes.h"
#include "sim/simulation.h"
#include "support/barrier_scene.h"
#include "support/energy_battery.h"
#include "support/overlaps.h"

using namespace cloth;
using namespace cloth::testing;

namespace {

/// Two triangles of two cloths, and colliders if asked for; sizes of about 1, activation 0.2.
ContactSystem two_triangles(double radius) {
    ContactSystem s;
    s.mesh.add_body({false, 0, radius}, 3, {{0, 1, 2}});
    s.mesh.add_body({false, 1, radius}, 3, {{0, 1, 2}});
    s.cloth_vertices = 6;
    s.rest = VecX::Zero(18);
    s.rest << 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1;
    s.mass.assign(6, 0.5);
    s.friction = {0.0, 0.0};
    s.activation = 0.2;
    s.acceleration = 10.0;
    return s;
}

VecX positions(std::initializer_list<Vec3> points) {
    VecX x(3 * points.size());
    int i = 0;
    for (const Vec3& p : points) x.segment<3>(3 * i++) = p;
    return x;
}

/// A vertex above a face, beside an edge, beyond a corner; crossing edges; nearly parallel ones.
std::vector<VecX> poses() {
    const Vec3 a(0, 0, 0), b(1.1, 0.05, 0), c(0.1, 0, 1.0);
    return {positions({a, b, c, {0.3, 0.11, 0.25}, {0.4, 0.9, 0.3}, {0.1, 1.0, 0.5}}),
            positions({a, b, c, {0.4, 0.12, -0.06}, {0.5, 0.9, -0.3}, {0.1, 1.0, -0.5}}),
            positions({a, b, c, {-0.05, 0.1, -0.06}, {-0.4, 0.9, -0.3}, {-0.1, 1.0, -0.5}}),
            positions({a, b, c, {0.4, 0.13, -0.5}, {0.5, 0.11, 0.6}, {0.3, 1.0, 0.1}}),
            positions({a, b, c, {0.1, 0.12, -0.02}, {1.2, 0.16, 0.006}, {0.3, 1.0, -0.4}})};
}

}  // namespace

TEST_CASE("barrier contact passes the battery", "[contact][energy]") {
    ContactSet set(two_triangles(0.01));
    BarrierContact contact(set);
    const std::vector<Placement> none;
    for (const VecX& x : poses()) {
        set.begin(x, x, 0.01, none, none, {});
        REQUIRE(contact_count(set, x) > 0);
        check_energy(
            contact, 6, {x},
            {.length = 0.002, .force_scale = 0.1, .stiffness_scale = 1.0, .rigid_motion_free = true});
    }
}

TEST_CASE("what lies at one place at rest keeps its whole contact", "[contact]") {
    // Two triangles of one cloth cut from the same place of it: apart, or joined in a corner.
    const std::vector<Placement> none;
    for (const bool joined : {false, true}) {
        CAPTURE(joined);
        ContactSystem s = two_triangles(0.01);
        s.mesh = {};
        s.mesh.add_body({false, 0, 0.01}, 6, {{0, 1, 2}, {joined ? 0 : 3, 4, 5}});
        CHECK(s.mesh.vertex_piece ==
              (joined ? std::vector{0, 0, 0, 3, 0, 0} : std::vector{0, 0, 0, 3, 3, 3}));
        s.friction = {0.0};
        ContactSet set(s);
        const VecX x = positions({{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {0, 0.05, 0}, {1, 0.05, 0}, {0, 0.05, 1}});
        set.begin(x, x, 0.01, none, none, {});
        CHECK(contact_count(set, x) > 0);
        // Edges that meet at an angle end nearer than the planes.
        CHECK(smallest_gap(set, x) == Approx(0.05 - 0.02).epsilon(0.01));
    }
}

TEST_CASE("friction between cloths and with colliders passes the battery", "[contact][energy]") {
    for (double speed : {5.0, 0.04}) {  // at rest and sliding
        ContactSystem s = two_triangles(0.01);
        s.friction = {0.5, 0.3};
        s.mesh.add_body({true, 0, 0.3}, 1, {});
        s.friction.push_back(0.4);
        s.rest.conservativeResize(21);
        s.rest.tail<3>() = Vec3(0.3, -0.4, 0.3);
        s.planes.push_back({1, Vec3(0, -0.095, 0), Vec3::UnitY(), 0.0, 0.7});
        s.sliding_speed = speed;
        ContactSet set(s);
        BarrierContact contact(set);
        Placement turned;
        turned.translation = Vec3(0.001, 0, -0.002);
        for (const VecX& x : poses()) {
            VecX from = x;
            std::mt19937 random(11);
            std::normal_distribution<double> normal;
            for (double& v : from) v += 0.003 * normal(random);
            set.begin(x, from, 0.01, {Placement(), Placement()}, {turned, turned}, {1, 1});
            set.place(1.0);
            check_energy(
                contact, 6, {x},
                {.length = 0.003, .force_scale = 1.0, .stiffness_scale = 100.0, .rigid_motion_free = false});
        }
    }
}

// ---------------------------------------------------------------- whole steps

TEST_CASE("a box that is moved into a hanging sheet pushes it aside without crossing it", "[contact]") {
    Scene scene = barrier_scene(10);
    PinDesc pin;
    pin.greatest = "y";
    scene.pins.push_back(pin);
    ColliderDesc box;
    box.shape = Shape::box;
    box.size = {0.1, 0.1, 0.1};
    box.center = {0.0, 0.0, -0.15};
    box.path = {{0.0, Vec3::Zero(), Vec3::Zero()}, {0.25, Vec3(0, 0, 0.3), Vec3(0, 45, 0)}};
    scene.colliders.push_back(box);
    Simulation simulation(scene);
    for (int frame = 0; frame < 15; ++frame) {
        const FrameReport report = simulation.advance_frame();
        REQUIRE(report.converged);
        REQUIRE(report.smallest_gap > 0.0);
        REQUIRE(crossing_triangles(simulation) == 0);
    }
    // The sheet has been taken along: at rest it hung in z = 0.
    CHECK(simulation.state().positions.reshaped(3, 100).row(2).maxCoeff() > 0.1);
}

TEST_CASE("a sheet falls onto a turning sphere, a capsule and a cylinder without crossing itself or them",
          "[contact]") {
    using enum IntegratorKind;
    using Run = std::pair<Shape, IntegratorKind>;
    for (const auto& [shape, integrator] :
         {Run{Shape::sphere, implicit_euler}, Run{Shape::sphere, tr_bdf2},
          Run{Shape::capsule, implicit_euler}, Run{Shape::cylinder, tr_bdf2}}) {
        CAPTURE(static_cast<int>(shape), static_cast<int>(integrator));
        Scene scene = barrier_scene(12);
        scene.simulation.integrator = integrator;
        scene.cloths[0].transform.rotate = {90, 0, 0};
        scene.cloths[0].transform.translate = {0.02, 0.12, 0.01};
        ColliderDesc collider;
        collider.shape = shape;
        collider.radius = 0.08;
        collider.height = 0.1;
        collider.friction = 0.3;
        if (shape != Shape::sphere) collider.rotate = {0, 0, 90};
        if (shape == Shape::sphere) collider.spin = {0, 180, 0};
        scene.colliders.push_back(collider);
        Simulation simulation(scene);
        for (int frame = 0; frame < 20; ++frame) {
            REQUIRE(simulation.advance_frame().converged);
            const VecX& x = simulation.state().positions;
            for (int v = 0; v < x.size() / 3 && shape == Shape::sphere; ++v) {
                REQUIRE(x.segment<3>(3 * v).norm() > 0.0805);  // half of the sheet's thickness outside
            }
        }
        CHECK(crossing_triangles(simulation) == 0);
    }
}

TEST_CASE("two sheets that meet in free flight keep their momentum and do not cross", "[contact]") {
    Scene scene = barrier_scene(7);
    scene.simulation.gravity.setZero();
    scene.simulation.newton_tolerance = 1e-9;
    scene.simulation.newton_speed = 0.0;
    scene.cloths.push_back(scene.cloths[0]);
    scene.cloths[1].name = "other";
    scene.cloths[0].velocity = {0.1, 0.2, 3.0};
    scene.cloths[1].transform.translate = {0.03, 0.05, 0.04};
    scene.cloths[1].transform.rotate = {20, 0, 15};
    scene.cloths[1].transform.translate.z() = 0.12;
    Simulation simulation(scene);
    auto momentum = [&] {
        VecX p;
        multiply(simulation.model().pattern, simulation.model().mass, simulation.state().velocities, p);
        return Vec3(p.reshaped(3, p.size() / 3).rowwise().sum());
    };
    const Vec3 before = momentum();
    double least = 1.0;
    for (int frame = 0; frame < 8; ++frame) {
        const FrameReport report = simulation.advance_frame();
        REQUIRE(report.converged);
        least = std::min(least, report.smallest_gap);
        REQUIRE(crossing_triangles(simulation) == 0);
    }
    CHECK(least < 1e-3);
    // Pair forces add up to zero exactly; what is left is the residual that Newton stops at.
    CHECK((momentum() - before).norm() < 1e-6 * before.norm());
}

TEST_CASE("an impact changes the mean velocity as a full solve does", "[contact]") {
    // A stiff contact lets Newton's steps be small before the impact has been dealt out.
    Scene scene = barrier_scene(12);
    scene.cloths[0].transform.rotate = {90, 15, 3};
    scene.cloths[0].transform.translate = {0.0, 0.03, 0.0};
    scene.cloths[0].velocity = {0.3, -4.0, 0.0};
    ColliderDesc ball;
    ball.radius = 0.1;
    ball.center = {0.0, -0.08, 0.0};
    scene.colliders.push_back(ball);
    Scene full = scene;
    full.simulation.newton_speed = 0.0;
    full.simulation.newton_tolerance = 1e-8;
    Simulation simulation(scene), reference(full);
    auto mean_velocity = [](const Simulation& s) {
        return Vec3(s.state().velocities.reshaped(3, 144).rowwise().mean());
    };
    for (int frame = 0; frame < 6; ++frame) {
        CAPTURE(frame);
        REQUIRE(simulation.advance_frame().converged);
        REQUIRE(reference.advance_frame().converged);
        CHECK((mean_velocity(simulation) - mean_velocity(reference)).norm() < 0.01);
        simulation.restore(reference.state());
    }
}

TEST_CASE("on an incline a sheet sticks below the angle of friction and slides beyond it as a block",
          "[contact]") {
    // tan(20 degrees) = 0.36397; both coefficients equal, so that their geometric mean is mu.
    const double tangent = tan_degrees(20.0), g = 9.81;
    for (double ratio : {1.01, 0.99}) {
        Scene scene = barrier_scene(4);
        scene.simulation.sliding_speed.reset();  // as in a scene that sets nothing
        // Gravity is turned instead of the plane.
        scene.simulation.gravity = {g * sin_degrees(20.0), -g * cos_degrees(20.0), 0.0};
        scene.cloths[0].transform.rotate = {90, 0, 0};
        scene.cloths[0].transform.translate = {0.0, 0.0012, 0.0};
        scene.cloths[0].fabric.friction = ratio * tangent;
        ColliderDesc plane;
        plane.shape = Shape::plane;
        plane.friction = ratio * tangent;
        scene.colliders.push_back(plane);
        Simulation simulation(scene);
        auto where = [&] { return simulation.state().positions.reshaped(3, 16).row(0).mean(); };
        auto speed = [&] { return simulation.state().velocities.reshaped(3, 16).row(0).mean(); };
        // It has got some speed from landing while its friction was still growing.
        for (int frame = 0; frame < 60; ++frame) REQUIRE(simulation.advance_frame().converged);
        const double x0 = where(), v0 = speed();
        if (ratio > 1.0) {
            for (int frame = 0; frame < 600; ++frame) REQUIRE(simulation.advance_frame().converged);
            CHECK(where() - x0 < 1e-3);  // in 10 s, at less than the sliding speed
        } else {
            for (int frame = 0; frame < 60; ++frame) REQUIRE(simulation.advance_frame().converged);
            CHECK(speed() - v0 == Approx(0.01 * g * sin_degrees(20.0)).epsilon(0.01));
        }
    }
}

TEST_CASE("a start with overlaps is refused and the pairs named", "[contact]") {
    Scene scene = barrier_scene(5);
    ColliderDesc box;
    box.name = "block";
    box.shape = Shape::box;
    box.size = {0.1, 0.1, 0.1};
    box.center = {0.013, 0.021, 0.01};
    scene.colliders.push_back(box);
    Simulation simulation(scene);
    try {
        simulation.step();
        FAIL("not refused");
    } catch (const OverlapError& e) {
        const std::string text = e.what();
        CHECK(text.find("cloth cloth triangle") != std::string::npos);
        CHECK(text.find("crosses collider block triangle") != std::string::npos);
        CHECK_FALSE(e.cloth_triangles.empty());
    }
}

TEST_CASE("contact gives the same bits for any number of threads and after a resume", "[contact]") {
    Scene scene = barrier_scene(12);
    scene.cloths[0].transform.rotate = {80, 10, 0};
    scene.cloths[0].transform.translate = {0.0, 0.16, 0.0};
    ColliderDesc sphere;
    sphere.radius = 0.08;
    sphere.friction = 0.3;
    scene.colliders.push_back(sphere);
    Simulation one(scene, 1), many(scene, 2), resumed(scene, 2);
    for (int frame = 0; frame < 12; ++frame) {
        one.advance_frame();
        many.advance_frame();
        if (frame == 8) resumed.restore(many.state());
        if (frame > 8) resumed.advance_frame();
    }
    CHECK(one.state().positions == many.state().positions);
    CHECK(resumed.state().positions == many.state().positions);
}

TEST_CASE("a sheet shot at 200 m/s at a thin plate, a triangle and a needle does not pass", "[contact]") {
    for (int target = 0; target < 3; ++target) {
        Scene scene = barrier_scene(6);
        scene.simulation.newton_tolerance = 1e-2;
        scene.simulation.gravity.setZero();
        scene.cloths[0].velocity = {0, 0, -200.0};
        scene.cloths[0].transform.translate = {0.0, 0.0, 0.5};
        ColliderDesc collider;
        collider.shape = Shape::mesh;
        MeshData mesh;
        mesh.positions.resize(3, 3);
        mesh.triangles.resize(1, 3);
        mesh.triangles << 0, 1, 2;
        if (target == 1) {
            mesh.positions << -0.05, -0.04, 0.0, 0.06, -0.03, 0.0, 0.01, 0.07, 0.0;
        } else {
            mesh.positions << 0.011, 0.013, 0.1, 0.01, 0.01, -0.3, 0.0105, 0.012, -0.3;
        }
        collider.mesh = mesh;
        if (target == 0) {
            collider.shape = Shape::box;
            collider.size = {1.0, 1.0, 1e-4};
        }
        scene.colliders.push_back(collider);
        Simulation simulation(scene);
        // Whether or not every solve gets to its tolerance: nothing crosses, and the work is bounded.
        for (int frame = 0; frame < 3; ++frame) {
            simulation.advance_frame();
            REQUIRE(crossing_triangles(simulation) == 0);
        }
        if (target == 0) CHECK(simulation.state().positions.reshaped(3, 36).row(2).minCoeff() > 0.0);
    }
}
