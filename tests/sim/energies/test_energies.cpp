// Every energy through the battery; the membrane's states cover rest, stretch, compression and degeneration.

#include <catch2/catch.hpp>
#include <limits>
#include <random>

#include "base/portable_math.h"
#include "sim/contact/penalty.h"
#include "sim/energies/air.h"
#include "sim/energies/bending.h"
#include "sim/energies/drag.h"
#include "sim/energies/gravity.h"
#include "sim/energies/isotropic.h"
#include "sim/energies/membrane.h"
#include "sim/energies/seam.h"
#include "sim/energies/woven.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"
#include "support/energy_battery.h"

using namespace cloth;
using namespace cloth::testing;

namespace {

Grid patch() {
    return {.size = {0.2, 0.2}, .resolution = {3, 3}, .diagonals = Diagonals::alternating};
}

VecX flatten(const Points& p) {
    VecX x(3 * p.rows());
    for (int i = 0; i < p.rows(); ++i) x.segment<3>(3 * i) = p.row(i).transpose();
    return x;
}

/// Rest, near rest, stretched, compressed, random, and squeezed almost to a line.
std::vector<VecX> sheet_states(const VecX& rest) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    auto shaken = [&](const VecX& x, double size) {
        VecX y = x;
        for (double& v : y) v += size * normal(random);
        return y;
    };
    auto scaled = [&](double sx, double sy) {
        VecX y = rest;
        for (int i = 0; i < y.size(); i += 3) {
            y(i) *= sx;
            y(i + 1) *= sy;
        }
        return y;
    };
    return {shaken(rest, 1e-9),
            shaken(rest, 1e-4),
            shaken(scaled(1.2, 1.1), 1e-3),
            shaken(scaled(0.7, 0.8), 3e-3),
            shaken(rest, 0.02),
            shaken(scaled(1.1, 0.15), 1e-3)};
}

}  // namespace

struct SheetElements {
    MeshData mesh;
    std::vector<std::array<int, 3>> triangles;
    std::vector<TriangleRest> rest;
    std::vector<WovenRest> woven;
    VecX x;
};

SheetElements sheet_elements(const Mat3& C = Mat3::Identity()) {
    SheetElements s;
    s.mesh = make_grid(patch());
    for (int t = 0; t < s.mesh.triangles.rows(); ++t) {
        const auto v = s.mesh.triangles.row(t);
        const Vec3 a = s.mesh.positions.row(v(0)), b = s.mesh.positions.row(v(1)),
                   c = s.mesh.positions.row(v(2));
        s.triangles.push_back({v(0), v(1), v(2)});
        s.rest.push_back(make_triangle_rest(a, b, c, 1e-3, 4e5, 3e5));
        s.woven.push_back(make_woven_rest(a, b, c, Vec3(0.4, 1.0, 0.0), 1e-3, C));
    }
    s.x = flatten(s.mesh.positions);
    return s;
}

TEST_CASE("membrane energy passes the battery", "[energy]") {
    const SheetElements s = sheet_elements();
    MembraneEnergy energy(s.triangles, s.rest);
    check_energy(energy, 9, sheet_states(s.x),
                 {.length = 0.02, .force_scale = 40.0, .stiffness_scale = 400.0});

    CHECK(energy.value(s.x) < 1e-25);
    CHECK(largest_stretch(s.mesh.triangles, s.rest, s.x) == Approx(1.0).epsilon(1e-14));
    VecX stretched = s.x;
    for (int i = 0; i < s.x.size(); i += 3) stretched(i) *= 1.25;
    CHECK(largest_stretch(s.mesh.triangles, s.rest, stretched) == Approx(1.25).epsilon(1e-14));
    CHECK(energy.value(stretched) > 0.0);
}

