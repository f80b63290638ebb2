// Steps against closed forms, an independent literal stepper, and themselves.

#include <catch2/catch.hpp>

#include "base/portable_math.h"
#include "sim/assignment/assignment.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "sim/simulation.h"
#include "sim/stepping/total_energy.h"
#include "support/assignment_settings.h"
#include "support/free_sheet.h"

using namespace cloth;
using testing::free_sheet;
using testing::largest_distance;

namespace {

constexpr double seed_mu = 142857.14285714287, seed_lambda = 35714.285714285714;

/// The assignment's own set-up: 20 x 20, stiff, heavy gravity, the upper edge pinned.
Scene seed_scene() {
    Scene scene{.simulation = testing::assignment_settings()};
    scene.simulation.gravity = Vec3(0.0, -1800.8, 0.0);
    scene.simulation.frame_rate = 1000.0;
    scene.simulation.time_step = 0.001;
    ClothDesc cloth;
    cloth.grid.diagonals = Diagonals::uniform;
    cloth.fabric = {.density = 1.0, .thickness = 1.0, .mu = seed_mu, .lambda = seed_lambda};
    cloth.bump = 0.02;  // a smooth offset, so that rounding does not choose the side to buckle to
    scene.cloths.push_back(cloth);
    PinDesc pin;
    pin.greatest = "y";
    scene.pins.push_back(pin);
    ColliderDesc sphere;
    sphere.name = "sphere";
    sphere.center = Vec3(0.0, 0.0, 0.4);
    sphere.radius = 0.2;
    sphere.contact_radius = 0.22;
    sphere.friction = 0.0;
    sphere.enabled = false;
    scene.colliders.push_back(sphere);
    return scene;
}

/// The assignment's loop, word for word, from the literal functions alone.
struct LiteralStepper {
    explicit LiteralStepper(const Simulation& simulation)
        : F(simulation.model().triangles), n(simulation.model().vertex_count()) {
        const Model& model = simulation.model();
        const ClothDesc& cloth = model.scene.cloths[0];
        VecX areas(F.rows());
        for (int t = 0; t < F.rows(); ++t) {
            const Vec3 a = model.rest_positions.row(F(t, 0)), b = model.rest_positions.row(F(t, 1)),
                       c = model.rest_positions.row(F(t, 2));
            dphi.push_back(dphi_cloth_triangle_dX(a, b, c));
            areas(t) = 0.5 * (b - a).cross(c - a).norm();
        }
        volumes = cloth.fabric.thickness * areas;
        mu = *cloth.fabric.mu;
        lambda = *cloth.fabric.lambda;
        const SparseMatrix M_full = mass_matrix_mesh(n, F, cloth.fabric.density, areas);
        P = fixed_point_constraints(n, model.pinned);
        M = P * M_full * SparseMatrix(P.transpose());
        gravity = dV_cloth_gravity_dq(M_full, model.scene.simulation.gravity);
        const VecX q_all = simulation.state().positions;
        x0 = q_all - P.transpose() * (P * q_all);
        q = P * q_all;
        qdot = P * simulation.state().velocities;
    }
    VecX all(const VecX& reduced) const { return P.transpose() * reduced + x0; }
    void step(double dt, bool sphere_on) {
        SphereContacts contacts;
        if (sphere_on) contacts = collision_detection_cloth_sphere(all(q), Vec3(0.0, 0.0, 0.4), 0.22);
        const VecX q_old = q;
        linearly_implicit_euler(
            q, qdot, dt, M,
            [&](VecRef x) -> VecX {
                return P * (assemble_forces(all(x), dphi, F, volumes, mu, lambda) - gravity);
            },
            [&](VecRef x) -> SparseMatrix {
                return P * assemble_stiffness(all(x), dphi, F, volumes, mu, lambda) *
                       SparseMatrix(P.transpose());
            });
        VecX v = P.transpose() * qdot;
        velocity_filter_cloth_sphere(v, contacts);
        qdot = P * v;
        q = q_old + dt * qdot;
    }

    Triangles F;
    int n;
    std::vector<Mat3> dphi;
    VecX volumes, gravity, x0, q, qdot;
    double mu = 0, lambda = 0;
    SparseMatrix P, M;
};

Vec3 momentum(const Simulation& s) {
    VecX p;
    multiply(s.model().pattern, s.model().mass, s.state().velocities, p);
    return p.reshaped(3, p.size() / 3).rowwise().sum();
}

}  // namespace

