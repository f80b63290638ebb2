#include <catch2/catch.hpp>
#include <cmath>
#include <stdexcept>

#include "pipeline/sweep/expression.h"

using namespace cloth::pipeline;
using Catch::Contains;

namespace {

double at(const std::string& text, double x = 0) {
    return Expression(text).at([&](const std::string&) { return x; });
}

}  // namespace

TEST_CASE("expressions are arithmetic on keys", "[sweep]") {
    CHECK(at("0.6 * cloth.fabric.bending + 1e-6", 1e-5) == 0.6 * 1e-5 + 1e-6);
    CHECK(at("-2^2 + 2^3^2/8") == Approx(60));
    CHECK(at("(cloth[1].size[0] > 2 && cloth[1].size[0] <= 3) ? 10 : 20", 3) == 10);
    CHECK(at("max(1, abs(-x), min(7, 9))", 3) == 7);
    CHECK(at("round(2.5) + ln(e) + log10(100) + sin(pi/2)") == Approx(7));
    const Expression two("collider.radius / cloth.size[0] - collider.radius");
    CHECK(two.names() == std::vector<std::string>{"cloth.size[0]", "collider.radius"});
    // Twice with other values.
    double radius = 1;
    const auto value = [&](const std::string& name) { return name == "collider.radius" ? radius : 4.0; };
    CHECK(two.at(value) == 0.25 - 1);
    radius = 2;
    CHECK(two.at(value) == 0.5 - 2);
}

TEST_CASE("what is no expression is refused in words", "[sweep]") {
    CHECK_THROWS_WITH(Expression("a = 3"), Contains("to compare write =="));
    CHECK_THROWS_WITH(Expression("1, 2"), Contains("several"));
    CHECK_THROWS_WITH(Expression("  "), Contains("is empty"));
    CHECK_THROWS_WITH(Expression("2 * (3 + a"), Contains("cannot be understood"));
    CHECK_THROWS_WITH(Expression("sqroot(a)"), Contains("cannot be understood"));
    CHECK_NOTHROW(Expression("a == 3 && b != 2 && c >= 1 && d <= 4"));
}

TEST_CASE("a result that is no finite number is refused", "[sweep]") {
    CHECK_THROWS_WITH(at("1 / x"), Contains("is inf"));
    CHECK_THROWS_WITH(at("sqrt(x)", -1), Contains("which is no number"));
    CHECK_THROWS_WITH(at("0 * x", NAN), Contains("which is no number"));
}
