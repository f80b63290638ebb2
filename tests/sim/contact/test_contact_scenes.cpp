// Barrier contact in random scenes and with degenerate geometry.

#include <random>

#include <catch2/catch.hpp>

#include "base/portable_math.h"
#include "sim/simulation.h"
#include "support/barrier_scene.h"
#include "support/overlaps.h"

using namespace cloth;
using namespace cloth::testing;

namespace {

/// Up to three sheets, one above the other, over up to three shapes that do not move into one another's way.
Scene random_scene(std::uint32_t seed) {
    std::mt19937 random(seed);
    // Of the generator's own bits: a library's distributions differ from the next one's.
    auto uniform = [&random](double low, double high) {
        return low + (high - low) * (static_cast<double>(random()) * 0x1p-32);
    };
    auto one_of = [&random](int count) { return static_cast<int>(random() % count); };
    auto direction = [&] { return Vec3(uniform(-1, 1), uniform(-1, 1), uniform(-1, 1)); };

    Scene scene = barrier_scene(6);
    scene.simulation.newton_iterations = 60;
    scene.simulation.retries = 5;
    scene.simulation.contact_activation = one_of(2) ? 1e-3 : 3e-3;
    const ClothDesc pattern = scene.cloths[0];
    scene.cloths.clear();
    const int sheets = 1 + one_of(3);
    for (int k = 0; k < sheets; ++k) {
        ClothDesc cloth = pattern;
        cloth.name = "sheet " + std::to_string(k);
        cloth.grid.resolution = {6 + one_of(5), 6 + one_of(5)};
        cloth.grid.size = {uniform(0.15, 0.35), uniform(0.15, 0.35)};
        cloth.grid.diagonals = one_of(2) ? Diagonals::uniform : Diagonals::alternating;
        cloth.transform.rotate = {90.0 + uniform(-15, 15), uniform(-180, 180), uniform(-15, 15)};
        cloth.transform.translate = {uniform(-0.05, 0.05), 0.3 + 0.25 * k, uniform(-0.05, 0.05)};
        cloth.velocity = {uniform(-1, 1), -uniform(0, one_of(4) == 0 ? 40.0 : 4.0), uniform(-1, 1)};
        cloth.contact_thickness = uniform(2e-4, 2e-3);
        cloth.fabric.friction = uniform(0.0, 0.8);
        cloth.fabric.density = uniform(0.05, 0.4);
        cloth.fabric.bending = std::pow(10.0, uniform(-6, -3));
        scene.cloths.push_back(cloth);
    }
    const int shapes = 1 + one_of(3);
    for (int k = 0; k < shapes; ++k) {
        ColliderDesc c;
        c.name = "shape " + std::to_string(k);
        c.shape = std::array{Shape::sphere,  Shape::plane,    Shape::box,
                             Shape::capsule, Shape::cylinder, Shape::mesh}[one_of(6)];
        c.center = {uniform(-0.1, 0.1), uniform(-0.05, 0.05), uniform(-0.1, 0.1)};
        c.radius = uniform(0.01, 0.08);
        c.height = uniform(0.02, 0.15);
        c.size = {uniform(0.005, 0.15), uniform(0.005, 0.15), uniform(0.005, 0.15)};
        c.friction = uniform(0.0, 0.8);
        c.contact_offset = one_of(2) ? 0.0 : uniform(0.0, 2e-3);
        if (c.shape == Shape::plane) {
            c.center.y() -= 0.1;
            c.normal = Vec3(uniform(-0.2, 0.2), 1.0, uniform(-0.2, 0.2));
        } else {
            if (c.shape != Shape::sphere) c.rotate = 180.0 * direction();
            if (one_of(3) == 0) c.spin = 200.0 * direction();
            if (one_of(3) == 0) c.path = {{0.0}, {0.15, 0.05 * direction(), Vec3::Zero()}};
        }
        if (c.shape == Shape::mesh) {  // triangles without order: open, crossing one another, needles
            MeshData mesh;
            const int count = 1 + one_of(8);
            mesh.positions.resize(3 * count, 3);
            mesh.triangles.resize(count, 3);
            for (int t = 0; t < count; ++t) {
                const Vec3 a = 0.1 * direction(), b = a + 0.1 * direction();
                mesh.positions.row(3 * t) = a;
                mesh.positions.row(3 * t + 1) = b;
                mesh.positions.row(3 * t + 2) =
                    one_of(4) == 0 ? Vec3(0.5 * (a + b) + 1e-5 * direction()) : Vec3(a + 0.1 * direction());
                mesh.triangles.row(t) << 3 * t, 3 * t + 1, 3 * t + 2;
            }
            c.mesh = mesh;
        }
        scene.colliders.push_back(c);
    }
    return scene;
}

}  // namespace

