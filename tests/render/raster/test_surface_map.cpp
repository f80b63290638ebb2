// Which triangle a sample shows: places known by hand.

#include <catch2/catch.hpp>
#include <vector>

#include "render/raster/surface_map.h"

using namespace cloth::render;

namespace {

struct Mesh {
    std::vector<float> positions, normals;
    std::vector<std::uint32_t> triangles;
    Surface surface() const { return {positions, normals, triangles, {}, true}; }
};

/// A square of side 2 h at depth z, facing +z: triangle 0 below its rising diagonal, 1 above.
Mesh square(float h, float z, float x = 0) {
    return {{x - h, -h, z, x + h, -h, z, x + h, h, z, x - h, h, z},
            {0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1},
            {0, 1, 2, 0, 2, 3}};
}

/// From (0, 0, 3): at the plane z = 0 the picture is 2 m high, 100 pixels.
View plain_view() {
    View view;
    view.width = 160;
    view.height = 100;
    view.eye = {0, 0, 3};
    view.field_of_view = 36.869898f;  // tan of half of it: 1/3
    return view;
}

}  // namespace

TEST_CASE("a point comes to the pixel that the lens law says", "[surface_map]") {
    const Pinhole camera(plain_view());
    const Float3 center = camera.project({0, 0, 0});
    CHECK(center[0] == Approx(80));
    CHECK(center[1] == Approx(50));
    CHECK(center[2] == Approx(3));
    const Float3 corner = camera.project({1, 0.5f, 0});
    CHECK(corner[0] == Approx(130));
    CHECK(corner[1] == Approx(25));
    const Float3 nearer = camera.project({1, 0, 1.5f});
    CHECK(nearer[0] == Approx(180));
    CHECK(camera.project({0, 0, 4})[2] < 0);
}

TEST_CASE("samples know their triangle, depth and place in it", "[surface_map]") {
    const Mesh mesh = square(0.5f, 0);
    Frame frame;
    frame.surfaces = {mesh.surface()};
    const SurfaceMap map = map_surfaces(frame, plain_view(), {0, 0, 160, 100});
    REQUIRE(map.width == 320);
    REQUIRE(map.samples.size() == 320 * 200);
    int covered = 0;
    for (const SurfaceSample& s : map.samples) covered += s.surface == 0;
    CHECK(covered == 100 * 100);  // 50 x 50 pixels, two samples a side
    CHECK(map.at(109, 100).surface == -1);
    CHECK(map.at(110, 100).surface == 0);
    CHECK(map.at(209, 100).surface == 0);
    CHECK(map.at(210, 100).surface == -1);
    CHECK(map.at(200, 140).triangle == 0);
    CHECK(map.at(120, 60).triangle == 1);
    const SurfaceSample& s = map.at(180, 140);
    CHECK(s.depth == Approx(3));
    // Its place from the shares: sample (180, 140) has its middle at pixel (90.25, 70.25).
    const float x = -0.5f * s.shares[0] + 0.5f * s.shares[1] + 0.5f * s.shares[2];
    const float y = -0.5f * s.shares[0] - 0.5f * s.shares[1] + 0.5f * s.shares[2];
    CHECK(x == Approx(0.205));
    CHECK(y == Approx(-0.405));
}

TEST_CASE("the nearer surface hides the other in any order, and a window sees the same", "[surface_map]") {
    const Mesh far = square(1, 0), close = square(0.25f, 1);
    Frame frame;
    frame.surfaces = {close.surface(), far.surface()};
    const SurfaceMap one = map_surfaces(frame, plain_view(), {0, 0, 160, 100});
    CHECK(one.at(160, 100).surface == 0);
    CHECK(one.at(160, 100).depth == Approx(2));
    CHECK(one.at(100, 100).surface == 1);
    frame.surfaces = {far.surface(), close.surface()};
    const SurfaceMap other = map_surfaces(frame, plain_view(), {0, 0, 160, 100});
    CHECK(other.at(160, 100).surface == 1);
    const SurfaceMap part = map_surfaces(frame, plain_view(), {70, 40, 90, 60});
    REQUIRE(part.width == 40);
    for (int y = 0; y < 40; ++y)
        for (int x = 0; x < 40; ++x) CHECK(part.at(x, y).surface == other.at(x + 140, y + 80).surface);
    CHECK(map_surfaces(frame, plain_view(), {300, 0, 400, 100}).samples.empty());
}

TEST_CASE("depth shares are right in perspective, behind the eye nothing is seen", "[surface_map]") {
    // A floor from far before the camera to far behind it.
    const Mesh floor{{-50, -1, -50, 50, -1, -50, 50, -1, 50, -50, -1, 50},
                     {0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0},
                     {0, 2, 1, 0, 3, 2}};
    Frame frame;
    frame.surfaces = {floor.surface()};
    const SurfaceMap map = map_surfaces(frame, plain_view(), {0, 0, 160, 100});
    CHECK(map.at(160, 99).surface == -1);  // above the horizon
    const SurfaceSample& s = map.at(160, 199);
    REQUIRE(s.surface == 0);
    // The lowest sample's ray falls by 0.995/3 per metre, so it meets the floor after 3/0.995 m.
    CHECK(s.depth == Approx(3 / 0.995).epsilon(1e-4));
    float z = 0;
    for (int k = 0; k < 3; ++k)
        z += s.shares[k] *
             floor.positions[3 * floor.triangles[3 * static_cast<std::size_t>(s.triangle) + k] + 2];
    CHECK(z == Approx(3 - 3 / 0.995).margin(1e-3));
    // The ground hides what lies below it.
    frame.ground = Ground{};
    CHECK(map_surfaces(frame, plain_view(), {0, 0, 160, 100}).at(160, 199).surface == -1);
}
