// The table of fabrics; fabrics, pins, seams and air: every refusal by its message.

#include <algorithm>
#include <catch2/catch.hpp>
#include <limits>
#include <set>
#include <string>

#include "sim/energies/bending.h"
#include "sim/model.h"
#include "sim/scene/fabrics.h"
#include "sim/scene/mesh.h"
#include "sim/scene/scene.h"
#include "support/refusal.h"

using namespace cloth;
using Catch::Contains;

namespace {

/// A sheet with every part of a fabric, a moving pin and a seam, and no contact that asks for an integrator.
Scene woven_scene() {
    Scene scene;
    scene.simulation.contact = ContactKind::velocity_filter;
    Fabric& f = scene.cloths.emplace_back().fabric;
    f.membrane = MembraneKind::st_venant_kirchhoff;
    f.young_modulus = 4e6;
    f.young_weft = 1e6;
    f.poisson_ratio = 0.3;
    f.shear_modulus = 1e5;
    f.strain_limit = 1.05;
    f.bending_model = BendingKind::hinges;
    f.bending = 8e-6;
    f.bending_weft = 4e-6;
    f.bending_bias = 5e-6;
    f.yield_curvature = 100.0;
    PinDesc pin;
    pin.edge = "top";
    pin.path = {{.time = 0.0}, {.time = 1.0, .translate = Vec3(0, 1, 0)}};
    scene.pins.push_back(pin);
    SeamDesc seam;
    seam.sides[0].edge = "left";
    seam.sides[1].edge = "right";
    scene.seams.push_back(seam);
    return scene;
}

void check_refusals(const std::vector<Spoiled>& cases) {
    CHECK(refusal([] { validate(woven_scene()); }) == "accepted");
    for (const Spoiled& c : cases) {
        Scene scene = woven_scene();
        c.spoil(scene);
        std::string key;
        CAPTURE(c.key, c.message);
        CHECK_THAT(refusal([&] { validate(scene); }, &key), Contains(c.message));
        CHECK(key == c.key);
    }
}

Fabric& fabric(Scene& s) {
    return s.cloths[0].fabric;
}

const double not_a_number = std::numeric_limits<double>::quiet_NaN();
const double infinity = std::numeric_limits<double>::infinity();

}  // namespace

TEST_CASE("every fabric of the table can be simulated and has the range of a fabric", "[fabrics]") {
    for (const NamedFabric& named : named_fabrics()) {
        const Fabric& f = named.fabric;
        INFO(f.name);
        Scene scene = woven_scene();
        fabric(scene) = f;
        CHECK(refusal([&] { validate(scene); }) == "accepted");
        CHECK(!named.description.empty());
        CHECK(f.density >= 0.03);
        CHECK(f.density <= 1.0);
        CHECK(f.thickness >= 5e-5);
        CHECK(f.thickness <= 3e-3);
        // Fibres weigh 900-1600 kg/m³, and cloth is partly air.
        CHECK(f.density / f.thickness > 100.0);
        CHECK(f.density / f.thickness < 1600.0);
        // Per width: softest knits to paper.
        CHECK(f.young_modulus * f.thickness >= 10.0);
        CHECK(f.young_modulus * f.thickness <= 1e6);
        CHECK(f.poisson_ratio >= 0.0);
        CHECK(f.poisson_ratio <= 0.5);
        // Shears far more easily than its threads stretch; knits do not.
        if (f.shear_modulus && f.name != "jersey") {
            CHECK(*f.shear_modulus < 0.3 * std::min(f.young_modulus, *f.young_weft));
        }
        REQUIRE(f.strain_limit);
        CHECK(*f.strain_limit > 1.0);
        CHECK(*f.strain_limit <= 1.5);
        CHECK(f.bending > 0.0);
        CHECK(f.bending >= f.bending_weft);
        CHECK(*f.bending_bias <= 1.5 * f.bending);
        CHECK(bending_length(f) > 5e-3);
        CHECK(bending_length(f) < 0.2);
        CHECK(f.membrane_damping > 0.0);
        CHECK(f.membrane_damping < 0.1);
        CHECK(f.bending_damping > 0.0);
        CHECK(f.bending_damping < 0.1);
        CHECK(f.friction >= 0.1);
        CHECK(f.friction <= 1.0);
    }
}