TEST_CASE("neo-Hookean and strain limit pass the battery", "[energy]") {
    const SheetElements s = sheet_elements();
    IsotropicEnergy<NeoHookean> rubber("membrane", s.triangles, s.rest,
                                       std::vector<NeoHookean>(s.rest.size(), {4e5, 3e5}));
    check_energy(rubber, 9, sheet_states(s.x),
                 {.length = 0.01, .force_scale = 40.0, .stiffness_scale = 400.0});
    CHECK(rubber.value(s.x) < 1e-25);

    // A limit far enough for the differences to stay inside of it.
    IsotropicEnergy<StrainLimit> limit("strain limit", s.triangles, s.rest,
                                       std::vector<StrainLimit>(s.rest.size(), {1e6, 3.0}));
    std::vector<VecX> states = sheet_states(s.x);
    for (double stretch : {1.6, 2.2}) states.push_back(stretch * states[1]);
    VecX uneven = states[1];
    for (int i = 0; i < uneven.size(); i += 3) uneven(i) *= 2.3;
    states.push_back(uneven);
    check_energy(limit, 9, states, {.length = 0.002, .force_scale = 40.0, .stiffness_scale = 4000.0});
    CHECK(limit.value(1.99 * s.x) == 0.0);
    CHECK(limit.value(2.2 * s.x) > 0.0);
    CHECK(limit.value(3.001 * s.x) == std::numeric_limits<double>::infinity());
}

TEST_CASE("all membranes meet Hooke's law at small strain", "[energy]") {
    // Plane stress: uniaxial strain ε costs ½ (2μ + λ) ε², shear γ costs ½ μ γ².
    const double mu = 4e5, lambda = 3e5, eps = 1e-5;
    Mat3 C;
    C << 2 * mu + lambda, lambda, 0, lambda, 2 * mu + lambda, 0, 0, 0, mu;
    const SheetElements s = sheet_elements(C);
    MembraneEnergy corotational(s.triangles, s.rest);
    IsotropicEnergy<NeoHookean> rubber("", s.triangles, s.rest,
                                       std::vector<NeoHookean>(s.rest.size(), {mu, lambda}));
    WovenEnergy woven(s.triangles, s.woven);
    VecX pulled = s.x, sheared = s.x;
    for (int i = 0; i < s.x.size(); i += 3) {
        pulled(i) *= 1.0 + eps;
        sheared(i) += eps * s.x(i + 1);
    }
    const double volume = 0.2 * 0.2 * 1e-3;
    for (const Energy* energy : std::initializer_list<const Energy*>{&corotational, &rubber, &woven}) {
        CHECK(energy->value(pulled) == Approx(0.5 * (2 * mu + lambda) * eps * eps * volume).epsilon(1e-4));
        CHECK(energy->value(sheared) == Approx(0.5 * mu * eps * eps * volume).epsilon(1e-4));
    }
}

TEST_CASE("a woven sheet passes the battery and pulls as its warp and weft say", "[energy]") {
    const Mat3 C = woven_stiffness(2e6, 5e5, 0.3, 1e5);
    const SheetElements s = sheet_elements(C);
    WovenEnergy energy(s.triangles, s.woven);
    check_energy(energy, 9, sheet_states(s.x),
                 {.length = 0.02, .force_scale = 40.0, .stiffness_scale = 4000.0});
    CHECK(energy.value(s.x) < 1e-25);

    // Stress σ along the warp: strains σ/E_warp and -ν σ/E_warp; along the weft σ/E_weft.
    const Vec3 along_warp = C.inverse() * Vec3(1, 0, 0), along_weft = C.inverse() * Vec3(0, 1, 0);
    CHECK(along_warp(0) == Approx(1 / 2e6));
    CHECK(along_warp(1) == Approx(-0.3 / 2e6));
    CHECK(along_weft(1) == Approx(1 / 5e5));
    CHECK(along_weft(0) == Approx(along_warp(1)));  // the matrix is symmetric

    const WovenRest rest =
        make_woven_rest(Vec3(0, 0, 0), Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3::UnitY(), 1.0, C);
    Vec9 pulled;
    pulled << 0, 0, 0, 1, 0, 0, 0, 1.01, 0;  // along y, the warp
    CHECK(green_strain(rest, pulled)(0) == Approx(0.5 * (1.01 * 1.01 - 1)));
    CHECK(std::abs(green_strain(rest, pulled)(1)) < 1e-15);
}

