// Boxes that may meet, and the pairs within them.

#include <algorithm>
#include <random>

#include <catch2/catch.hpp>

#include "sim/contact/broad_phase.h"
#include "sim/scene/mesh.h"

using namespace cloth;

TEST_CASE("moving boxes that overlap at some time may meet, and a common way keeps them apart", "[collide]") {
    std::mt19937 random(11);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    auto any = [&] { return Vec3(uniform(random), uniform(random), uniform(random)); };
    int met = 0, apart = 0;
    for (int trial = 0; trial < 20000; ++trial) {
        std::array<std::array<Vec3, 2>, 4> points;  // start and end; two points a box
        std::array<MovingBox, 2> boxes;
        const Vec3 common = 20.0 * any();
        for (int i = 0; i < 4; ++i) {
            points[i] = {any(), any()};
            points[i][1] += common;
            boxes[i / 2].add(MovingBox(points[i][0], points[i][1], 0.0));
        }
        bool overlapped = false;
        for (int k = 0; k <= 50; ++k) {
            const double t = k / 50.0;
            std::array<Box, 2> now;
            for (int i = 0; i < 4; ++i) now[i / 2].add(Vec3((1.0 - t) * points[i][0] + t * points[i][1]));
            overlapped = overlapped || ((now[0].low.array() <= now[1].high.array()).all() &&
                                        (now[1].low.array() <= now[0].high.array()).all());
        }
        const bool may = may_meet(boxes[0], boxes[1]);
        REQUIRE((may || !overlapped));
        met += overlapped;
        apart += !may;
    }
    CHECK(met > 3000);
    CHECK(apart > 3000);
}

TEST_CASE("the broad phase lists exactly the pairs whose boxes may meet", "[collide]") {
    std::mt19937 random(5);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    ContactMesh mesh;
    Grid grid;
    grid.resolution = {9, 7};
    const MeshData sheet = make_grid(grid);
    std::vector<std::array<int, 3>> triangles;
    for (int t = 0; t < sheet.triangles.rows(); ++t) {
        triangles.push_back({sheet.triangles(t, 0), sheet.triangles(t, 1), sheet.triangles(t, 2)});
    }
    const int n = static_cast<int>(sheet.positions.rows());
    mesh.add_body({false, 0, 0.0}, n, triangles);
    mesh.add_body({false, 1, 0.0}, n, triangles);
    mesh.add_body({true, 0, 0.2}, 1, {});                      // a sphere
    mesh.add_body({true, 1, 0.1}, 2, {}, {{0, 1}});            // a capsule
    mesh.add_body({true, 2, 0.0}, 4, {{0, 1, 2}, {0, 2, 3}});  // a plate
    VecX x(3 * mesh.vertex_count());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        x.segment<3>(3 * v) = v < 2 * n ? Vec3(sheet.positions.row(v % n)) : Vec3(0.3, 0.2 * v, 0.1);
    }
    BroadPhase broad(mesh, x);
    for (int trial = 0; trial < 20; ++trial) {
        std::vector<MovingBox> boxes(mesh.vertex_count());
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            auto place = [&] {
                return Vec3(Vec3(x.segment<3>(3 * v)) +
                            0.2 * Vec3(uniform(random), uniform(random), uniform(random)));
            };
            const Vec3 start = place(), end = place();
            boxes[v] = MovingBox(start, end, 0.05);
        }
        std::vector<std::uint8_t> on(mesh.bodies.size(), 1);
        on[trial % on.size()] = trial % 3 != 0;
        auto box_of = [&](auto vertices) {
            MovingBox box;
            for (int v : vertices) box.add(boxes[v]);
            return box;
        };
        auto allowed = [&](int v, int w) {
            const int a = mesh.vertex_body[v], b = mesh.vertex_body[w];
            return on[a] && on[b] && !(mesh.bodies[a].collider && mesh.bodies[b].collider);
        };
        std::vector<PairCandidate> expected;
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            for (std::size_t f = 0; f < mesh.faces.size(); ++f) {
                const auto& face = mesh.faces[f];
                if (v == face[0] || v == face[1] || v == face[2] || !allowed(v, face[0])) continue;
                if (may_meet(boxes[v], box_of(face))) {
                    expected.push_back({PairKind::vertex_face, v, static_cast<int>(f)});
                }
            }
        }
        for (std::size_t e = 0; e < mesh.edges.size(); ++e) {
            for (std::size_t g = e + 1; g < mesh.edges.size(); ++g) {
                const auto &p = mesh.edges[e], &q = mesh.edges[g];
                if (p[0] == q[0] || p[0] == q[1] || p[1] == q[0] || p[1] == q[1] || !allowed(p[0], q[0])) {
                    continue;
                }
                if (may_meet(box_of(p), box_of(q))) {
                    expected.push_back({PairKind::edge_edge, static_cast<int>(e), static_cast<int>(g)});
                }
            }
        }
        std::sort(expected.begin(), expected.end());
        CHECK(expected.size() > 1000);
        auto found = broad.pairs(mesh, boxes, on);
        std::sort(found.begin(), found.end());
        CHECK(found == expected);
    }
}