TEST_CASE("every number of every fabric has a source", "[fabrics]") {
    for (const NamedFabric& named : named_fabrics()) {
        INFO(named.fabric.name);
        std::set<std::string> keys;
        for (const FabricValue& v : named.values) {
            INFO(v.key);
            CHECK(v.source.size() > 8);
            CHECK(keys.insert(v.key).second);
        }
        std::set<std::string> wanted{"density",          "thickness",       "young_modulus", "poisson_ratio",
                                     "strain_limit",     "bending",         "bending_weft",  "bending_bias",
                                     "membrane_damping", "bending_damping", "friction"};
        if (named.fabric.young_weft) wanted.insert("young_weft");
        if (named.fabric.shear_modulus) wanted.insert("shear_modulus");
        if (named.fabric.yield_curvature) wanted.insert("yield_curvature");
        CHECK(keys == wanted);
    }
}

TEST_CASE("the table has the fabrics that people ask for, each once, found by name", "[fabrics]") {
    std::vector<std::string> names;
    for (const NamedFabric& f : named_fabrics()) names.push_back(f.fabric.name);
    CHECK(std::is_sorted(names.begin(), names.end()));
    CHECK(std::adjacent_find(names.begin(), names.end()) == names.end());
    for (const char* name :
         {"cotton", "wool", "silk", "denim", "polyester", "jersey", "ripstop_nylon", "leather", "paper"}) {
        INFO(name);
        REQUIRE(find_fabric(name));
        CHECK(find_fabric(name)->fabric.name == name);
    }
    CHECK(find_fabric("Cotton") == nullptr);
    CHECK(find_fabric("") == nullptr);
}

TEST_CASE("a named fabric's stiffness per width and weight are the stated ones", "[fabrics]") {
    const Fabric& denim = find_fabric("denim")->fabric;
    // 11 oz/yd² = 0.373 kg/m² before washing out the size; measured 0.324.
    CHECK(denim.density == 0.324);
    CHECK(denim.young_modulus * denim.thickness == Approx(1014.0));
    CHECK(*denim.young_weft * denim.thickness == Approx(205.0));
    // Silk is the limpest of the woven ones, denim the stiffest of those worn; paper stands alone.
    const auto length = [](const char* name) { return bending_length(find_fabric(name)->fabric); };
    CHECK(length("silk") < length("wool"));
    CHECK(length("wool") < length("cotton"));
    CHECK(length("cotton") < length("denim"));
    CHECK(length("denim") < length("paper"));
}

TEST_CASE("the bending length is the cube root of mean rigidity over weight", "[fabrics]") {
    Fabric f;
    f.density = 0.2;
    f.bending = 8e-6 * 0.2 * 9.81;
    CHECK(bending_length(f) == Approx(0.02));
    // Mean over all directions of D_warp cos⁴ + D_weft sin⁴ + 2H cos² sin², (D_warp + D_weft + 2 D_bias)/4.
    f.bending_weft = 0.5 * f.bending;
    f.bending_bias = 1.25 * f.bending;
    CHECK(bending_length(f) == Approx(0.02));
    f.bending = 0.0;
    f.bending_weft = f.bending_bias = std::nullopt;
    CHECK(bending_length(f) == 0.0);
}

