// A step that is asked to stop ends without a trace.

#include <atomic>
#include <catch2/catch.hpp>

#include "sim/simulation.h"

using namespace cloth;

namespace {

Scene sheet(IntegratorKind integrator) {
    Scene scene;
    scene.cloths.resize(1);
    scene.cloths[0].grid.resolution = {6, 6};
    scene.cloths[0].fabric.strain_limit.reset();  // which not all integrators have
    scene.simulation.integrator = integrator;
    return scene;
}

}  // namespace

TEST_CASE("a stopped step is undone, says so, and can be made again to the same bits", "[stop]") {
    const IntegratorKind integrator =
        GENERATE(IntegratorKind::linearly_implicit_euler, IntegratorKind::implicit_euler,
                 IntegratorKind::tr_bdf2, IntegratorKind::implicit_midpoint);
    Scene scene = sheet(integrator);
    if (integrator != IntegratorKind::implicit_euler) scene.simulation.contact = ContactKind::velocity_filter;
    Simulation undisturbed(scene, 1), stopped(scene, 1);
    std::atomic<bool> stop = false;
    stopped.stop_on(&stop);
    for (int frame = 0; frame < 3; ++frame) {
        const State before = stopped.state();
        stop = true;
        const FrameReport report = stopped.advance_frame();
        CHECK(report.stopped);
        CHECK_FALSE(report.converged);
        CHECK(report.iterations == 0);
        CHECK(report.retries == 0);
        CHECK(stopped.state().positions == before.positions);
        CHECK(stopped.state().velocities == before.velocities);
        CHECK(stopped.state().step == before.step);
        CHECK(stopped.state().time == before.time);
        stop = false;
        CHECK_FALSE(stopped.advance_frame().stopped);
        CHECK_FALSE(undisturbed.advance_frame().stopped);
        CHECK(stopped.state().positions == undisturbed.state().positions);
        CHECK(stopped.state().velocities == undisturbed.state().velocities);
    }
}
