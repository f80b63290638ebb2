// What each shape draws, how far it is and what contact meets: three ways to the same body.

#include <random>

#include <catch2/catch.hpp>

#include "sim/geometry/collide.h"
#include "sim/shapes/shapes.h"

using namespace cloth;

namespace {

constexpr std::array every_shape{Shape::sphere,  Shape::plane,    Shape::box,
                                 Shape::capsule, Shape::cylinder, Shape::mesh};

class Random {
  public:
    explicit Random(std::uint32_t seed) : generator_(seed) {}
    double operator()() { return static_cast<double>(generator_()) * 0x1p-31 - 1.0; }  ///< in [-1, 1)
    Vec3 point() { return {(*this)(), (*this)(), (*this)()}; }

  private:
    std::mt19937 generator_;
};

MeshData soup(int count) {
    Random random(3);
    MeshData mesh;
    mesh.positions.resize(3 * count, 3);
    mesh.triangles.resize(count, 3);
    for (int t = 0; t < count; ++t) {
        const Vec3 a = 0.5 * random.point();
        for (int k = 0; k < 3; ++k) {
            mesh.positions.row(3 * t + k) = (a + 0.1 * random.point()).transpose();
            mesh.triangles(t, k) = 3 * t + k;
        }
    }
    return mesh;
}

/// Turned and shifted, with every size another; contact begins 0.01 outside.
ColliderDesc collider(Shape shape) {
    ColliderDesc c;
    c.shape = shape;
    c.center = {0.1, -0.2, 0.05};
    c.normal = {0.3, 2.0, -0.4};
    c.radius = 0.3;
    c.height = 0.7;
    c.size = {0.4, 0.9, 0.6};
    if (shape != Shape::plane && shape != Shape::sphere) c.rotate = {20.0, 40.0, -70.0};
    if (shape == Shape::mesh) c.mesh = soup(40);
    c.scale = 1.5;
    c.contact_offset = 0.01;
    return c;
}

/// Distance of a point from what contact meets [m].
double distance_from(const ContactPrimitive& primitive, const Vec3& p) {
    if (primitive.half_space) return primitive.half_space->normal.dot(p - primitive.half_space->point);
    double least = 1.0 / 0.0;
    const auto add = [&](int a, int b, int c) {
        const auto& x = primitive.points;
        least = std::min(least, nearest_vertex_face({p, x[a], x[b], x[c]}).distance_squared);
    };
    for (const auto& [a, b, c] : primitive.triangles) add(a, b, c);
    for (const auto& [a, b] : primitive.segments) add(a, b, b);
    if (primitive.triangles.empty() && primitive.segments.empty()) add(0, 0, 0);
    return std::sqrt(least);
}

}  // namespace

TEST_CASE("the normal of every shape is the gradient of its distance", "[shapes]") {
    for (const Shape kind : every_shape) {
        CAPTURE(static_cast<int>(kind));
        const auto shape = make_shape(collider(kind));
        Random random(7);
        int inside = 0;
        for (int i = 0; i < 200; ++i) {
            const Vec3 p = 0.8 * random.point();
            const SurfacePoint at = shape->distance(p);
            inside += at.distance < 0.0;
            REQUIRE(at.normal.norm() == Approx(1.0));
            constexpr double h = 1e-6;
            for (int a = 0; a < 3; ++a) {
                const Vec3 step = h * Vec3::Unit(a);
                const double slope =
                    (shape->distance(p + step).distance - shape->distance(p - step).distance) / (2.0 * h);
                REQUIRE(slope == Approx(at.normal(a)).margin(2e-5));
            }
        }
        CHECK((inside > 0) == (kind != Shape::mesh));
    }
}

TEST_CASE("the level surfaces of shapes of one curvature have the radius stated", "[shapes]") {
    for (const Shape kind : every_shape) {
        if (!has_one_curvature(kind)) continue;
        const auto shape = make_shape(collider(kind));
        Random random(8);
        for (int i = 0; i < 50; ++i) {
            const Vec3 p = 0.8 * random.point();
            const SurfacePoint at = shape->distance(p);
            const Mat3 expected = (Mat3::Identity() - at.normal * at.normal.transpose()) / at.level_radius;
            constexpr double h = 1e-6;
            for (int a = 0; a < 3; ++a) {
                const Vec3 step = h * Vec3::Unit(a);
                const Vec3 turn =
                    (shape->distance(p + step).normal - shape->distance(p - step).normal) / (2.0 * h);
                REQUIRE((turn - expected.col(a)).norm() < 1e-7 * (1.0 + expected.norm()));
            }
        }
    }
}

TEST_CASE("the drawn surface lies where the distance is zero and faces outwards", "[shapes]") {
    for (const Shape kind : every_shape) {
        CAPTURE(static_cast<int>(kind));
        const auto shape = make_shape(collider(kind));
        const Surface s = shape->surface();
        CHECK(s.endless == (kind == Shape::plane));
        REQUIRE(s.normals.rows() == s.positions.rows());
        REQUIRE(s.triangles.rows() > 0);
        const double margin = kind == Shape::cylinder ? 7e-4 * 0.3 : 1e-12;
        for (Eigen::Index t = 0; t < s.triangles.rows(); ++t) {
            std::array<Vec3, 3> p, n;
            for (int k = 0; k < 3; ++k) {
                p[k] = s.positions.row(s.triangles(t, k));
                n[k] = s.normals.row(s.triangles(t, k));
                REQUIRE(n[k].norm() == Approx(1.0));
                REQUIRE(std::abs(shape->distance(p[k]).distance) < margin);
            }
            const Vec3 facing = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
            for (int k = 0; k < 3; ++k) REQUIRE(facing.dot(n[k]) > 0.99);
            if (kind != Shape::mesh) {
                const Vec3 middle = (p[0] + p[1] + p[2]) / 3.0;
                REQUIRE(shape->distance(middle + 0.01 * facing).distance == Approx(0.01).margin(1e-3));
            }
        }
    }
}

TEST_CASE("contact begins its offset outside of every shape", "[shapes]") {
    for (const Shape kind : every_shape) {
        CAPTURE(static_cast<int>(kind));
        const auto shape = make_shape(collider(kind));
        const ContactPrimitive primitive = shape->primitive();
        Random random(9);
        for (int i = 0; i < 100; ++i) {
            const Vec3 p = 1.5 * random.point();
            const double distance = shape->distance(p).distance;
            if (distance < 0.0) continue;  // triangles and segments know no inside
            REQUIRE(distance_from(primitive, p) - primitive.radius ==
                    Approx(distance - 0.01).margin(kind == Shape::cylinder ? 1e-3 : 1e-12));
        }
    }
    ColliderDesc sphere = collider(Shape::sphere);
    sphere.contact_offset = 0.0;
    sphere.contact_radius = 0.35;
    CHECK(make_shape(sphere)->primitive().radius == 0.35);
}

TEST_CASE("the distance of a mesh is that of its nearest triangle, to the bit", "[shapes]") {
    ColliderDesc desc = collider(Shape::mesh);
    desc.mesh = soup(500);
    const auto shape = make_shape(desc);
    const ContactPrimitive primitive = shape->primitive();
    Random random(10);
    for (int i = 0; i < 300; ++i) {
        const Vec3 p = (i % 3 == 0 ? 3.0 : 0.8) * random.point();
        REQUIRE(shape->distance(p).distance == distance_from(primitive, p));
    }
    const Vec3 corner = primitive.points[5];
    CHECK(shape->distance(corner).distance < 1e-15);
}
