#include "pipeline/picture/picture.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numbers>
#include <thread>
#include <tuple>
#include <utility>

#include "pipeline/picture/annotation.h"
#include "pipeline/picture/camera.h"
#include "render/image/colormap.h"
#include "render/overlay/overlay.h"
#include "render/raster/surface_map.h"
#include "render/vector_math.h"

namespace cloth::pipeline {
namespace {

using render::Float2;
using render::Float3;
using render::Ink;
using render::operator+, render::operator-, render::operator*, render::cross, render::dot, render::length;

/// What the colours of a shaded picture take the place of: neutral, so that nothing of it shows at outlines.
SceneFile prepared(SceneFile file, const RunFacts& facts) {
    if (file.annotation.shade) {
        for (Look& look : file.cloth_looks) {
            look.material = render::Material{};
            look.material.front = look.material.back = {0.2f, 0.2f, 0.2f};
        }
    }
    if (facts.extent) {
        file.camera = facts.extent->framed(file.camera);
        aim(file.view, file.camera, 0.0);
    }
    return file;
}

Float3 interpolated(std::span<const float> list, std::span<const std::uint32_t> triangles, int triangle,
                    const std::array<float, 3>& shares) {
    Float3 sum{};
    for (int k = 0; k < 3; ++k) {
        const std::size_t v = triangles[3 * static_cast<std::size_t>(triangle) + k];
        for (int axis = 0; axis < 3; ++axis) sum[axis] += shares[k] * list[3 * v + axis];
    }
    return sum;
}

/// Screen gradients of the shares of a simulated triangle's corners, over one of its parts [1/pixel].
struct EdgeGradients {
    int surface = -1, triangle = -1;
    Float3 steepness{};
};

Float3 share_steepness(const render::Pinhole& camera, const render::Surface& s, int triangle,
                       const std::array<Float3, 3>& part) {
    std::array<Float3, 3> p{};
    for (int k = 0; k < 3; ++k) {
        const std::size_t v = s.triangles[3 * static_cast<std::size_t>(triangle) + k];
        p[k] = camera.project({s.positions[3 * v], s.positions[3 * v + 1], s.positions[3 * v + 2]});
    }
    const float ax = p[1][0] - p[0][0], ay = p[1][1] - p[0][1], bx = p[2][0] - p[0][0],
                by = p[2][1] - p[0][1];
    const float area = ax * by - ay * bx;
    Float3 steepness{1e6f, 1e6f, 1e6f};
    if (std::abs(area) < 1e-6f) return steepness;
    for (int i = 0; i < 3; ++i) {
        const float da = part[1][i] - part[0][i], db = part[2][i] - part[0][i];
        const float gx = (da * by - db * ay) / area, gy = (db * ax - da * bx) / area;
        steepness[i] = std::max(std::sqrt(gx * gx + gy * gy), 1e-6f);
    }
    return steepness;
}

/// Share of a sample that the edges of its simulated triangle cover. Where triangles are only a few pixels
/// high, edges fade, as they would fill the picture.
float edge_cover(const Float3& corner_shares, const Float3& steepness, float width) {
    float cover = 0;
    for (int i = 0; i < 3; ++i) {
        const float distance = corner_shares[i] / steepness[i], height = 1 / steepness[i];
        const float here = std::clamp(0.5f * width + 0.5f - distance, 0.0f, 1.0f);
        cover = std::max(cover, here * std::clamp(height / 7.0f, 0.12f, 1.0f));
    }
    return cover;
}

}  // namespace

std::vector<std::array<Float3, 3>> subdivision_parts(int steps) {
    std::vector<std::array<Float3, 3>> parts{{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}}};
    for (int k = 0; k < steps; ++k) {
        std::vector<std::array<Float3, 3>> finer;
        for (const auto& corners : parts) {
            std::array<Float3, 3> middle{};
            for (int i = 0; i < 3; ++i)
                for (int axis = 0; axis < 3; ++axis)
                    middle[i][axis] = 0.5f * (corners[i][axis] + corners[(i + 1) % 3][axis]);
            for (int i = 0; i < 3; ++i) finer.push_back({corners[i], middle[i], middle[(i + 2) % 3]});
            finer.push_back({middle[0], middle[1], middle[2]});
        }
        parts = std::move(finer);
    }
    return parts;
}

