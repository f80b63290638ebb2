// Numbers per vertex of states whose answers are known by hand.

#include <catch2/catch.hpp>
#include <cmath>

#include "sim/fields/vertex_fields.h"
#include "sim/model.h"
#include "support/assignment_settings.h"

using namespace cloth;

namespace {

Scene one_sheet() {
    Scene scene{.simulation = testing::assignment_settings()};
    scene.cloths.resize(1);
    scene.cloths[0].grid.resolution = {7, 6};
    scene.cloths[0].grid.diagonals = Diagonals::uniform;
    scene.cloths[0].fabric = {.density = 0.2};
    return scene;
}

/// Maps each rest point by `f`.
template <class F>
VecX mapped(const Model& model, const F& f) {
    VecX q(3 * model.vertex_count());
    for (int i = 0; i < model.vertex_count(); ++i) q.segment<3>(3 * i) = f(Vec3(model.rest_positions.row(i)));
    return q;
}

void check_all(const VecX& values, double expected, double margin = 1e-12) {
    for (int i = 0; i < values.size(); ++i) CHECK(values(i) == Approx(expected).margin(margin));
}

}  // namespace

TEST_CASE("a pulled sheet shows its greater stretch, whichever way it is turned", "[vertex_fields]") {
    const Model model = build_model(one_sheet());
    const VertexFields fields(model);
    State state = start_state(model);
    check_all(fields.at(VertexField::stretch, state), 1.0);
    check_all(fields.at(VertexField::bending, state), 0.0);
    const Mat3 turn = Eigen::AngleAxisd(0.7, Vec3(1, 2, 3).normalized()).toRotationMatrix();
    state.positions =
        mapped(model, [&](const Vec3& X) { return Vec3(turn * Vec3(1.1 * X.x(), 0.9 * X.y(), 0)); });
    check_all(fields.at(VertexField::stretch, state), 1.1);
    check_all(fields.at(VertexField::bending, state), 0.0, 1e-9);
}

TEST_CASE("a sheet rolled to a cylinder has the curvature of its radius inside", "[vertex_fields]") {
    Scene scene = one_sheet();
    scene.cloths[0].grid.resolution = {61, 7};
    const Model model = build_model(scene);
    const VertexFields fields(model);
    State state = start_state(model);
    const double R = 0.4;
    state.positions = mapped(model, [&](const Vec3& X) {
        return Vec3(R * std::sin(X.x() / R), X.y(), R * (1 - std::cos(X.x() / R)));
    });
    const VecX curvature = fields.at(VertexField::bending, state);
    for (int j = 2; j < 5; ++j)
        for (int i = 3; i < 58; ++i) CHECK(curvature(61 * j + i) == Approx(1 / R).epsilon(2e-3));
}

TEST_CASE("kinetic energy per area is half the density times the square of the speed", "[vertex_fields]") {
    const Model model = build_model(one_sheet());
    State state = start_state(model);
    state.velocities = mapped(model, [](const Vec3&) { return Vec3(3, 0, 4); });
    check_all(VertexFields(model).at(VertexField::kinetic, state), 0.5 * 0.2 * 25);
}

TEST_CASE("the strain rate is that of lengths, and none in a rigid motion", "[vertex_fields]") {
    const Model model = build_model(one_sheet());
    const VertexFields fields(model);
    State state = start_state(model);
    state.positions = mapped(model, [](const Vec3& X) { return Vec3(1.2 * X.x(), X.y(), 0); });
    state.velocities = mapped(model, [](const Vec3& X) { return Vec3(0.3 * 1.2 * X.x(), -0.7 * X.y(), 0); });
    check_all(fields.at(VertexField::strain_rate, state), 0.7);
    const Vec3 spin(1, -2, 3);
    state.velocities = mapped(
        model, [&](const Vec3& X) { return Vec3(spin.cross(Vec3(1.2 * X.x(), X.y(), 0)) + Vec3(5, 5, 5)); });
    check_all(fields.at(VertexField::strain_rate, state), 0.0);
}

TEST_CASE("the gap is that to the nearest collider that is on", "[vertex_fields]") {
    Scene scene = one_sheet();
    ColliderDesc floor, ball;
    floor.name = "floor";
    floor.shape = Shape::plane;
    floor.center = Vec3(0, 0, -2);
    floor.normal = Vec3(0, 0, 2);
    ball.name = "ball";
    ball.center = Vec3(0, 0, 1.5);
    ball.radius = 0.5;
    scene.colliders = {floor, ball};
    const Model model = build_model(scene);
    const VertexFields fields(model);
    State state = start_state(model);
    const VecX both = fields.at(VertexField::gap, state);
    for (int i = 0; i < model.vertex_count(); ++i) {
        const Vec3 X = model.rest_positions.row(i);
        CHECK(both(i) == Approx((X - ball.center).norm() - 0.5));
    }
    state.collider_on = {1, 0};
    check_all(fields.at(VertexField::gap, state), 2.0);
    state.collider_on = {0, 0};
    CHECK(fields.at(VertexField::gap, state).array().isNaN().all());
}

TEST_CASE("the gap knows every shape, also on its way", "[vertex_fields]") {
    // Of the vertex in the middle of a sheet in z = 0, at the origin.
    const auto gap = [](const ColliderDesc& collider, double time = 0.0) {
        Scene scene = one_sheet();
        scene.cloths[0].grid.resolution = {5, 5};
        scene.colliders = {collider};
        scene.simulation.contact = ContactKind::barrier;
        scene.simulation.integrator = IntegratorKind::implicit_euler;
        const Model model = build_model(scene);
        State state = start_state(model);
        state.time = time;
        return VertexFields(model).at(VertexField::gap, state)(12);
    };
    ColliderDesc body;
    body.center = Vec3(0, 0, 2);
    body.shape = Shape::box;
    body.size = Vec3(0.2, 0.4, 1.0);
    CHECK(gap(body) == Approx(1.5));
    body.rotate = Vec3(90, 0, 0);  // its y points along z now
    CHECK(gap(body) == Approx(1.8));
    body.rotate = Vec3::Zero();
    body.center = Vec3(0, 0, 0.4);
    CHECK(gap(body) == Approx(-0.1));  // inside
    body.center = Vec3(0, 0, 2);
    body.shape = Shape::capsule;
    body.radius = 0.3;
    body.height = 1.0;
    CHECK(gap(body) == Approx(1.7));
    body.rotate = Vec3(90, 0, 0);
    CHECK(gap(body) == Approx(1.2));
    body.shape = Shape::cylinder;
    CHECK(gap(body) == Approx(1.5));
    body.rotate = Vec3::Zero();
    CHECK(gap(body) == Approx(1.7));
    body.path = {MotionKey{.time = 0.0}, MotionKey{.time = 1.0, .translate = Vec3(0, 0, -1)}};
    CHECK(gap(body, 1.0) == Approx(0.7));
    body.path.clear();
    body.shape = Shape::mesh;
    body.mesh.emplace();
    body.mesh->positions.resize(3, 3);
    body.mesh->positions << -1, -1, 0, 1, -1, 0, 0, 2, 0;
    body.mesh->triangles.resize(1, 3);
    body.mesh->triangles << 0, 1, 2;
    CHECK(gap(body) == Approx(2.0));
}

TEST_CASE("each field has one name", "[vertex_fields]") {
    for (const VertexFieldName& n : vertex_field_names()) CHECK(&name_of(n.field) == &n);
}
