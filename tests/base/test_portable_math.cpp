// exp and log from additions and multiplications, against the C library's.

#include <catch2/catch.hpp>
#include <cmath>

#include "base/portable_math.h"

using namespace cloth;

TEST_CASE("exp and log are within a few units of the last digit of the C library's", "[math]") {
    for (double x = -700; x < 709; x += 0.37)
        CHECK(std::abs(portable_exp(x) / std::exp(x) - 1) < 1e-15 * std::max(1.0, 0.3 * std::abs(x)));
    for (double x = 1e-300; x < 1e300; x *= 1.37)
        CHECK(std::abs(portable_log(x) - std::log(x)) < 1e-15 * std::max(1.0, std::abs(std::log(x))));
    CHECK(portable_exp(0) == 1);
    CHECK(portable_log(1) == 0);
    CHECK(portable_exp(-800) == 0);
    CHECK(std::isinf(portable_exp(800)));
}