TEST_CASE("an unpinned cloth falls like a point mass", "[physics]") {
    // Implicit Euler from rest: y_n = y_0 - g h² n(n+1)/2, exactly; only rounding remains.
    for (IntegratorKind kind : {IntegratorKind::linearly_implicit_euler, IntegratorKind::implicit_euler}) {
        Scene scene = free_sheet();
        scene.simulation.integrator = kind;
        // The assignment's eigenvalue fix would act as a slight drag.
        scene.simulation.hessian = LinearHessian::projected;
        scene.simulation.frame_rate = 100.0;
        scene.cloths[0].transform.rotate = Vec3(30, 40, 50);
        Simulation simulation(scene);
        const double start = simulation.state().positions.reshaped(3, 30).row(1).mean();
        for (int i = 0; i < 100; ++i) simulation.advance_frame();
        CHECK(simulation.state().positions.reshaped(3, 30).row(1).mean() ==
              Approx(start - 9.81 * 1e-4 * 5050).margin(1e-9));
        CHECK(simulation.state().time == 1.0);
        CHECK(simulation.advance_frame().largest_stretch == Approx(1.0).margin(1e-8));
    }
}

TEST_CASE("the seed sheet follows a literal stepper to 1e-9 m over 500 steps", "[physics]") {
    Simulation simulation(seed_scene());
    LiteralStepper literal(simulation);
    double worst = 0.0;
    for (int i = 0; i < 500; ++i) {
        literal.step(0.001, false);
        simulation.advance_frame();
        worst = std::max(worst, largest_distance(simulation.state().positions, literal.all(literal.q)));
    }
    CHECK(worst < 1e-9);
    CHECK(worst > 0.0);  // two routes: identical bits would mean that one compares a thing with itself
    CHECK(largest_distance(simulation.state().positions, start_state(simulation.model()).positions) > 0.01);
}

TEST_CASE("a kicked seed sheet follows a literal stepper to 1e-6 m through first contact", "[physics]") {
    Scene scene = seed_scene();
    scene.cloths[0].velocity = Vec3(0.0, 0.0, 30.0);
    scene.colliders[0].enabled = true;
    Simulation simulation(scene);
    LiteralStepper literal(simulation);
    int contacts = 0;
    for (int i = 0; i < 40; ++i) {
        literal.step(0.001, true);
        contacts = std::max(contacts, simulation.advance_frame().contacts);
        REQUIRE(largest_distance(simulation.state().positions, literal.all(literal.q)) < 1e-6);
    }
    CHECK(contacts > 10);
}

TEST_CASE("without gravity or pins both integrators keep momentum", "[physics]") {
    for (IntegratorKind kind : {IntegratorKind::linearly_implicit_euler, IntegratorKind::implicit_euler}) {
        for (LinearHessian hessian : {LinearHessian::assignment, LinearHessian::projected}) {
            Scene scene = free_sheet();
            scene.simulation.gravity.setZero();
            scene.simulation.integrator = kind;
            scene.simulation.hessian = hessian;
            scene.cloths[0].velocity = Vec3(0.1, -0.2, 0.3);
            Simulation simulation(scene);
            State state = simulation.state();
            for (int i = 0; i < state.positions.size(); ++i)
                state.positions(i) += 0.01 * ((i * 7919) % 13 - 6) / 6;
            simulation.restore(state);
            const Vec3 before = momentum(simulation);
            for (int i = 0; i < 50; ++i) simulation.advance_frame();
            // The assignment's eigenvalue fix adds 1e-3 N/m to an element's translations too; times dt² it
            // acts as a drag of the order 1e-6 on momentum.
            const double tolerance =
                kind == IntegratorKind::linearly_implicit_euler && hessian == LinearHessian::assignment
                    ? 1e-3
                    : 1e-12;
            CHECK((momentum(simulation) - before).norm() < tolerance);
            CHECK(before.norm() > 0.01);
        }
    }
}

TEST_CASE("implicit Euler reaches its stated residual and never gains energy", "[physics]") {
    Scene scene = seed_scene();
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.accuracy = Accuracy::reference;
    Simulation simulation(scene);
    for (int i = 0; i < 60; ++i) {
        const FrameReport report = simulation.advance_frame();
        REQUIRE(report.converged);
        CHECK(report.residual <= scene.simulation.stopping().tolerance);
        CHECK(report.iterations >= 1);
        CHECK(report.energy_after <= report.energy_before + 1e-9 * std::abs(report.energy_before) + 1e-12);
    }
}