TEST_CASE("in a hundred random scenes nothing crosses and the work stays bounded", "[contact]") {
    int touched = 0, finished = 0;
    for (std::uint32_t seed = 1; seed <= 100; ++seed) {
        CAPTURE(seed);
        const Scene scene = random_scene(seed);
        Simulation simulation(scene, 1);
        const int attempts = 2 * (1 << scene.simulation.retries) - 1;
        bool touches = false, converged = true;
        for (int frame = 0; frame < 10 && converged; ++frame) {
            const FrameReport report = simulation.advance_frame();
            converged = report.converged;
            touches = touches || report.contacts > 0;
            REQUIRE(report.smallest_gap > 0.0);
            REQUIRE(report.iterations <= attempts * scene.simulation.newton_iterations);
            REQUIRE(report.placements <= attempts * 60);
            REQUIRE(crossing_triangles(simulation) == 0);
            REQUIRE(points_inside(simulation) == 0);
        }
        touched += touches;
        finished += converged;
        if (!converged) WARN("seed " << seed << " stopped before its end: not converged");
    }
    CHECK(touched >= 90);
    CHECK(finished >= 97);  // those that stop do so before anything crosses, and say so
}

namespace {

/// A flat mesh in y = 0 with its corners at the given places along x and z.
MeshData plate(const std::vector<double>& along_x, const std::vector<double>& along_z) {
    MeshData mesh;
    const int nx = static_cast<int>(along_x.size()), nz = static_cast<int>(along_z.size());
    mesh.positions.resize(nx * nz, 3);
    mesh.triangles.resize(2 * (nx - 1) * (nz - 1), 3);
    for (int j = 0; j < nz; ++j) {
        for (int i = 0; i < nx; ++i) mesh.positions.row(j * nx + i) << along_x[i], 0.0, along_z[j];
    }
    int t = 0;
    for (int j = 0; j + 1 < nz; ++j) {
        for (int i = 0; i + 1 < nx; ++i) {
            const int a = j * nx + i;
            mesh.triangles.row(t++) << a, a + nx, a + 1;
            mesh.triangles.row(t++) << a + 1, a + nx, a + nx + 1;
        }
    }
    return mesh;
}

std::vector<double> even(double half, int count) {
    std::vector<double> places;
    for (int i = 0; i < count; ++i) places.push_back(half * (2.0 * i / (count - 1) - 1.0));
    return places;
}

}  // namespace

TEST_CASE("bad geometry is met without a crossing", "[contact]") {
    Scene scene = barrier_scene(7);
    scene.cloths[0].grid.size = {0.2, 0.2};
    scene.cloths[0].transform.rotate = {-90, 0, 0};
    scene.cloths[0].transform.translate = {0.0, 0.03, 0.0};
    ColliderDesc c;
    c.shape = Shape::mesh;
    c.friction = 0.3;
    SECTION("a collider of two triangles of 20 m") {
        c.mesh = plate(even(10.0, 2), even(10.0, 2));
    }
    SECTION("a collider twenty times finer than the cloth") {
        c.mesh = plate(even(0.05, 60), even(0.05, 60));
    }
    SECTION("the cloth's edges right above the collider's") {
        c.mesh = plate(even(0.1, 7), even(0.1, 7));
    }
    SECTION("the cloth's rim right above a box's edges") {
        c.shape = Shape::box;
        c.size = {0.2, 0.02, 0.2};
    }
    SECTION("needles a hundred thousand times longer than wide") {
        c.mesh = plate({-0.1, -0.05, -0.05 + 1e-6, 0.03, 0.03 + 1e-6, 0.1}, even(0.1, 2));
    }
    SECTION("triangles of no area, and every corner three times over") {
        const MeshData whole = plate(even(0.06, 4), even(0.06, 4));
        const int count = static_cast<int>(whole.triangles.rows());
        MeshData soup;
        soup.positions.resize(3 * count + 3, 3);
        soup.triangles.resize(count + 1, 3);
        for (int t = 0; t < count; ++t) {
            for (int k = 0; k < 3; ++k) {
                soup.positions.row(3 * t + k) = whole.positions.row(whole.triangles(t, k));
            }
        }
        soup.positions.bottomRows(3).setConstant(0.01);
        for (int v = 0; v < 3 * count + 3; ++v) soup.triangles(v / 3, v % 3) = v;
        c.mesh = soup;
    }
    SECTION("a cloth of needle triangles") {
        c.shape = Shape::sphere;
        c.radius = 0.02;
        scene.cloths[0].mesh = plate({-0.1, -0.03, -0.03 + 1e-4, 0.02, 0.02 + 1e-4, 0.1}, even(0.1, 8));
        scene.cloths[0].transform.rotate.setZero();
    }
    scene.colliders.push_back(c);
    Simulation simulation(scene, 1);
    for (int frame = 0; frame < 12; ++frame) {
        const FrameReport report = simulation.advance_frame();
        CHECK(report.converged);
        REQUIRE(report.smallest_gap > 0.0);
        REQUIRE(crossing_triangles(simulation) == 0);
        REQUIRE(points_inside(simulation) == 0);
    }
}