TEST_CASE("gravity passes the battery", "[energy]") {
    VecX masses(3);
    masses << 0.1, 0.2, 0.3;
    GravityEnergy energy(masses, Vec3(0.5, -9.81, 0.0));
    VecX x(9);
    x << 1, 2, 3, 4, 5, 6, 7, 8, 9;
    check_energy(energy, 3, {x}, {.length = 1.0, .curved = false, .rigid_motion_free = false});
    // V = -Σ m g·x
    CHECK(energy.value(x) == Approx(-(0.1 * (0.5 - 19.62) + 0.2 * (2.0 - 49.05) + 0.3 * (3.5 - 78.48))));
}

TEST_CASE("drag springs pass the battery", "[energy]") {
    DragDesc drag;
    drag.path = {{0.0, {640, 360}}, {1.0, {740, 300}}};
    drag.stiffness = 50.0;
    drag.projection << 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, -1.02, -0.202, 0, 0, -1, 0;  // near 0.1, far 10
    drag.view(2, 3) = -3.0;
    DragState state;
    state.pressed = true;
    state.vertices = {1};
    state.anchors = {Vec3(0.1, 0.2, 0.0)};
    state.grabbed = Vec3(0.1, 0.2, 0.0);
    DragEnergy energy({drag}, {state}, 0.5);
    VecX x(6);
    x << 1, 2, 3, 0.2, 0.1, 0.3;
    check_energy(energy, 2, {x}, {.length = 1.0, .rigid_motion_free = false});
    CHECK(energy.value(x) > 0.0);
}

TEST_CASE("bending energy passes the battery", "[energy]") {
    const MeshData mesh = make_grid(patch());
    const auto patches = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3(1.0, 0.3, 0.0));
    const Mat3 D = bending_rigidity(2e-5, 1e-5, 1.2e-5);
    BendingEnergy energy(patches, std::vector<Mat3>(patches.size(), D));
    const VecX x = flatten(mesh.positions);
    check_energy(energy, 9, sheet_states(x), {.length = 0.02, .force_scale = 1e-4, .stiffness_scale = 1e-2});
    CHECK(energy.value(x) < 1e-27);  // flat at rest, whatever the in-plane stretch
    const VecX stretched = 1.3 * x;
    CHECK(energy.value(stretched) < 1e-27);
}

TEST_CASE("hinges pass the battery, flat and curved at rest", "[energy]") {
    MeshData mesh = make_grid(patch());
    const VecX flat = flatten(mesh.positions);
    for (bool curved : {false, true}) {
        if (curved) {
            for (int i = 0; i < 9; ++i)
                mesh.positions(i, 2) = 0.05 * std::sin(20.0 * mesh.positions(i, 0) + i);
        }
        const auto patches = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitY());
        HingeEnergy energy(patches, std::vector<Mat3>(patches.size(), bending_rigidity(2e-5, 1e-5, 1.2e-5)),
                           std::vector<double>(patches.size(), 0.0));
        // No state that is squeezed to a line: there the angles have no derivatives.
        std::vector<VecX> states = sheet_states(flat);
        states.pop_back();
        check_energy(
            energy, 9, states,
            {.length = 2e-3, .force_scale = 1e-4, .stiffness_scale = 1e-2, .projection_adds = false});
        CHECK(energy.value(flatten(mesh.positions)) < 1e-30);
        CHECK(energy.value(states[3]) > 1e-8);
    }
}

TEST_CASE("a fold is twice the tangent of half its angle, with the sign of its side", "[energy]") {
    const Vec3 x0(0, 0, 0), x1(1, 0, 0), x2(0.3, 2, 0);
    for (double degrees : {-150.0, -60.0, -1e-3, 0.0, 45.0, 90.0, 170.0}) {
        const Vec3 x3(0.7, -1.5 * cos_degrees(degrees), 1.5 * sin_degrees(degrees));
        CHECK(hinge_fold(x0, x1, x2, x3) == Approx(2.0 * tan_degrees(degrees / 2)).margin(1e-15));
    }
}