TEST_CASE("a step that may not iterate enough says that it did not converge", "[physics]") {
    Scene scene = seed_scene();
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.newton_iterations = 1;
    scene.simulation.retries = 0;
    scene.cloths[0].velocity = Vec3(0.0, 0.0, 30.0);
    Simulation simulation(scene);
    const StepReport report = simulation.step();
    CHECK_FALSE(report.converged);
    CHECK(report.residual > scene.simulation.stopping().tolerance);
    CHECK(report.worst_vertex);
    CHECK(simulation.state().positions == start_state(simulation.model()).positions);
    CHECK(simulation.state().step == 0);
}

TEST_CASE("a step that does not converge is made in halves", "[physics]") {
    Scene scene = seed_scene();
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.newton_iterations = 4;
    scene.simulation.newton_tolerance = 1e-4;
    scene.cloths[0].velocity = Vec3(0.0, 0.0, 30.0);
    Simulation simulation(scene);
    int retries = 0;
    for (int i = 0; i < 10; ++i) {
        const FrameReport report = simulation.advance_frame();
        REQUIRE(report.converged);
        retries += report.retries;
        CHECK(simulation.state().time == Approx(1e-3 * (i + 1)));
    }
    CHECK(retries > 0);
}

TEST_CASE("a linearly implicit step is the first Newton iterate of an implicit one", "[physics]") {
    // Both solve (M + dt² H) dv = -dt ∇V when the velocity is 0; on a flat sheet at rest H needs no
    // projection.
    Scene scene = seed_scene();
    scene.simulation.hessian = LinearHessian::projected;
    scene.cloths[0].bump = 0.0;
    Simulation linear(scene);
    scene.simulation.integrator = IntegratorKind::implicit_euler;
    scene.simulation.newton_iterations = 1;
    scene.simulation.newton_tolerance = 0.5;
    Simulation newton(scene);
    linear.step();
    newton.step();
    CHECK(largest_distance(linear.state().positions, newton.state().positions) < 1e-14);
    CHECK(largest_distance(linear.state().positions, start_state(linear.model()).positions) > 1e-6);
}

TEST_CASE("pins hold their vertices to the last bit", "[physics]") {
    Simulation simulation(seed_scene());
    const VecX start = simulation.state().positions;
    REQUIRE(simulation.model().pinned.size() == 20);
    for (int i = 0; i < 20; ++i) simulation.advance_frame();
    for (int v : simulation.model().pinned) {
        CHECK(simulation.state().positions.segment<3>(3 * v) == start.segment<3>(3 * v));
    }
}

TEST_CASE("states are the same bits for any number of threads and run after run", "[determinism]") {
    for (IntegratorKind kind : {IntegratorKind::linearly_implicit_euler, IntegratorKind::implicit_euler,
                                IntegratorKind::tr_bdf2, IntegratorKind::implicit_midpoint}) {
        std::vector<VecX> ends;
        for (int threads : {1, 2, 1, 7}) {
            Scene scene = seed_scene();
            scene.simulation.integrator = kind;
            scene.colliders[0].enabled = true;
            scene.cloths[0].velocity = Vec3(0.0, 0.0, 30.0);
            Simulation simulation(scene, threads);
            for (int i = 0; i < 30; ++i) simulation.advance_frame();
            ends.push_back(simulation.state().positions);
        }
        for (const VecX& end : ends) CHECK(end == ends[0]);
    }
}

TEST_CASE("a restored state resumes the run exactly", "[physics]") {
    Scene scene = seed_scene();
    scene.events = {{.time = 0.012, .collider = 0}, {.time = 0.02, .toggle_integrator = true}};
    scene.cloths[0].velocity = Vec3(0.0, 0.0, 30.0);
    Simulation straight(scene);
    for (int i = 0; i < 15; ++i) straight.advance_frame();
    const State middle = straight.state();
    for (int i = 0; i < 15; ++i) straight.advance_frame();
    Simulation resumed(scene);
    resumed.restore(middle);
    for (int i = 0; i < 15; ++i) resumed.advance_frame();
    CHECK(resumed.state().positions == straight.state().positions);
    CHECK(resumed.state().integrator == IntegratorKind::implicit_euler);
    CHECK(resumed.state().collider_on[0] == 1);
    State wrong = middle;
    wrong.positions.conservativeResize(3);
    CHECK_THROWS_WITH(resumed.restore(wrong), Catch::Contains("has 1 vertices, the scene 400"));
}

