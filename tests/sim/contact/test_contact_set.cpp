// What was found decides how long an answer takes, not what it is; const objects may be shared by threads.

#include <cmath>
#include <random>
#include <thread>

#include <catch2/catch.hpp>

#include "sim/contact/barrier_contact.h"
#include "sim/contact/ccd.h"
#include "sim/scene/mesh.h"

using namespace cloth;

namespace {

/// Two sheets of 9 x 9 vertices, 1.6 mm apart, the lower one between a half-space and a ball.
struct Layers {
    ContactSystem system;
    VecX x;

    Layers() {
        Grid grid;
        grid.size = {0.2, 0.2};
        grid.resolution = {9, 9};
        const MeshData sheet = make_grid(grid);
        const int n = static_cast<int>(sheet.positions.rows());
        std::vector<std::array<int, 3>> triangles;
        for (Eigen::Index t = 0; t < sheet.triangles.rows(); ++t) {
            triangles.push_back({sheet.triangles(t, 0), sheet.triangles(t, 1), sheet.triangles(t, 2)});
        }
        system.mesh.add_body({false, 0, 5e-4}, n, triangles);
        system.mesh.add_body({false, 1, 5e-4}, n, triangles);
        system.mesh.add_body({true, 0, 0.01}, 1, {});
        system.planes.push_back({1, Vec3::Zero(), Vec3::UnitY(), 0.0, 0.5});
        system.cloth_vertices = 2 * n;
        system.friction = {0.3, 0.2, 0.4};
        system.mass.assign(2 * n, 1e-4);
        system.sliding_speed = 1e-3;
        system.acceleration = 20.0;
        system.rest.resize(3 * (2 * n + 1));
        x.resize(3 * 2 * n);
        for (int v = 0; v < 2 * n; ++v) {
            const Vec3 p = sheet.positions.row(v % n);
            system.rest.segment<3>(3 * v) = p;
            // The upper sheet lies over three quarters of the lower one.
            x.segment<3>(3 * v) =
                v < n ? Vec3(p.x(), 0.0012, p.y()) : Vec3(p.x() + 0.05, 0.0028, p.y() + 0.003);
        }
        system.rest.tail<3>() = Vec3(-0.075, 0.0122, 0.03);
    }
};

ContactSet& begin(ContactSet& set, const VecX& x) {
    Placement end;
    end.translation = Vec3(0.0, 1e-4, 1e-4);
    set.begin(x, x + VecX::Constant(x.size(), 1e-5), 0.01, {Placement(), Placement()}, {end, Placement()},
              {1, 1});
    return set;
}

struct Answer {
    double value = 0.0;
    VecX gradient, placing;
    BlockMatrix hessian;
    ExtraBlocks extra;

    bool operator==(const Answer& o) const {
        return value == o.value && gradient == o.gradient && placing == o.placing &&
               hessian.blocks == o.hessian.blocks && extra.where == o.extra.where &&
               extra.blocks == o.extra.blocks;
    }
};

Answer ask(const ContactSet& set, const BlockPattern& pattern, const VecX& x) {
    BarrierContact contact(set);
    contact.bind(pattern);
    Answer a;
    a.value = contact.value(x);
    a.gradient = a.placing = VecX::Zero(x.size());
    contact.add_gradient(x, a.gradient);
    contact.add_placing_gradient(x, a.placing);
    a.hessian.reset(pattern);
    contact.add_hessian(x, HessianKind::projected, HessianKind::exact, a.hessian, a.extra);
    return a;
}

/// Positions near x, shifted by `way` along the half-space.
std::vector<VecX> places(const VecX& x, int count, double way) {
    std::mt19937 random(4);
    std::vector<VecX> all;
    for (int k = 0; k < count; ++k) {
        all.push_back(x);
        for (double& v : all.back()) v += 1e-4 * (static_cast<double>(random()) * 0x1p-31 - 1.0);
        all.back().reshaped(3, x.size() / 3).row(0).array() += way;
    }
    return all;
}

}  // namespace

TEST_CASE("contact's energy is the same wherever contacts were looked for before", "[contact]") {
    const Layers layers;
    const BlockPattern pattern(layers.system.cloth_vertices, {});
    ContactSet set(layers.system);
    begin(set, layers.x);
    for (const double way : {0.0, 4e-3}) {  // within what the candidates found at first cover, and beyond
        for (const VecX& x : places(layers.x, 4, way)) {
            const Answer elsewhere = ask(set, pattern, x);
            ContactSet other(layers.system);
            begin(other, layers.x);
            other.find(x);
            REQUIRE(elsewhere.value > 0.0);
            REQUIRE(std::isfinite(elsewhere.value));
            CHECK(elsewhere == ask(other, pattern, x));
        }
    }
    CHECK(set.candidates().detections() == 1);
}

TEST_CASE("two threads may ask one contact at the same time", "[contact]") {
    const Layers layers;
    const BlockPattern pattern(layers.system.cloth_vertices, {});
    ContactSet changing(layers.system);
    begin(changing, layers.x);
    changing.find(layers.x);
    const ContactSet& set = changing;
    std::vector<VecX> at = places(layers.x, 6, 0.0);
    at.push_back(layers.x);                                           // where contacts were found
    for (const VecX& x : places(layers.x, 2, 4e-3)) at.push_back(x);  // where candidates are missing
    std::vector<Answer> expected;
    for (const VecX& x : at) expected.push_back(ask(set, pattern, x));
    std::array<std::vector<Answer>, 2> found;
    std::array<std::thread, 2> threads;
    for (int t = 0; t < 2; ++t) {
        threads[t] = std::thread([&, t] {
            for (std::size_t i = 0; i < at.size(); ++i) {
                found[t].push_back(ask(set, pattern, at[t == 0 ? i : at.size() - 1 - i]));
            }
        });
    }
    for (std::thread& thread : threads) thread.join();
    for (std::size_t i = 0; i < at.size(); ++i) {
        CHECK(found[0][i] == expected[i]);
        CHECK(found[1][at.size() - 1 - i] == expected[i]);
    }
}

TEST_CASE("of a pair that the pattern cannot couple, the energy's own Hessian has both sides' blocks alone",
          "[contact]") {
    const Layers layers;
    const BlockPattern diagonal(layers.system.cloth_vertices, {});
    ContactSet set(layers.system);
    begin(set, layers.x);
    BarrierContact contact(set);
    contact.bind(diagonal);
    BlockMatrix alone, whole;
    alone.reset(diagonal);
    whole.reset(diagonal);
    ExtraBlocks extra;
    contact.add_hessian(layers.x, HessianKind::projected, alone);
    contact.add_hessian(layers.x, HessianKind::projected, HessianKind::projected, whole, extra);
    CHECK(alone.blocks == whole.blocks);
    CHECK(!extra.where.empty());
    // With every pair of vertices in the pattern nothing is left over, and the blocks are the same.
    std::vector<std::array<int, 2>> pairs;
    contact.append_pairs(pairs);
    for (auto& [i, j] : pairs) {
        if (i > j) std::swap(i, j);
    }
    const BlockPattern full(layers.system.cloth_vertices, pairs);
    BlockMatrix H;
    H.reset(full);
    contact.bind(full);
    ExtraBlocks none;
    contact.add_hessian(layers.x, HessianKind::projected, HessianKind::projected, H, none);
    CHECK(none.where.empty());
    for (std::size_t b = 0; b < extra.where.size(); ++b) {
        const auto [i, j] = extra.where[b];
        CHECK((H.blocks[full.slot(i, j)] - extra.blocks[b]).norm() < 1e-12 * (1.0 + extra.blocks[b].norm()));
    }
}
