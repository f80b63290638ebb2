#include "pipeline/picture/overlap_picture.h"

#include <cmath>
#include <limits>
#include <numbers>

#include "pipeline/picture/camera.h"
#include "pipeline/picture/picture.h"
#include "render/overlay/overlay.h"
#include "render/raster/surface_map.h"

namespace cloth::pipeline {
namespace {

using render::Float2;
using render::Float3;

constexpr double field_of_view = 30.0;  // [degree]
constexpr double surroundings = 3.0;    // radii of the triangles' ball that half the picture's height shows
constexpr float red_share = 0.75f;

render::Material grey(float shade) {
    render::Material material;
    material.front = material.back = {shade, shade, shade};
    return material;
}

SceneFile prepared(SceneFile file, const OverlapError& overlap) {
    for (Look& look : file.cloth_looks) look = {grey(0.55f), 0, 0.0};
    for (Look& look : file.collider_looks) look.material = grey(0.3f);
    file.camera = overlap_camera(file, overlap);
    aim(file.view, file.camera, 0.0);
    file.annotation = {};
    file.annotation.wireframe = true;
    return file;
}

void tint(render::Image& image, const render::SurfaceMap& map) {
    constexpr std::array<float, 3> red{215, 20, 20};
    constexpr int per_pixel = render::samples_per_side * render::samples_per_side;
    for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) {
            int seen = 0;
            for (int k = 0; k < per_pixel; ++k) seen += map.at(2 * x + k % 2, 2 * y + k / 2).surface >= 0;
            const float share = red_share * static_cast<float>(seen) / per_pixel;
            std::uint8_t* pixel = image.pixel(x, y);
            for (int k = 0; k < 3; ++k)
                pixel[k] = static_cast<std::uint8_t>((1 - share) * pixel[k] + share * red[k] + 0.5f);
        }
}

}  // namespace

CameraDesc overlap_camera(const SceneFile& file, const OverlapError& overlap) {
    constexpr double most = std::numeric_limits<double>::infinity();
    Vec3 low = Vec3::Constant(most), high = -low;
    double longest = 0.0;
    for (const auto& triangle : overlap.triangles)
        for (int k = 0; k < 3; ++k) {
            low = low.cwiseMin(triangle[k]);
            high = high.cwiseMax(triangle[k]);
            longest = std::max(longest, (triangle[(k + 1) % 3] - triangle[k]).norm());
        }
    CameraDesc camera;
    camera.field_of_view = field_of_view;
    camera.target = 0.5 * (low + high);

    // The scene's line of sight, turned by eighths, and not too flat
    const Vec3 sight = file.camera.position - file.camera.target;
    const double start = std::atan2(sight.x(), sight.z());
    const double rise = std::clamp(std::atan2(sight.y(), std::hypot(sight.x(), sight.z())), 0.35, 1.2);
    double best = -1.0;
    for (int turn = 0; turn < 8; ++turn) {
        const double angle = start + turn * std::numbers::pi / 4;
        const Vec3 way(std::cos(rise) * std::sin(angle), std::sin(rise), std::cos(rise) * std::cos(angle));
        double faces = 0.0;
        for (const auto& [a, b, c] : overlap.triangles) faces += std::abs((b - a).cross(c - a).dot(way));
        if (faces <= 1.05 * best) continue;  // among alike ones, the nearest to the scene's own
        best = faces;
        const double radius = std::max({0.5 * (high - low).norm(), longest, 1e-4});
        const double distance = surroundings * radius / std::tan(field_of_view * std::numbers::pi / 360);
        camera.position = camera.target + distance * way;
    }
    return camera;
}

render::Image draw_overlap(const SceneFile& file, const Model& model, const State& state,
                           const OverlapError& overlap, render::Rasterizer& rasterizer) {
    const SceneFile near = prepared(file, overlap);
    PictureMaker pictures(near, model, {}, rasterizer);
    render::Image image = pictures.draw(state);

    const render::View& view = near.view;
    std::vector<float> positions;
    std::vector<std::uint32_t> triangles;
    for (const auto& triangle : overlap.triangles)
        for (const Vec3& p : triangle) {
            triangles.push_back(static_cast<std::uint32_t>(triangles.size()));
            for (int axis = 0; axis < 3; ++axis) positions.push_back(static_cast<float>(p[axis]));
        }
    render::Frame frame;
    frame.surfaces.push_back({positions, {}, triangles, {}});
    tint(image, render::map_surfaces(frame, view, {0, 0, image.width, image.height}));

    const render::Pinhole camera(view);
    const float line = std::max(1.0f, static_cast<float>(image.height) / 480.0f);
    for (const auto& triangle : overlap.triangles) {
        std::vector<Float2> outline;
        for (const int k : {0, 1, 2, 0}) {
            const Float3 place =
                camera.project({static_cast<float>(triangle[k].x()), static_cast<float>(triangle[k].y()),
                                static_cast<float>(triangle[k].z())});
            outline.push_back({place[0], place[1]});
        }
        render::draw_polyline(image, outline, line, {{120, 0, 0}});
    }
    return image;
}

}  // namespace cloth::pipeline