TEST_CASE("events act from the first step that starts at their time", "[events]") {
    Scene scene = seed_scene();
    scene.events = {{.time = 0.005, .collider = 0, .action = Switch::on},
                    {.time = 0.003, .integrator = IntegratorKind::implicit_euler},
                    {.time = 0.007, .collider = 0}};
    Simulation simulation(scene);
    std::vector<int> on, newton;
    for (int i = 0; i < 9; ++i) {
        simulation.step();
        on.push_back(simulation.state().collider_on[0]);
        newton.push_back(simulation.state().integrator == IntegratorKind::implicit_euler);
    }
    CHECK(on == std::vector<int>{0, 0, 0, 0, 0, 1, 1, 0, 0});
    CHECK(newton == std::vector<int>{0, 0, 0, 1, 1, 1, 1, 1, 1});
}

TEST_CASE("a drag pulls what lies under the pointer and lets go", "[drag]") {
    Scene scene = seed_scene();
    scene.simulation.gravity.setZero();
    scene.cloths[0].bump = 0.0;
    DragDesc drag;
    drag.view(2, 3) = -2.0;  // eye at z = 2
    drag.projection << 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.02, -0.202, 0, 0, -1, 0;
    drag.viewport = Vec2(200, 200);
    // World (0, -0.5, 0) is pixel (100, 125); 25 pixels to the right are 0.5 m there.
    drag.path = {{0.002, {100, 124}}, {0.022, {125, 124}}, {0.3, {125, 124}}};
    drag.radius = 0.08;
    scene.drags.push_back(drag);
    Simulation simulation(scene);
    simulation.step();
    simulation.step();
    CHECK_FALSE(simulation.state().drags[0].pressed);
    simulation.step();
    REQUIRE(simulation.state().drags[0].pressed);
    REQUIRE(simulation.state().drags[0].vertices.size() > 1);
    const int picked = simulation.state().drags[0].vertices.front();
    CHECK(std::abs(simulation.model().rest_positions(picked, 0)) < 0.05);
    CHECK(simulation.model().rest_positions(picked, 1) < -0.4);
    for (int i = 0; i < 250; ++i) simulation.step();
    CHECK(simulation.state().positions(3 * picked) - simulation.model().rest_positions(picked, 0) > 0.2);
    for (int i = 0; i < 60; ++i) simulation.step();
    CHECK_FALSE(simulation.state().drags[0].pressed);
}

TEST_CASE("friction of the filter is bounded by the removed normal velocity", "[contact]") {
    Scene scene = free_sheet();
    scene.cloths[0].transform.rotate = Vec3(-90, 0, 0);
    scene.cloths[0].transform.translate = Vec3(0, -1e-4, 0);
    scene.cloths[0].velocity = Vec3(1.0, 0.0, 0.0);
    ColliderDesc floor;
    floor.shape = Shape::plane;
    floor.friction = 0.5;
    scene.colliders.push_back(floor);
    scene.simulation.hessian = LinearHessian::projected;
    Simulation simulation(scene);
    const int n = simulation.model().vertex_count();
    // On the floor each step presses with g dt, so friction takes 0.5 g dt off until the sheet stands.
    for (int i = 1; i <= 30; ++i) {
        simulation.step();
        const double speed = simulation.state().velocities.reshaped(3, n).row(0).mean();
        CHECK(speed == Approx(std::max(0.0, 1.0 - 0.5 * 9.81 * i / 60.0)).margin(1e-9));
        CHECK(simulation.state().positions.reshaped(3, n).row(1).minCoeff() > -1.1e-4);
    }
}

TEST_CASE("a state that is no longer finite is reported by vertex", "[physics]") {
    Simulation simulation(free_sheet());
    State state = simulation.state();
    state.velocities(3 * 17) = std::numeric_limits<double>::infinity();
    simulation.restore(state);
    const StepReport report = simulation.step();
    REQUIRE(report.non_finite_vertex);
    CHECK_FALSE(report.converged);
}

TEST_CASE("portable sine and cosine", "[math]") {
    for (double d = -800.0; d <= 800.0; d += 0.37) {
        CHECK(sin_degrees(d) == Approx(std::sin(d * M_PI / 180.0)).margin(4e-15));
        CHECK(cos_degrees(d) == Approx(std::cos(d * M_PI / 180.0)).margin(4e-15));
    }
    CHECK(sin_degrees(180.0) == 0.0);
    CHECK(cos_degrees(-90.0) == 0.0);
    CHECK(sin_degrees(90.0) == 1.0);
    CHECK(tan_degrees(45.0) == Approx(1.0).epsilon(1e-15));
    CHECK(rotation_matrix(Vec3(-90, 0, 0)) * Vec3(0, 0, 1) == Vec3(0, 1, 0));
}
