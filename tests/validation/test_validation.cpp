// The checks of `render_cloth validate` at small size, and their references against known numbers.

#include <catch2/catch.hpp>

#include "validation/elastica.h"
#include "validation/validation.h"

using namespace cloth;
using namespace cloth::validation;
using Catch::Contains;

namespace {

void require_good(const Outcome& outcome) {
    REQUIRE_FALSE(outcome.findings.empty());
    for (const Finding& f : outcome.findings) {
        INFO(table_line(f, false));
        CHECK(f.good());
    }
}

}  // namespace

TEST_CASE("the heavy elastica meets a collocation of the same problem to 1e-6", "[validation]") {
    // Γ, H/W by Chebyshev collocation with 300 points.
    const double known[][2] = {{0.1, 0.012499554},
                               {4.641588834, 0.547538552},
                               {31.6227766, 2.650466574},
                               {562.3413252, 15.729211477},
                               {10000, 69.708829579}};
    for (const auto& [gamma, ratio] : known) {
        const Elastica e = heavy_elastica(gamma);
        CHECK(e.drop / e.span == Approx(ratio).epsilon(1e-6));
    }
}

TEST_CASE("a narrow strip buckles sideways at the classical load", "[validation]") {
    CHECK(lateral_buckling_load(1e-3) == Approx(12.85).epsilon(2e-3));
    CHECK(lateral_buckling_load(0.1) > lateral_buckling_load(0.05));  // the clamp stiffens a wide strip
}

TEST_CASE("a cantilever bends as the elastica at any load and better on finer meshes", "[validation]") {
    for (double gamma : {0.1, 8.0, 300.0}) require_good(check_cantilever({.gamma = gamma, .resolution = 40}));
    require_good(check_space_order({}));
}

TEST_CASE("a strip on edge stays straight below its buckling load and gives way above", "[validation]") {
    require_good(check_lateral_buckling({.resolution = 40}));
}

TEST_CASE("hanging strips, waves and pendulums follow their closed forms", "[validation]") {
    require_good(check_catenary({}));
    require_good(check_own_weight({.resolution = 10}));
    require_good(check_pendulum({.resolution = 30}));
    require_good(check_wave_speed({.resolution = 30}));
    require_good(check_vibration({.resolution = 24}));
}

TEST_CASE("momentum, energy and order in time are those of the schemes", "[validation]") {
    require_good(check_momentum({}));
    require_good(check_energy({.resolution = 6}));
    require_good(check_time_order({.resolution = 5}));
}

TEST_CASE("cotton drapes as measured, and stiffer cloth drapes less", "[validation]") {
    require_good(check_drape({.resolution = 20, .fabric = "cotton"}));
    cloth::Fabric stiff;
    stiff.density = 0.15;
    stiff.thickness = 1.0;
    stiff.young_modulus = 1e3;
    stiff.bending = 1e-3;
    CHECK(cusick_drape_coefficient(stiff, 10) > 90.0);
}

TEST_CASE("findings and plots are told in full", "[validation]") {
    Finding f{"name", "thing", 1.5, 1.0, 0.4, "m", "theory"};
    CHECK_FALSE(f.good());
    CHECK_THAT(table_line(f, false), Contains("BAD") && Contains("1.5") && Contains("theory"));
    f.tolerance = 0.5;
    CHECK(f.good());
    CHECK_THAT(table_line(f, true), Contains("| good |"));
    f.measured = std::numeric_limits<double>::quiet_NaN();
    CHECK_FALSE(f.good());

    const Plot plot{"p",
                    "A & B",
                    "x",
                    "y",
                    true,
                    false,
                    {{"line", {{1, 2}, {10, 3}, {-1, 2}}}, {"dots", {{5, 2}}, true}}};
    const std::string svg = to_svg(plot);
    CHECK_THAT(svg,
               Contains("A &amp; B") && Contains("polyline") && Contains("circle") && Contains("</svg>"));
    CHECK_THAT(svg, !Contains("nan") && !Contains("inf"));
}
