#include "pipeline/page/view_data.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <memory>
#include <stdexcept>

#include "pipeline/formats/base64.h"
#include "pipeline/formats/raw_bytes.h"
#include "pipeline/picture/survey.h"
#include "render/image/colormap.h"

namespace cloth::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// As zlib has it.
std::string deflated(const std::string& bytes) {
    constexpr int level = 6;
    const std::unique_ptr<libdeflate_compressor, decltype(&libdeflate_free_compressor)> compressor(
        libdeflate_alloc_compressor(level), &libdeflate_free_compressor);
    if (!compressor) throw std::runtime_error("there is no memory to compress the page's frames");
    std::string packed(libdeflate_zlib_compress_bound(compressor.get(), bytes.size()), '\0');
    packed.resize(
        libdeflate_zlib_compress(compressor.get(), bytes.data(), bytes.size(), packed.data(), packed.size()));
    return packed;
}

void put_triangles(std::string& bytes, const Triangles& triangles) {
    for (Eigen::Index t = 0; t < triangles.rows(); ++t)
        for (int k = 0; k < 3; ++k) put(bytes, static_cast<std::int32_t>(triangles(t, k)));
}

struct Box {
    Eigen::RowVector3d low, size;
};

/// Shares of the box, less those before, which take their place.
void put_rolled(std::string& bytes, const Points& positions, const Box& box,
                std::vector<std::uint16_t>& last) {
    const auto n = static_cast<std::size_t>(positions.rows());
    last.resize(3 * n, 0);
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        for (std::size_t v = 0; v < n; ++v) {
            const double share = (positions(static_cast<Eigen::Index>(v), k) - box.low(k)) / box.size(k);
            const auto now = static_cast<std::uint16_t>(std::lround(65535.0 * std::clamp(share, 0.0, 1.0)));
            put(bytes, static_cast<std::uint16_t>(now - last[axis * n + v]));
            last[axis * n + v] = now;
        }
    }
}

/// Of three.js: columns behind each other.
Json matrix_of(const Placement& placement) {
    Mat4 m = Mat4::Identity();
    m.topLeftCorner<3, 3>() = placement.rotation;
    m.topRightCorner<3, 1>() = placement.translation;
    return std::vector<double>(m.data(), m.data() + 16);
}

/// Linear light to what screens show.
std::array<double, 3> color_of(const render::Float3& linear) {
    std::array<double, 3> color{};
    for (std::size_t k = 0; k < 3; ++k)
        color[k] = std::pow(std::clamp(double{linear[k]}, 0.0, 1.0), 1.0 / 2.2);
    return color;
}

}  // namespace

const std::vector<VertexField>& view_fields() {
    static const std::vector<VertexField> fields{VertexField::stretch, VertexField::bending,
                                                 VertexField::kinetic};
    return fields;
}

int view_stride(std::size_t frames, int vertices, double bytes) {
    const double per_frame = (6.0 + static_cast<double>(view_fields().size())) * vertices;
    return std::max(1, static_cast<int>(std::ceil(per_frame * static_cast<double>(frames) / bytes)));
}

void ViewRecorder::begin(const ExportScene& scene) {
    scene_ = &scene;
}

void ViewRecorder::frame(const ExportFrame& frame) {
    Frame& kept = frames_.emplace_back();
    kept.positions = frame.positions;
    for (const VertexField field : view_fields()) kept.fields.push_back(frame.field(field));
    kept.poses = frame.colliders;
    for (const ColliderPose& pose : frame.colliders) {
        kept.bent.push_back(pose.bent ? pose.bent->positions : Points());
        if (pose.bent) kept.poses[kept.bent.size() - 1].bent.reset();
    }
    indices_.push_back(frame.index);
}