PictureMaker::PictureMaker(SceneFile file, const Model& model, RunFacts facts, render::Rasterizer& rasterizer,
                           StateReader read_state)
    : file_(prepared(std::move(file), facts)),
      model_(model),
      facts_(std::move(facts)),
      rasterizer_(rasterizer),
      read_state_(std::move(read_state)),
      builder_(file_, model) {
    if (file_.annotation.shade) fields_.emplace(model);
    for (const Look& look : file_.cloth_looks) parts_.push_back(subdivision_parts(look.subdivisions));
}

render::Image PictureMaker::draw_scene(const State& state, const render::View& view, bool with_edges) {
    const render::Frame frame = builder_.build(state);
    render::Image image = rasterizer_.draw(frame, view);
    if (file_.annotation.shade || with_edges) paint(image, frame, view, state, with_edges);
    return image;
}

void PictureMaker::paint(render::Image& image, const render::Frame& frame, const render::View& view,
                         const State& state, bool with_edges) const {
    const bool shaded = file_.annotation.shade.has_value();
    std::vector<VecX> values;
    if (shaded) {
        const VecX all = fields_->at(*file_.annotation.shade, state);
        for (std::size_t c = 0; c < model_.cloths.size(); ++c)
            values.push_back(builder_.subdivision(c).weights *
                             all.segment(model_.cloths[c].first_vertex, model_.cloths[c].vertex_count));
    }
    const auto cloths = static_cast<int>(model_.cloths.size());
    const ShadeRange range = facts_.shade.value_or(ShadeRange{});
    const render::Pinhole camera(view);
    const float line = std::max(0.8f, static_cast<float>(view.height) / 900.0f);
    constexpr Ink dark_edge{{20, 22, 26}, 0.85f}, light_edge{{240, 240, 240}, 0.5f};

    const auto paint_rows = [&](int first, int last) {
        const render::SurfaceMap map = render::map_surfaces(frame, view, {0, first, view.width, last});
        EdgeGradients known;
        for (int y = first; y < last; ++y)
            for (int x = 0; x < view.width; ++x) {
                std::uint8_t* pixel = image.pixel(x, y);
                std::array<float, 3> sum{};
                bool touched = false;
                for (int j = 0; j < render::samples_per_side; ++j)
                    for (int i = 0; i < render::samples_per_side; ++i) {
                        const render::SurfaceSample& s = map.at(render::samples_per_side * x + i,
                                                                render::samples_per_side * (y - first) + j);
                        Float3 color{static_cast<float>(pixel[0]), static_cast<float>(pixel[1]),
                                     static_cast<float>(pixel[2])};
                        if (s.surface >= 0 && s.surface < cloths) {
                            touched = true;
                            const auto c = static_cast<std::size_t>(s.surface);
                            const render::Surface& surface = frame.surfaces[c];
                            if (shaded) {
                                double value = 0;
                                for (int k = 0; k < 3; ++k)
                                    value +=
                                        static_cast<double>(s.shares[k]) *
                                        values[c](
                                            surface.triangles[3 * static_cast<std::size_t>(s.triangle) + k]);
                                const auto hue =
                                    render::viridis((value - range.low) / (range.high - range.low));
                                // Light from the eye shows the shape; what faces it has the legend's colour.
                                const Float3 normal =
                                    interpolated(surface.normals, surface.triangles, s.triangle, s.shares);
                                const Float3 point =
                                    interpolated(surface.positions, surface.triangles, s.triangle, s.shares);
                                const Float3 to_eye = camera.eye() - point;
                                const float lengths = std::sqrt(dot(normal, normal) * dot(to_eye, to_eye));
                                const float facing =
                                    lengths > 0 ? std::abs(dot(normal, to_eye)) / lengths : 1;
                                for (int k = 0; k < 3; ++k)
                                    color[k] = static_cast<float>(hue[k]) * (0.55f + 0.45f * facing);
                            }
                            if (with_edges) {
                                const auto& parts = parts_[c];
                                const auto& part = parts[static_cast<std::size_t>(s.triangle) % parts.size()];
                                if (known.surface != s.surface || known.triangle != s.triangle)
                                    known = {s.surface, s.triangle,
                                             share_steepness(camera, surface, s.triangle, part)};
                                Float3 corner_shares{};
                                for (int k = 0; k < 3; ++k)
                                    for (int corner = 0; corner < 3; ++corner)
                                        corner_shares[corner] += s.shares[k] * part[k][corner];
                                const Ink& edge_ink = 0.3f * color[0] + 0.6f * color[1] + 0.1f * color[2] < 75
                                                          ? light_edge
                                                          : dark_edge;
                                const float cover =
                                    edge_ink.opacity * edge_cover(corner_shares, known.steepness, line);
                                for (int k = 0; k < 3; ++k)
                                    color[k] += cover * (static_cast<float>(edge_ink.rgb[k]) - color[k]);
                            }
                        }
                        for (int k = 0; k < 3; ++k) sum[k] += color[k];
                    }
                if (!touched) continue;
                constexpr float samples = render::samples_per_side * render::samples_per_side;
                for (int k = 0; k < 3; ++k)
                    pixel[k] = static_cast<std::uint8_t>(std::lround(sum[k] / samples));
            }
    };
    // Bands of rows, each on its own, so that neither their number nor the threads change anything.
    constexpr int band = 96;
    const int bands = (view.height + band - 1) / band;
    std::atomic<int> next = 0;
    const auto work = [&] {
        for (int b = next++; b < bands; b = next++)
            paint_rows(b * band, std::min((b + 1) * band, view.height));
    };
    const unsigned threads = std::clamp(std::thread::hardware_concurrency(), 1u, 8u);
    std::vector<std::jthread> helpers;
    for (unsigned i = 1; i < threads; ++i) helpers.emplace_back(work);
    work();
}

