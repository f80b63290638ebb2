#include <catch2/catch.hpp>
#include <limits>

#include "pipeline/run/run.h"

using namespace cloth;
using namespace cloth::pipeline;

TEST_CASE("a state that cannot be used is named by its first bad vertex", "[run]") {
    State good;
    good.positions = VecX::LinSpaced(30, -1.0, 2.0);
    good.velocities = VecX::LinSpaced(30, 3.0, 4.0);
    CHECK(state_fault(good).empty());
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        State state = good;
        state.positions[17] = bad;
        CHECK(state_fault(state) == "vertex 5 is no longer finite");
        state = good;
        state.velocities[3] = -bad;
        CHECK(state_fault(state) == "vertex 1 is no longer finite");
    }
    State far = good;
    far.positions[29] = -1.1e9;
    CHECK(state_fault(far) == "vertex 9 is more than 1e+09 m away");
}
