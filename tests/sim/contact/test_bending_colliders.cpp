// Colliders whose vertices move: nothing passes, and friction takes along.

#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <functional>
#include <memory>

#include "sim/scene/mesh.h"
#include "sim/simulation.h"
#include "support/overlaps.h"

using namespace cloth;

namespace {

/// A level plate of `size` metres, whose vertices go where `place` has them, `rate` frames a second.
ColliderDesc plate(double size, int resolution, int frames, double rate,
                   const std::function<Vec3(const Vec3& at, double time)>& place) {
    ColliderDesc c;
    c.shape = Shape::mesh;
    c.mesh = make_grid({.size = {size, size}, .resolution = {resolution, resolution}});
    for (auto p : c.mesh->positions.rowwise()) p = Eigen::RowVector3d(p(0), 0.0, -p(1));
    auto cache = std::make_shared<MeshCache>();
    for (int f = 0; f < frames; ++f) {
        cache->frames.push_back(c.mesh->positions);
        for (auto p : cache->frames.back().rowwise()) p = place(p.transpose(), f / rate).transpose();
        cache->times.push_back(f / rate);
    }
    c.cache = cache;
    return c;
}

/// A level sheet of 0.4 m at a height, above what is to come.
Scene sheet_above(double height) {
    Scene scene;
    ClothDesc cloth;
    cloth.grid = {.size = {0.4, 0.4}, .resolution = {13, 13}};
    cloth.transform.rotate = {-90.0, 0.0, 0.0};
    cloth.transform.translate = {0.0, height, 0.0};
    scene.cloths.push_back(cloth);
    scene.simulation.time_step = 1.0 / 60.0;
    return scene;
}

/// Height of the plate's triangles at (x, z); far below where it has none.
double height_at(const ContactPrimitive& mesh, const Vec3& p) {
    double height = -1e9;
    for (const auto& t : mesh.triangles) {
        const Vec3 &a = mesh.points[t[0]], &b = mesh.points[t[1]], &c = mesh.points[t[2]];
        Mat2 M;
        M << b.x() - a.x(), c.x() - a.x(), b.z() - a.z(), c.z() - a.z();
        const Vec2 w = M.inverse() * Vec2(p.x() - a.x(), p.z() - a.z());
        if (w.minCoeff() < 0.0 || w.sum() > 1.0) continue;
        height = std::max(height, (1.0 - w.sum()) * a.y() + w(0) * b.y() + w(1) * c.y());
    }
    return height;
}

Vec3 mean_velocity(const Simulation& simulation) {
    const VecX& v = simulation.state().velocities;
    return v.reshaped(3, v.size() / 3).rowwise().mean();
}

}  // namespace

TEST_CASE("a plate that bends and swings through at 12 m/s never passes through cloth", "[contact]") {
    // Within 0.1 s its middle, or one side, goes up by 1.2 m, and comes back: 0.2 m a step, 200 times the
    // cloth's thickness.
    for (const bool flap : {false, true}) {
        INFO(flap);
        Scene scene = sheet_above(0.05);
        scene.colliders.push_back(plate(1.6, 17, 25, 120.0, [&](const Vec3& at, double time) {
            const double swing = 1.2 * std::sin(std::min(time, 0.2) / 0.2 * 3.14159265358979);
            const double share = flap ? std::pow((at.x() + 0.8) / 1.6, 2.0)
                                      : std::exp(-6.0 * (at.x() * at.x() + at.z() * at.z()));
            return Vec3(at.x(), share * swing, at.z());
        }));
        Simulation simulation(scene);
        for (int frame = 1; frame <= 18; ++frame) {
            const FrameReport report = simulation.advance_frame();
            CHECK(report.converged);
            CHECK(testing::crossing_triangles(simulation) == 0);
            // Nor has all of it gone through at once: each vertex is above the plate, or beside it.
            const ColliderDesc& c = scene.colliders[0];
            const auto mesh = make_shape(c, placement_at(c, simulation.state().time))->primitive();
            const VecX& x = simulation.state().positions;
            int below = 0;
            for (Eigen::Index i = 0; i < x.size() / 3; ++i)
                below += x(3 * i + 1) < height_at(mesh, x.segment<3>(3 * i));
            CHECK(below == 0);
        }
    }
}

TEST_CASE("friction carries cloth along with a belt of moving vertices, and none does not", "[contact]") {
    for (const double friction : {0.6, 0.0}) {
        Scene scene = sheet_above(0.002);
        // Half a metre a second from the start: μ g brings the sheet there within 0.1 s.
        scene.colliders.push_back(plate(3.0, 4, 3, 1.0, [](const Vec3& at, double time) {
            return Vec3(at + Vec3(0.5 * time, 0.0, 0.0));
        }));
        scene.colliders[0].friction = friction;
        scene.cloths[0].fabric.friction = friction;
        Simulation simulation(scene);
        for (int frame = 0; frame < 30; ++frame) simulation.advance_frame();
        const Vec3 v = mean_velocity(simulation);
        // Friction is in full force above 1e-4 m/s; below it creeps by less than this.
        CHECK(v.x() == Approx(friction > 0.0 ? 0.5 : 0.0).margin(1e-3));
        CHECK(std::abs(v.z()) < 1e-3);
    }
}

TEST_CASE("a cache that moves as a path does carries cloth as the path does", "[contact]") {
    const auto run = [](const ColliderDesc& collider) {
        Scene scene = sheet_above(0.003);
        scene.simulation.newton_speed = 0.0;  // as near as the residual says
        scene.colliders.push_back(collider);
        Simulation simulation(scene);
        for (int frame = 0; frame < 20; ++frame) simulation.advance_frame();
        return simulation.state().positions;
    };
    const Vec3 way(0.2, 0.1, 0.05);
    const ColliderDesc by_cache =
        plate(1.0, 5, 2, 2.0, [&](const Vec3& at, double time) { return Vec3(at + time / 0.5 * way); });
    ColliderDesc by_path = by_cache;
    by_path.cache.reset();
    by_path.path = {{.time = 0.0}, {.time = 0.5, .translate = way}};
    // The same but for rounding, which contact and the solves' ends amplify; the way is 0.15 m.
    CHECK((run(by_cache) - run(by_path)).cwiseAbs().maxCoeff() < 1e-5);
}