TEST_CASE("folds past the yield stay as creases", "[energy]") {
    const MeshData mesh = make_grid({.size = {0.2, 0.2}, .resolution = {3, 3}});
    const auto patches = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitY());
    const double yield = 5.0, D = 1e-5;
    HingeEnergy energy(patches, std::vector<Mat3>(patches.size(), bending_rigidity(D, D, D)),
                       std::vector<double>(patches.size(), yield));
    State state;
    state.positions = flatten(mesh.positions);
    state.rest_folds = HingeEnergy::rest_folds(patches);
    for (int i = 0; i < 9; ++i) {  // folded upwards about the middle line by 2·atan(0.1/0.1) = 90 degrees
        state.positions(3 * i + 2) = std::abs(state.positions(3 * i));
    }
    energy.begin({{{1.0, state.positions}}, 1.0, 0.0, state});
    const double elastic = energy.value(state.positions);
    energy.finish(state);
    energy.begin({{{1.0, state.positions}}, 1.0, 0.0, state});
    CHECK(state.rest_folds.cwiseAbs().maxCoeff() == Approx(2.0 - yield * 0.1));
    CHECK(energy.value(state.positions) < 0.1 * elastic);
    // What is left is the yield curvature over the eight triangles beside the fold, of 0.005 m² each.
    const VecX once = state.rest_folds;
    energy.finish(state);
    CHECK((state.rest_folds - once).cwiseAbs().maxCoeff() < 1e-12);  // creasing again changes nothing
}

TEST_CASE("a sheet rolled in any direction has the energy of a plate, ½ D κ² per area", "[energy]") {
    // The whole sheet, rim included. Diagonals in one direction are exact but for O(h²) at the rim and O(h²)
    // of the roll; with alternating ones the error is the twist's share, up to a quarter of 2 H at 45
    // degrees.
    const double radius = 0.5, warp = 3e-5, weft = 2e-5, bias = 1.5e-5;
    for (double degrees : {0.0, 30.0, 45.0, 90.0, 135.0}) {
        for (Diagonals diagonals : {Diagonals::uniform, Diagonals::mirrored}) {
            CAPTURE(degrees, diagonals == Diagonals::uniform);
            const MeshData mesh =
                make_grid({.size = {0.4, 0.4}, .resolution = {81, 81}, .diagonals = diagonals});
            const auto all = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitX());
            std::vector<BendingPatch> inner;
            double area = 0.0;
            for (const BendingPatch& p : all) {
                if (mesh.positions.row(p.vertices[0]).cwiseAbs().maxCoeff() > 0.15) continue;
                inner.push_back(p);
                area += p.area;
            }
            VecX x = flatten(mesh.positions);
            const double c = cos_degrees(degrees), s = sin_degrees(degrees);
            for (int i = 0; i < x.size(); i += 3) {
                const double u = c * x(i) + s * x(i + 1), v = -s * x(i) + c * x(i + 1);
                const double rolled = radius * std::sin(u / radius);
                x(i) = c * rolled - s * v;
                x(i + 1) = s * rolled + c * v;
                x(i + 2) = radius * (1.0 - std::cos(u / radius));
            }
            // D(φ) = D_warp c⁴ + D_weft s⁴ + 2 H c² s², with D(45°) = bias.
            const double H = 2.0 * bias - 0.5 * (warp + weft);
            const double D = warp * c * c * c * c + weft * s * s * s * s + 2.0 * H * c * c * s * s;
            const Mat3 rigidity = bending_rigidity(warp, weft, bias);
            BendingEnergy quadratic(inner, std::vector<Mat3>(inner.size(), rigidity));
            HingeEnergy hinges(inner, std::vector<Mat3>(inner.size(), rigidity),
                               std::vector<double>(inner.size(), 0.0));
            const double expected = 0.5 * D / (radius * radius) * area;
            CHECK(quadratic.value(x) == Approx(expected).epsilon(1e-3));
            CHECK(hinges.value(x) == Approx(expected).epsilon(1e-3));
        }
    }
}

