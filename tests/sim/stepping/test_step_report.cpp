#include <catch2/catch.hpp>
#include <set>
#include <string>

#include "sim/stepping/step_report.h"

using namespace cloth;

namespace {

StepReport step(int scale) {
    StepReport r;
    r.iterations = 3 * scale;
    r.residual = 1e-6 * scale;
    r.retries = scale;
    r.energy_before = 10.0 * scale;
    r.energy_after = 9.0 * scale;
    r.largest_stretch = 0.5 * scale;
    r.smallest_gap = 1e-3 / scale;
    r.contacts = 7 * scale;
    r.placements = scale;
    r.cg_iterations = 40 * scale;
    r.factorizations = 5 * scale;
    r.contact_times.assembly = 0.25 * scale;
    return r;
}

}  // namespace

TEST_CASE("a frame's report holds sums, worst values, and the energies at its two ends", "[report]") {
    FrameReport frame;
    merge(frame, step(1));
    CHECK(frame.steps == 1);
    CHECK(frame.largest_stretch == 0.5);  // less than that of a sheet at rest
    merge(frame, step(4));
    merge(frame, step(2));
    CHECK(frame.steps == 3);
    CHECK(frame.iterations == 21);
    CHECK(frame.residual == 4e-6);
    CHECK(frame.retries == 7);
    CHECK(frame.energy_before == 10.0);
    CHECK(frame.energy_after == 18.0);
    CHECK(frame.largest_stretch == 2.0);
    CHECK(frame.smallest_gap == 2.5e-4);
    CHECK(frame.contacts == 28);
    CHECK(frame.placements == 7);
    CHECK(frame.cg_iterations == 280);
    CHECK(frame.factorizations == 35);
    CHECK(frame.contact_times.assembly == 1.75);
    CHECK(frame.converged);
    CHECK(frame.placed);
    CHECK_FALSE(frame.worst_vertex);

    StepReport failed = step(1);
    failed.converged = failed.placed = false;
    failed.worst_vertex = 12;
    merge(frame, failed);
    CHECK_FALSE(frame.converged);
    CHECK_FALSE(frame.placed);
    CHECK(frame.worst_vertex == 12);
}

TEST_CASE("of a part that is undone only its work counts", "[report]") {
    StepReport whole = step(1), undone = step(8);
    undone.converged = false;
    undone.worst_vertex = 3;
    merge_work(whole, undone);
    CHECK(whole.iterations == 27);
    CHECK(whole.cg_iterations == 360);
    CHECK(whole.contact_times.assembly == 2.25);
    CHECK(whole.converged);
    CHECK(whole.residual == 1e-6);
    CHECK(whole.contacts == 7);
    CHECK(whole.smallest_gap == 1e-3);
    CHECK_FALSE(whole.worst_vertex);
}

TEST_CASE("each counter of a report has a name of its own and begins at what changes no other", "[report]") {
    std::set<std::string> names;
    std::size_t count = 0;
    StepReport::describe([&](const char* name, auto member, const char* unit, auto rule) {
        CAPTURE(name);
        names.insert(name);
        ++count;
        CHECK(std::string(unit).size() <= 1);
        const auto value = step(4).*member;
        // Energies are of the two ends: what begins at nothing stands there until the first part has come.
        if (std::string(name) != "energy_before") CHECK(rule(StepReport().*member, value) == value);
    });
    CHECK(names.size() == count);
    ContactTimes::describe([&](const char* name, auto member, const char*, auto rule) {
        CAPTURE(name);
        CHECK(rule(ContactTimes().*member, 2.5) == 2.5);
    });
}