TEST_CASE("a fabric that makes no sense is refused with key, value and range", "[fabrics]") {
    check_refusals({
        {"cloth[0].fabric.density", "is -0.1; must be 1e-6 … 1000000 kg/m²",
         [](Scene& s) { fabric(s).density = -0.1; }},
        {"cloth[0].fabric.young_weft", "is 0; must be 1e-6 … 1e15 Pa",
         [](Scene& s) { fabric(s).young_weft = 0.0; }},
        // ν² < E_warp/E_weft = 4
        {"cloth[0].fabric.poisson_ratio", "is -1; must lie between -1 and 1 (plane stress)",
         [](Scene& s) { fabric(s).poisson_ratio = -1.0; }},
        {"cloth[0].fabric.poisson_ratio", "is 0.6; must lie between -0.5 and 0.5, the root of",
         [](Scene& s) {
             fabric(s).young_weft = 16e6;
             fabric(s).poisson_ratio = 0.6;
         }},
        {"cloth[0].fabric.shear_modulus", "is -1; must be 1e-6 … 1e15 Pa",
         [](Scene& s) { fabric(s).shear_modulus = -1.0; }},
        {"cloth[0].fabric.young_weft", "needs membrane = \"st_venant_kirchhoff\"",
         [](Scene& s) { fabric(s).membrane = MembraneKind::neo_hookean; }},
        {"cloth[0].fabric.shear_modulus", "needs membrane = \"st_venant_kirchhoff\"",
         [](Scene& s) {
             fabric(s).membrane = MembraneKind::corotational;
             fabric(s).young_weft.reset();
         }},
        {"cloth[0].fabric.mu", "stands beside young_weft or shear_modulus",
         [](Scene& s) { fabric(s).mu = fabric(s).lambda = 1.0; }},
        {"cloth[0].fabric.strain_limit",
         "is 0.95; must be greater than 1 and at most 1000, a stretch such as 1.05",
         [](Scene& s) { fabric(s).strain_limit = 0.95; }},
        {"cloth[0].fabric.strain_limit", "is 1; must be greater than 1",
         [](Scene& s) { fabric(s).strain_limit = 1.0; }},
        {"cloth[0].fabric.strain_limit", "is inf, not finite; must be greater than 1 and",
         [](Scene& s) { fabric(s).strain_limit = infinity; }},
        {"cloth[0].fabric.bending", "is -1e-5; must be 0 … 1e9 N m",
         [](Scene& s) { fabric(s).bending = -1e-5; }},
        {"cloth[0].fabric.bending_weft", "is -1e-5; must be 0 … 1e9 N m",
         [](Scene& s) { fabric(s).bending_weft = -1e-5; }},
        // (8 + 4)/4 µN m
        {"cloth[0].fabric.bending_bias",
         "is 2e-6; must be at least 3e-6 N m, a quarter of warp's plus weft's",
         [](Scene& s) { fabric(s).bending_bias = 2e-6; }},
        {"cloth[0].fabric.yield_curvature", "is -1; must be 1e-6 … 1e9 1/m",
         [](Scene& s) { fabric(s).yield_curvature = -1.0; }},
        {"cloth[0].fabric.yield_curvature", "needs bending_model = \"hinges\"",
         [](Scene& s) { fabric(s).bending_model = BendingKind::quadratic; }},
        {"cloth[0].fabric.membrane_damping", "is -1; must be 0 … 1000000 s",
         [](Scene& s) { fabric(s).membrane_damping = -1.0; }},
        {"cloth[0].fabric.bending_damping", "must be 0 … 1000000 s",
         [](Scene& s) { fabric(s).bending_damping = not_a_number; }},
        {"cloth[0].fabric.friction", "is -0.2; must be 0 … 1000",
         [](Scene& s) { fabric(s).friction = -0.2; }},
        {"cloth[0].warp", "is zero; must point along the rest shape",
         [](Scene& s) { s.cloths[0].warp.setZero(); }},
        {"cloth[0].warp", "is nan, not finite; must be -1000000 … 1000000",
         [](Scene& s) { s.cloths[0].warp.x() = not_a_number; }},
    });
}

TEST_CASE("a strain limit is refused where an integrator does not keep it", "[fabrics]") {
    const char* message = "needs integrator = \"implicit_euler\" or \"tr_bdf2\" throughout";
    check_refusals({
        {"cloth[0].fabric.strain_limit", message,
         [](Scene& s) { s.simulation.integrator = IntegratorKind::linearly_implicit_euler; }},
        {"cloth[0].fabric.strain_limit", message,
         [](Scene& s) { s.simulation.integrator = IntegratorKind::implicit_midpoint; }},
        {"cloth[0].fabric.strain_limit", message,
         [](Scene& s) {
             s.events.push_back({.time = 1.0, .integrator = IntegratorKind::linearly_implicit_euler});
         }},
        {"cloth[0].fabric.strain_limit", message,
         [](Scene& s) { s.events.push_back({.time = 1.0, .toggle_integrator = true}); }},
    });
    Scene scene = woven_scene();
    scene.simulation.integrator = IntegratorKind::tr_bdf2;
    CHECK_NOTHROW(validate(scene));
    fabric(scene).strain_limit.reset();
    scene.simulation.integrator = IntegratorKind::implicit_midpoint;
    CHECK_NOTHROW(validate(scene));
}

