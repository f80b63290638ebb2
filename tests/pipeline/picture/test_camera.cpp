// Camera paths, the turntable and automatic framing against places known by hand.

#include <catch2/catch.hpp>
#include <cmath>

#include "pipeline/picture/camera.h"
#include "render/raster/surface_map.h"

using namespace cloth;
using namespace cloth::pipeline;

namespace {

CameraDesc at_rest() {
    CameraDesc camera;
    camera.position = Vec3(0, 0, 3);
    camera.target = Vec3(0, 0, 0);
    return camera;
}

void check_near(const Vec3& a, const Vec3& b, double margin = 1e-12) {
    INFO("(" << a.transpose() << ") against (" << b.transpose() << ")");
    CHECK((a - b).norm() <= margin);
}

/// Picture coordinates, -1 … 1 from edge to edge, of a point.
Vec2 place_of(const CameraDesc& camera, double time, double aspect, const Vec3& p) {
    render::View view;
    view.height = 1000;
    view.width = static_cast<int>(aspect * 1000);
    aim(view, camera, time);
    const auto place = render::Pinhole(view).project(
        {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())});
    CHECK(place[2] > 0);
    return {place[0] / (0.5 * view.width) - 1, place[1] / (0.5 * view.height) - 1};
}

}  // namespace

TEST_CASE("a camera at rest stays", "[camera]") {
    const CameraPose pose = camera_at(at_rest(), 7);
    CHECK(pose.position == Vec3(0, 0, 3));
    CHECK(pose.target == Vec3(0, 0, 0));
    CHECK(pose.field_of_view == 35);
    CHECK_FALSE(moves(at_rest()));
}

TEST_CASE("a path goes through its keys, starts and ends at rest, and never beyond two neighbours",
          "[camera]") {
    CameraDesc camera = at_rest();
    camera.path.resize(4);
    const double times[] = {1, 2, 2.5, 5};
    const double x[] = {0, 4, 4, -1};
    for (std::size_t i = 0; i < 4; ++i) {
        camera.path[i].time = times[i];
        camera.path[i].position = Vec3(x[i], 1, 3);
    }
    camera.path[1].field_of_view = 20;
    camera.path[3].target = Vec3(0, 1, 0);
    for (std::size_t i = 0; i < 4; ++i)
        CHECK(camera_at(camera, times[i]).position.x() == Approx(x[i]).margin(1e-12));
    CHECK(camera_at(camera, 2).field_of_view == Approx(20));
    CHECK(camera_at(camera, 1).field_of_view == Approx(35));
    CHECK(camera_at(camera, 9).target == Vec3(0, 1, 0));
    CHECK(camera_at(camera, 0).position == Vec3(0, 1, 3));
    // Half-way between two keys at rest: the middle.
    CHECK(camera_at(camera, 1.5).position.x() == Approx(2));
    double before = 0;
    for (double t = 1; t <= 5.0001; t += 0.01) {
        const double now = camera_at(camera, t).position.x();
        CHECK(now >= -1 - 1e-9);
        CHECK(now <= 4 + 1e-9);
        if (t < 2) CHECK(now >= before - 1e-12);
        if (t > 2.001 && t < 2.499) CHECK(now == Approx(4));
        CHECK(std::abs(now - before) < 0.07);  // no jump
        before = now;
    }
    const double h = 1e-5;  // the velocity is continuous at a key
    camera.path[2].position = Vec3(5, 1, 3);
    camera.path[3].position = Vec3(9, 1, 3);
    const auto speed = [&](double t) {
        return (camera_at(camera, t + h).position.x() - camera_at(camera, t - h).position.x()) / (2 * h);
    };
    CHECK(speed(2.5 - 2 * h) == Approx(speed(2.5 + 2 * h)).epsilon(1e-3));
    CHECK(speed(2.5) > 0.5);
    CHECK(std::abs(speed(1.0 + 2 * h)) < 1e-3);
}

TEST_CASE("a turntable turns the eye about the target", "[camera]") {
    CameraDesc camera = at_rest();
    camera.target = Vec3(1, 0.5, 0);
    camera.position = Vec3(1, 1, 3);
    camera.turntable = 30;
    check_near(camera_at(camera, 0).position, Vec3(1, 1, 3));
    check_near(camera_at(camera, 3).position, Vec3(4, 1, 0));  // a quarter turn, counter-clockwise from above
    check_near(camera_at(camera, 12).position, Vec3(1, 1, 3));
    check_near(camera_at(camera, 5).target, camera.target);
}

TEST_CASE("automatic framing holds every point, and no more than it must", "[camera]") {
    CameraDesc camera = at_rest();
    camera.position = Vec3(0.5, 0.8, 2);
    const double aspect = 16.0 / 9.0;
    Extent extent(camera, aspect);
    CHECK(extent.empty());
    check_near(extent.framed(camera).position, camera.position);
    std::vector<Vec3> points;
    for (int i = 0; i < 200; ++i)
        points.push_back(Vec3(3 + std::sin(1.3 * i), 2 + std::cos(2.1 * i), -4 + 2 * std::sin(0.7 * i)));
    for (const Vec3& p : points) extent.add(p);

    SECTION("along the line of sight") {
        const CameraDesc framed = extent.framed(camera);
        check_near((framed.target - framed.position).normalized(),
                   (camera.target - camera.position).normalized());
        Vec2 furthest = Vec2::Zero();
        for (const Vec3& p : points) furthest = furthest.cwiseMax(place_of(framed, 0, aspect, p).cwiseAbs());
        CHECK(furthest.maxCoeff() == Approx(1 - 2.0 / 12.0).epsilon(1e-3));
    }
    SECTION("in every turn of a turntable") {
        camera.turntable = 90;
        Extent turning(camera, aspect);
        for (const Vec3& p : points) turning.add(p);
        const CameraDesc framed = turning.framed(camera);
        for (double t = 0; t < 4; t += 0.25)
            for (const Vec3& p : points)
                CHECK(place_of(framed, t, aspect, p).cwiseAbs().maxCoeff() <= 1 - 2.0 / 12.0 + 0.02);
        // And it is no further away than it must be: somewhere in the turn a point comes near the margin.
        double furthest = 0;
        for (double t = 0; t < 4; t += 0.02)
            for (const Vec3& p : points)
                furthest = std::max(furthest, place_of(framed, t, aspect, p).cwiseAbs().maxCoeff());
        CHECK(furthest > 1 - 2.0 / 12.0 - 0.02);
    }
    SECTION("two runs together") {
        Extent other(camera, aspect);
        other.add(Vec3(-5, 0, 0));
        extent.add(other);
        const CameraDesc framed = extent.framed(camera);
        for (const Vec3& p : points)
            CHECK(place_of(framed, 0, aspect, p).cwiseAbs().maxCoeff() <= 1 - 2.0 / 12.0 + 1e-3);
        CHECK(place_of(framed, 0, aspect, Vec3(-5, 0, 0)).cwiseAbs().maxCoeff() <= 1 - 2.0 / 12.0 + 1e-3);
    }
}