TEST_CASE("a state of constant bending moment is in balance on any mesh", "[energy]") {
    // The patch test: forces on inner vertices away from the rim vanish when the curvature is the same in
    // every triangle. On the grid with alternating diagonals a quadratic surface does not have that
    // curvature; a sheet rolled along the grid does.
    for (Diagonals diagonals : {Diagonals::uniform, Diagonals::alternating}) {
        const MeshData mesh = make_grid({.size = {0.8, 0.8}, .resolution = {9, 9}, .diagonals = diagonals});
        const auto patches = make_bending_patches(rest_corners({}, mesh), mesh.triangles, Vec3::UnitX());
        BendingEnergy energy(patches, std::vector<Mat3>(patches.size(), bending_rigidity(1.0, 1.0, 1.0)));
        VecX x = flatten(mesh.positions);
        for (int i = 0; i < x.size(); i += 3) x(i + 2) = 0.5 * x(i) * x(i);
        VecX g = VecX::Zero(x.size());
        energy.add_gradient(x, g);
        double inner = 0.0, rim = 0.0;
        for (int j = 0; j < 9; ++j) {
            for (int i = 0; i < 9; ++i) {
                // The moment acts on the ends x = ±0.4; the sides are free.
                double& place = i >= 2 && i <= 6 ? inner : rim;
                place = std::max(place, g.segment<3>(3 * (9 * j + i)).norm());
            }
        }
        CHECK(rim > 0.1);
        CHECK(inner < 1e-12);
    }
}

TEST_CASE("viscosity, air and seams pass the battery", "[energy]") {
    const Mat3 C = 0.01 * woven_stiffness(2e6, 5e5, 0.3, 1e5);
    const SheetElements s = sheet_elements(C);
    const std::vector<VecX> states = sheet_states(s.x);
    State start;
    start.positions = states[4];
    start.velocities = VecX::LinSpaced(s.x.size(), -1.0, 2.0);
    const Stage stage{{{1.0, start.positions}}, 0.02, 0.3, start};

    MembraneViscosity membrane(s.triangles, s.woven);
    membrane.begin(stage);
    check_energy(membrane, 9, states, {.length = 0.02, .force_scale = 40.0, .stiffness_scale = 4000.0});
    CHECK(membrane.value(start.positions) == 0.0);
    CHECK(membrane.value(s.x) > 0.0);

    const auto patches = make_bending_patches(rest_corners({}, s.mesh), s.mesh.triangles, Vec3::UnitY());
    BendingViscosity bending(patches, std::vector<Mat3>(patches.size(), 1e-7 * Mat3::Identity()));
    bending.begin(stage);
    check_energy(bending, 9, states,
                 {.length = 0.02, .force_scale = 1e-4, .stiffness_scale = 1e-2, .rigid_motion_free = false});
    CHECK(bending.value(start.positions) == 0.0);
    CHECK(bending.value(s.x) > 0.0);

    AirEnergy air(s.mesh.triangles,
                  {.drag = 1.2, .lift = 0.9, .wind = {3.0, 1.0, -2.0}, .gusts = 1.0, .gust_length = 0.5});
    air.begin(stage);
    check_energy(air, 9, states,
                 {.length = 0.02, .force_scale = 0.1, .stiffness_scale = 1.0, .rigid_motion_free = false});

    SeamEnergy seam({{0, 8, 50.0, 0.3, 0.1, 0.4}, {3, 1, 20.0, 0.2, 0.0, 0.1}});
    seam.begin(stage);  // half closed; closed
    check_energy(seam, 9, states, {.length = 0.02, .force_scale = 1.0, .stiffness_scale = 50.0});
    VecX together = s.x;
    together.segment<3>(9) = together.segment<3>(3);
    together.segment<3>(24) = together.segment<3>(0) + Vec3(0, 0.15, 0);
    CHECK(seam.value(together) < 1e-25);
}