TEST_CASE("pins, seams, air and retries out of range are refused with the range", "[scene]") {
    check_refusals({
        {"pin[0]", "exactly one of vertices, box, nearest, greatest, edge",
         [](Scene& s) { s.pins[0].nearest = Vec3::Zero(); }},
        {"pin[0].edge", "is \"north\"; must be one of left, right, bottom, top",
         [](Scene& s) { s.pins[0].edge = "north"; }},
        {"pin[0].path[0].time", "is -1; must be 0 … 1e9 s", [](Scene& s) { s.pins[0].path[0].time = -1.0; }},
        {"pin[0].path", "has times that do not increase", [](Scene& s) { s.pins[0].path[1].time = 0.0; }},
        {"pin[0].path[1].translate", "finite",
         [](Scene& s) { s.pins[0].path[1].translate.x() = not_a_number; }},
        {"pin[0].path[1].rotate", "finite", [](Scene& s) { s.pins[0].path[1].rotate.x() = infinity; }},
        {"pin[0].center", "finite", [](Scene& s) { s.pins[0].center = Vec3(not_a_number, 0, 0); }},
        {"pin[0].until", "is 0; must be 1e-9 … 1e9 s", [](Scene& s) { s.pins[0].until = 0.0; }},
        {"seam[0].first.cloth", "no such cloth", [](Scene& s) { s.seams[0].sides[0].cloth = 1; }},
        {"seam[0].second.cloth", "no such cloth", [](Scene& s) { s.seams[0].sides[1].cloth = -1; }},
        {"seam[0].second", "exactly one of", [](Scene& s) { s.seams[0].sides[1].edge.reset(); }},
        {"seam[0].first.edge", "must be one of left", [](Scene& s) { s.seams[0].sides[0].edge = ""; }},
        {"seam[0].begin", "is -1; must be 0 … 1e9 s", [](Scene& s) { s.seams[0].begin = -1.0; }},
        {"seam[0].close_time", "is 0; must be 1e-9 … 1e9 s", [](Scene& s) { s.seams[0].close_time = 0.0; }},
        {"seam[0].stiffness", "must be 1e-9 … 1e15 N/m",
         [](Scene& s) { s.seams[0].stiffness = not_a_number; }},
        {"air.density", "is 0; must be 1e-6 … 1000000 kg/m³",
         [](Scene& s) { s.simulation.air.density = 0.0; }},
        {"air.drag", "is -1; must be 0 … 1000", [](Scene& s) { s.simulation.air.drag = -1.0; }},
        {"air.lift", "is -0.5; must be 0 … 1000", [](Scene& s) { s.simulation.air.lift = -0.5; }},
        {"air.lift", "is 2; must be at most the drag, 1",
         [](Scene& s) {
             s.simulation.air.drag = 1.0;
             s.simulation.air.lift = 2.0;
         }},
        {"air.wind", "finite", [](Scene& s) { s.simulation.air.wind.z() = infinity; }},
        {"air.gusts", "is -1; must be 0 … 10000 m/s", [](Scene& s) { s.simulation.air.gusts = -1.0; }},
        {"air.gust_length", "is 0; must be 0.001 … 1000000 m",
         [](Scene& s) { s.simulation.air.gust_length = 0.0; }},
        {"simulation.retries", "is -1; must be 0 … 20", [](Scene& s) { s.simulation.retries = -1; }},
        {"simulation.retries", "is 21; must be 0 … 20", [](Scene& s) { s.simulation.retries = 21; }},
    });
}

TEST_CASE("the edges of a grid are selected by their names", "[scene]") {
    const Grid grid{.size = {2.0, 1.0}, .resolution = {3, 2}};
    const Points p = make_grid(grid).positions;
    ClothDesc cloth;
    cloth.grid = grid;
    PinDesc pin;
    const auto edge = [&](const char* name) {
        pin.edge = name;
        return select_vertices(pin, cloth, {}, p, "pin[0]");
    };
    CHECK(edge("left") == std::vector<int>{0, 3});
    CHECK(edge("right") == std::vector<int>{2, 5});
    CHECK(edge("bottom") == std::vector<int>{0, 1, 2});
    CHECK(edge("top") == std::vector<int>{3, 4, 5});
    std::string key;
    CHECK_THAT(refusal([&] { select_vertices(pin, {.disc = Disc{}}, {}, p, "pin[0]"); }, &key),
               Contains("names a grid's edge; this cloth is no grid"));
    CHECK(key == "pin[0].edge");
}
