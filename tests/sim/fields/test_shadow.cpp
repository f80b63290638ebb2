// Shadows whose areas are known.

#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "sim/fields/shadow.h"

using namespace cloth;

namespace {

/// A rectangle of two triangles, a x b, leaning by `slope` along its first side.
VecX leaning(double a, double b, double slope, double height = 0) {
    VecX q(12);
    q << 0, height, 0, a, height + slope * a, 0, a, height + slope * a, b, 0, height, b;
    return q;
}
const Triangles two = (Triangles(2, 3) << 0, 1, 2, 0, 2, 3).finished();

}  // namespace

TEST_CASE("a shadow is what is seen from above, however high and however much lies on another", "[fields]") {
    // Half a cell along the rim is the error.
    CHECK(std::abs(shadow_area(leaning(0.4, 0.3, 0), two, 1e-3) - 0.12) < 1e-3);
    CHECK(std::abs(shadow_area(leaning(0.4, 0.3, 2.0, 7.0), two, 1e-3) - 0.12) < 1e-3);
    CHECK(surface_area(leaning(0.4, 0.3, 2.0), two) == Approx(0.12 * std::sqrt(5.0)));
    VecX folded(24);
    folded << leaning(0.4, 0.3, 0), leaning(0.4, 0.3, 0.1);
    Triangles four(4, 3);
    four << two, (two.array() + 4).matrix();
    CHECK(shadow_area(folded, four, 1e-3) == shadow_area(leaning(0.4, 0.3, 0), two, 1e-3));
    CHECK(shadow_area(VecX::Zero(12), two, 1e-3) < 1e-5);
    CHECK_THROWS_AS(shadow_area(leaning(1e6, 1e6, 0), two, 1e-3), std::invalid_argument);
}

TEST_CASE("the drape coefficient is 100 % of a board and 0 of what hangs straight down", "[fields]") {
    CHECK(drape_coefficient(0.3, 0.1, 0.3) == Approx(100));
    CHECK(drape_coefficient(0.1, 0.1, 0.3) == Approx(0));
}