TEST_CASE("a plate across the wind feels ½ ρ C_D A u², along it nothing, and lift stands across",
          "[energy]") {
    const MeshData mesh = make_grid({.size = {0.5, 0.4}, .resolution = {2, 2}});
    State still;
    still.positions = flatten(mesh.positions);
    still.velocities = VecX::Zero(12);
    auto force = [&](const AirDesc& desc) {
        AirEnergy air(mesh.triangles, desc);
        air.begin({{{1.0, still.positions}}, 0.01, 0.0, still});
        VecX g = VecX::Zero(12);
        air.add_gradient(still.positions, g);
        return Vec3(-g.reshaped(3, 4).rowwise().sum());
    };
    CHECK((force({.density = 1.2, .drag = 1.5, .wind = {0, 0, 4}}) - Vec3(0, 0, 0.5 * 1.2 * 1.5 * 0.2 * 16))
              .norm() < 1e-14);
    CHECK(force({.density = 1.2, .drag = 1.5, .wind = {4, 0, 0}}).norm() < 1e-14);
    // At 30 degrees: n·û = ½, lift ½ ρ C_L A u² (n·û) |n - (n·û) û| = ½ ρ C_L A u² · ½ · √¾, across the wind.
    const Vec3 wind(4.0 * std::sqrt(0.75), 0, 2.0);
    const Vec3 both = force({.density = 1.2, .drag = 1.0, .lift = 1.0, .wind = wind});
    const Vec3 drag = force({.density = 1.2, .drag = 1.0, .wind = wind});
    CHECK((both - drag).dot(wind) == Approx(0.0).margin(1e-14));
    CHECK((both - drag).norm() == Approx(0.5 * 1.2 * 0.2 * 16 * 0.5 * std::sqrt(0.75)));
}

TEST_CASE("gusts have the size asked for, no divergence, and repeat with their seed", "[energy]") {
    const AirDesc desc{.drag = 1.0, .wind = {2, 0, 1}, .gusts = 1.5, .gust_length = 0.8, .seed = 3};
    const Wind wind(desc);
    double sum = 0.0;
    int count = 0;
    for (int i = 0; i < 4000; ++i) {
        const Vec3 place(0.37 * i, 0.73 * (i % 71), -0.53 * (i % 37));
        const Vec3 gust = wind.at(place, 0.11 * i) - desc.wind;
        sum += gust.squaredNorm() / 3.0;
        ++count;
        const double h = 1e-4;
        double divergence = 0.0;
        for (int a = 0; a < 3; ++a) {
            divergence +=
                (wind.at(place + h * Vec3::Unit(a), 0.0)(a) - wind.at(place - h * Vec3::Unit(a), 0.0)(a)) /
                (2 * h);
        }
        REQUIRE(std::abs(divergence) < 1e-4);
    }
    CHECK(std::sqrt(sum / count) == Approx(1.5).epsilon(0.05));
    CHECK(Wind(desc).at(Vec3(1, 2, 3), 4.0) == wind.at(Vec3(1, 2, 3), 4.0));
    AirDesc other = desc;
    other.seed = 4;
    CHECK((Wind(other).at(Vec3(1, 2, 3), 4.0) - wind.at(Vec3(1, 2, 3), 4.0)).norm() > 0.01);
}

TEST_CASE("contact with shapes passes the battery", "[energy]") {
    ColliderDesc sphere, plane;
    sphere.center = Vec3(0.1, 0.0, 0.0);
    sphere.radius = 0.3;
    sphere.contact_offset = 0.05;
    sphere.friction = 0.4;
    plane.shape = Shape::plane;
    plane.center = Vec3(0.0, -0.2, 0.0);
    plane.normal = Vec3(0.1, 2.0, 0.0);
    plane.contact_offset = 0.03;
    plane.friction = 0.7;
    VecX start(12), x(12);
    start << 0.1, 0.31, 0.02, 0.42, 0.01, 0.03, -0.5, -0.18, 0.2, 3, 3, 3;
    const double dt = 0.01, speed = 0.2;
    // Sliding, sticking, sliding on the plane, free.
    x = start;
    x.head<12>() +=
        (VecX(12) << 0.01, -0.005, 0.0, 0.0, 0.001, 0.0005, 0.02, 0.003, 0.004, 0.1, 0.1, 0.1).finished();
    ColliderContactEnergy energy({sphere, plane}, {1, 1}, start, 50.0, dt, speed);
    CHECK(energy.contact_count() == 3);
    check_energy(energy, 4, {x},
                 {.length = 1e-3, .force_scale = 1.0, .stiffness_scale = 50.0, .rigid_motion_free = false});
    CHECK(energy.value(x) > 0.0);
    ColliderContactEnergy off({sphere, plane}, {0, 0}, start, 50.0, dt, speed);
    CHECK(off.value(x) == 0.0);
}