void PictureMaker::draw_ids(render::Image& image, const State& state, const render::View& view, int right) {
    const auto height = static_cast<float>(view.height), width = static_cast<float>(view.width);
    const PicturePlace& place = *file_.annotation.ids;
    const float radius = place.radius > 0 ? static_cast<float>(place.radius) : height / 20;
    const Float2 center{static_cast<float>(place.x), static_cast<float>(place.y)};

    // The lens: a camera at the same eye that looks at the place.
    const int side = std::max(16, static_cast<int>(0.44f * std::min(width, height)));
    const float half_height = std::tan(0.5f * view.field_of_view * std::numbers::pi_v<float> / 180);
    // normalized() multiplies by the inverse, which has other last bits.
    const auto unit = [](const Float3& a) {
        const float norm = length(a);
        return Float3{a[0] / norm, a[1] / norm, a[2] / norm};
    };
    const Float3 sight = view.target - view.eye;
    const float distance = length(sight);
    const Float3 forward = unit(sight), aside = unit(cross(forward, view.up)), up = cross(aside, forward);
    const float rx = (2 * center[0] - width) / height * half_height,
                ry = (1 - 2 * center[1] / height) * half_height;
    render::View lens = view;
    lens.width = lens.height = side;
    lens.target = view.eye + distance * (forward + rx * aside + ry * up);
    const float slope = 2 * radius / height * half_height / std::sqrt(1 + rx * rx + ry * ry);
    lens.field_of_view = std::clamp(2 * std::atan(slope) * 180 / std::numbers::pi_v<float>, 1.0f, 160.0f);
    render::Image page = draw_scene(state, lens, /*with_edges=*/true);

    const render::Frame frame = builder_.build(state);
    const render::SurfaceMap map = render::map_surfaces(frame, lens, {0, 0, side, side});
    const render::Pinhole camera(lens);
    const float size = std::max(10.0f, 0.8f * text_size(image.width, image.height));
    struct Box {
        Float2 low, high;
    };
    std::vector<Box> taken;
    const std::string head = "vertices (on black), triangles (on white)";
    const float bar = render::capital_height(size) + 0.7f * size;
    const bool legend_fits = render::text_width(head, size) < static_cast<float>(side) - size;
    if (legend_fits)
        taken.push_back(
            {{0, static_cast<float>(side) - bar}, {static_cast<float>(side), static_cast<float>(side)}});
    const auto free = [&](const Box& b) {
        if (b.low[0] < 1 || b.low[1] < 1 || b.high[0] > static_cast<float>(side - 1) ||
            b.high[1] > static_cast<float>(side - 1))
            return false;
        return std::none_of(taken.begin(), taken.end(), [&](const Box& t) {
            return b.low[0] < t.high[0] && t.low[0] < b.high[0] && b.low[1] < t.high[1] &&
                   t.low[1] < b.high[1];
        });
    };
    const bool several = model_.cloths.size() > 1;
    const auto name = [&](std::size_t cloth, int number) {
        return several ? fmt::format("{}:{}", cloth, number) : fmt::format("{}", number);
    };
    /// A number on a plate, if there is room.
    const auto label = [&](const Float2& middle, const std::string& text, const Ink& ink, const Ink& plate) {
        const float half = 0.5f * render::text_width(text, size) + 0.2f * size;
        const float rise = 0.5f * render::capital_height(size) + 0.2f * size;
        const Box box{{middle[0] - half, middle[1] - rise}, {middle[0] + half, middle[1] + rise}};
        if (!free(box)) return;
        taken.push_back(box);
        render::fill_rectangle(page, box.low, box.high, plate);
        render::draw_text(page, {middle[0] - half + 0.2f * size, middle[1] + rise - 0.2f * size}, text, size,
                          ink);
    };
    const auto sample_at = [&](const Float2& p) -> const render::SurfaceSample* {
        const int x = static_cast<int>(std::floor(2 * p[0])), y = static_cast<int>(std::floor(2 * p[1]));
        return x < 0 || y < 0 || x >= 2 * side || y >= 2 * side ? nullptr : &map.at(x, y);
    };
    const auto at = [&](const render::Surface& s, int v) {
        const float* p = s.positions.data() + 3 * static_cast<std::size_t>(v);
        return camera.project({p[0], p[1], p[2]});
    };
    // Those nearest the middle first: they matter most.
    struct Mark {
        float off;
        std::size_t cloth;
        int number;
        Float2 place;
    };
    const auto by_distance = [&](std::vector<Mark>& marks) {
        std::sort(marks.begin(), marks.end(), [](const Mark& a, const Mark& b) {
            return std::tie(a.off, a.cloth, a.number) < std::tie(b.off, b.cloth, b.number);
        });
    };
    const float middle = 0.5f * static_cast<float>(side);
    const auto off = [&](const Float2& p) { return std::hypot(p[0] - middle, p[1] - middle); };
    std::vector<Mark> vertices, triangles;
    for (std::size_t c = 0; c < model_.cloths.size(); ++c) {
        const render::Surface& s = frame.surfaces[c];
        for (int v = 0; v < model_.cloths[c].vertex_count; ++v) {
            const Float3 p = at(s, v);
            const Float2 spot{p[0], p[1]};
            if (!(p[2] > 0)) continue;
            // Seen where the surface in one of the samples around it is as far away as the vertex.
            bool seen = false;
            for (const float dx : {-0.5f, 0.5f})
                for (const float dy : {-0.5f, 0.5f})
                    if (const auto* sample = sample_at({spot[0] + dx, spot[1] + dy}))
                        seen = seen || (sample->surface == static_cast<int>(c) &&
                                        std::abs(sample->depth - p[2]) < 2e-3f * p[2]);
            if (seen) vertices.push_back({off(spot), c, v, spot});
        }
        const auto parts = static_cast<int>(parts_[c].size());
        const ClothRange& range = model_.cloths[c];
        for (int t = 0; t < range.triangle_count; ++t) {
            Float2 sum{};
            bool ahead = true;
            for (int k = 0; k < 3; ++k) {
                const Float3 p = at(s, model_.triangles(range.first_triangle + t, k) - range.first_vertex);
                ahead = ahead && p[2] > 0;
                sum = {sum[0] + p[0] / 3, sum[1] + p[1] / 3};
            }
            const auto* sample = ahead ? sample_at(sum) : nullptr;
            if (sample != nullptr && sample->surface == static_cast<int>(c) && sample->triangle / parts == t)
                triangles.push_back({off(sum), c, t, sum});
        }
    }
    by_distance(vertices);
    by_distance(triangles);
    for (const Mark& m : vertices)
        render::draw_polyline(page, std::vector<Float2>{m.place}, 0.4f * size, {{20, 22, 26}});
    for (const Mark& m : vertices)
        label({m.place[0], m.place[1] - 0.75f * size}, name(m.cloth, m.number), {{255, 255, 255}},
              {{20, 22, 26}, 0.85f});
    for (const Mark& m : triangles)
        label(m.place, name(m.cloth, m.number), {{20, 60, 150}}, {{255, 255, 255}, 0.8f});

    // Right, where neither curves nor captions are, above or below the middle, where the place is not.
    const Ink rim{{20, 22, 26}};
    const float margin = 0.7f * text_size(image.width, image.height);
    const auto gap = static_cast<int>(margin);
    const int x = std::max(0, right - side - gap);
    const int y = center[1] < 0.5f * height ? view.height - side - gap : gap;
    const float ring = std::max(1.0f, height / 500);
    std::vector<Float2> circle;
    for (int i = 0; i <= 64; ++i) {
        const float angle = 2 * std::numbers::pi_v<float> * static_cast<float>(i) / 64;
        circle.push_back({center[0] + radius * std::cos(angle), center[1] + radius * std::sin(angle)});
    }
    render::draw_polyline(image, circle, ring, rim);
    const auto fx = static_cast<float>(x), fy = static_cast<float>(y), fs = static_cast<float>(side);
    render::fill_rectangle(image, {fx - 2, fy - 2}, {fx + fs + 2, fy + fs + 2}, rim);
    if (legend_fits) {
        render::fill_rectangle(page, {0, fs - bar}, {fs, fs}, {{255, 255, 255}, 0.9f});
        render::draw_text(page, {0.5f * size, fs - 0.35f * size}, head, size, {{20, 22, 26}});
    }
    render::paste(image, page, x, y);
}