void ViewRecorder::end() {
    const int n = scene_->vertex_count();
    Box box{Eigen::RowVector3d::Constant(std::numeric_limits<double>::infinity()), {}};
    Eigen::RowVector3d high = -box.low;
    const auto include = [&](const Points& points) {
        if (points.rows() == 0) return;
        box.low = box.low.cwiseMin(points.colwise().minCoeff());
        high = high.cwiseMax(points.colwise().maxCoeff());
    };
    for (const Frame& frame : frames_) {
        include(frame.positions);
        for (const Points& bent : frame.bent) include(bent);
    }
    box.size = (high - box.low).cwiseMax(1e-9);

    std::vector<ShadeRange> ranges;
    Json fields = Json::array();
    for (std::size_t k = 0; k < view_fields().size(); ++k) {
        std::vector<double> values;
        for (const Frame& frame : frames_)
            values.insert(values.end(), frame.fields[k].begin(), frame.fields[k].end());
        const VertexFieldName& name = name_of(view_fields()[k]);
        ranges.push_back(shade_range(view_fields()[k], std::move(values), box.size.norm()));
        fields.push_back({{"name", name.name},
                          {"label", name.title},
                          {"unit", name.unit},
                          {"low", ranges.back().low},
                          {"high", ranges.back().high}});
    }

    std::string bytes;
    put_triangles(bytes, scene_->topology.triangles);
    Json colliders = Json::array(), cloths = Json::array();
    for (std::size_t c = 0; c < scene_->colliders.size(); ++c) {
        const ExportCollider& collider = scene_->colliders[c];
        const Points& points = collider.surface.positions;
        for (Eigen::Index v = 0; v < points.rows(); ++v)
            for (int k = 0; k < 3; ++k) put(bytes, static_cast<float>(points(v, k)));
        put_triangles(bytes, collider.surface.triangles);
        Json poses = Json::array();
        for (const Frame& frame : frames_)
            poses.push_back(frame.poses[c].on ? matrix_of(frame.poses[c].placement) : Json());
        colliders.push_back({{"vertices", points.rows()},
                             {"triangles", collider.surface.triangles.rows()},
                             {"color", color_of(collider.material.front)},
                             {"bends", collider.bends},
                             {"poses", std::move(poses)}});
    }
    for (std::size_t c = 0; c < scene_->topology.cloths.size(); ++c)
        cloths.push_back({{"first", scene_->topology.cloths[c].first_vertex},
                          {"count", scene_->topology.cloths[c].vertex_count},
                          {"color", color_of(scene_->materials[c].front)}});
    std::vector<std::uint16_t> last;
    std::vector<std::vector<std::uint16_t>> last_bent(scene_->colliders.size());
    for (const Frame& frame : frames_) {
        put_rolled(bytes, frame.positions, box, last);
        for (std::size_t k = 0; k < frame.fields.size(); ++k) {
            const auto [low, high_value] = std::pair(ranges[k].low, ranges[k].high);
            for (const double value : frame.fields[k]) {
                const double share = (value - low) / (high_value - low);
                put(bytes,
                    static_cast<std::uint8_t>(share > 0.0 ? std::lround(255.0 * std::min(share, 1.0)) : 0));
            }
        }
        for (std::size_t c = 0; c < frame.bent.size(); ++c)
            if (scene_->colliders[c].bends) put_rolled(bytes, frame.bent[c], box, last_bent[c]);
    }
    std::string colors;
    for (int i = 0; i < 256; ++i)
        for (const std::uint8_t part : render::viridis(i / 255.0)) colors += static_cast<char>(part);
    view_ = {{"frames", indices_},
             {"low", std::vector<double>(box.low.data(), box.low.data() + 3)},
             {"size", std::vector<double>(box.size.data(), box.size.data() + 3)},
             {"vertices", n},
             {"triangles", scene_->triangle_count()},
             {"cloths", std::move(cloths)},
             {"colliders", std::move(colliders)},
             {"fields", std::move(fields)},
             {"colors", base64(colors)},
             {"every", 1},
             {"data", base64(deflated(bytes))}};
    frames_.clear();
}

}  // namespace cloth::pipeline
