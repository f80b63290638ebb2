// Barrier contact: its derivatives, its guarantee, friction.

#include <random>

#include <catch2/catch.hpp>

#include "energy_battery.h"
#include "sim/barrier_contact.h"

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
    BarrierContact contact(two_triangles(0.01));
    const std::vector<Placement> none;
    for (const VecX& x : poses()) {
        contact.begin(x, x, 0.01, none, none, {});
        REQUIRE(contact.contact_count(x) > 0);
        check_energy(
            contact, 6, {x},
            {.length = 0.002, .force_scale = 0.1, .stiffness_scale = 1.0, .rigid_motion_free = true});
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
        BarrierContact contact(s);
        Placement turned;
        turned.translation = Vec3(0.001, 0, -0.002);
        for (const VecX& x : poses()) {
            VecX from = x;
            std::mt19937 random(11);
            std::normal_distribution<double> normal;
            for (double& v : from) v += 0.003 * normal(random);
            contact.begin(x, from, 0.01, {Placement(), Placement()}, {turned, turned}, {1, 1});
            contact.place(1.0);
            check_energy(
                contact, 6, {x},
                {.length = 0.003, .force_scale = 1.0, .stiffness_scale = 100.0, .rigid_motion_free = false});
        }
    }
}