std::optional<Legend> PictureMaker::legend() const {
    if (!file_.annotation.shade || !facts_.shade) return std::nullopt;
    const VertexFieldName& name = name_of(*file_.annotation.shade);
    const std::string unit = name.unit;
    return Legend{unit.empty() ? name.title : fmt::format("{} [{}]", name.title, unit), facts_.shade->low,
                  facts_.shade->high, facts_.shade->below, facts_.shade->above};
}

render::Image PictureMaker::draw(const State& state, const std::string& label, bool with_legend) {
    const AnnotationDesc& wanted = file_.annotation;
    render::View view = file_.view;
    const auto draw_at = [&](const State& s) {
        if (moves(file_.camera)) aim(view, file_.camera, s.time);
        return draw_scene(s, view, wanted.wireframe);
    };
    std::optional<State> before;
    if (wanted.motion_blur > 1 && state.frame > 0 && read_state_) before = read_state_(state.frame - 1);
    render::Image image;
    if (before && before->positions.size() == state.positions.size()) {
        std::vector<render::Image> exposures;
        State between = state;
        for (int k = 0; k < wanted.motion_blur; ++k) {
            const double s = 1.0 - wanted.shutter * (wanted.motion_blur - 1 - k + 0.5) / wanted.motion_blur;
            between.time = before->time + s * (state.time - before->time);
            between.positions = (1.0 - s) * before->positions + s * state.positions;
            between.velocities = (1.0 - s) * before->velocities + s * state.velocities;
            exposures.push_back(draw_at(between));
        }
        image = render::mean_image(exposures);
        if (moves(file_.camera)) aim(view, file_.camera, state.time);
    } else {
        image = draw_at(state);
    }
    if (!facts_.curves.empty()) draw_curves(image, facts_.times, facts_.curves, state.time);
    int right = image.width;
    if (const auto colors = legend(); colors && with_legend) right = draw_legend(image, *colors);
    if (wanted.ids) draw_ids(image, state, view, right);
    if (wanted.caption)
        draw_caption(image,
                     fill_caption(*wanted.caption, file_.name, file_.description, state.time, state.frame));
    if (!label.empty()) draw_label(image, label);
    return image;
}

}  // namespace cloth::pipeline
