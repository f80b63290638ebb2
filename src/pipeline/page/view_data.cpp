#include "pipeline/page/view_data.h"

#include <libdeflate.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "pipeline/formats/base64.h"
#include "pipeline/formats/raw_bytes.h"
#include "render/image/colormap.h"

namespace cloth::pipeline {
namespace {

using Json = nlohmann::ordered_json;

/// Byte of a field where there is no number; all below are shares of its range.
constexpr int no_number = 255;

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

/// Shares of the box, less those before, which take their place. Lower bytes and higher ones of an axis stand
/// apart: most of the higher are alike.
void put_rolled(std::string& bytes, const Points& positions, const Eigen::RowVector3d& low,
                const Eigen::RowVector3d& size, std::vector<std::uint16_t>& last) {
    const auto n = static_cast<std::size_t>(positions.rows());
    last.resize(3 * n, 0);
    std::string higher(n, '\0');
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto k = static_cast<Eigen::Index>(axis);
        for (std::size_t v = 0; v < n; ++v) {
            const double share = (positions(static_cast<Eigen::Index>(v), k) - low(k)) / size(k);
            const auto now = static_cast<std::uint16_t>(std::lround(65535.0 * std::clamp(share, 0.0, 1.0)));
            const auto step = static_cast<std::uint16_t>(now - last[axis * n + v]);
            bytes += static_cast<char>(step & 255U);
            higher[v] = static_cast<char>(step >> 8U);
            last[axis * n + v] = now;
        }
        bytes += higher;
    }
}

std::uint8_t shade_of(double value, const ShadeRange& range, bool log) {
    if (std::isnan(value)) return no_number;
    double share = (value - range.low) / (range.high - range.low);
    if (log) share = value > range.low ? std::log(value / range.low) / std::log(range.high / range.low) : 0.0;
    return static_cast<std::uint8_t>(std::lround((no_number - 1) * std::clamp(share, 0.0, 1.0)));
}

/// Of three.js: columns behind each other.
Json matrix_of(const Placement& placement) {
    Mat4 m = Mat4::Identity();
    m.topLeftCorner<3, 3>() = placement.rotation;
    m.topRightCorner<3, 1>() = placement.translation;
    Json numbers = Json::array();
    for (const double x : m.reshaped()) numbers.push_back(std::round(1e7 * x) / 1e7);
    return numbers;
}

Json camera_of(const ExportCamera& c) {
    return {c.position.x(), c.position.y(), c.position.z(), c.target.x(), c.target.y(),
            c.target.z(),   c.up.x(),       c.up.y(),       c.up.z(),     c.field_of_view};
}

/// One for each frame, or one alone where that is the same in all.
Json unrepeated(Json list) {
    if (std::all_of(list.begin(), list.end(), [&](const Json& each) { return each == list.front(); }))
        return list.empty() ? list : Json::array({list.front()});
    return list;
}

/// Linear light to what screens show.
std::array<double, 3> color_of(const render::Float3& linear) {
    std::array<double, 3> color{};
    for (std::size_t k = 0; k < 3; ++k)
        color[k] = std::pow(std::clamp(double{linear[k]}, 0.0, 1.0), 1.0 / 2.2);
    return color;
}

std::size_t bytes_of(const Surface& surface) {
    return 12 * static_cast<std::size_t>(surface.positions.rows() + surface.triangles.rows());
}

/// What a page needs of a view's bytes: they are compressed a little, and written as text.
std::size_t text_of(std::size_t bytes) {
    return bytes * 9 / 10;
}

}  // namespace

std::vector<ViewField> view_fields(const SceneFile& file) {
    const auto& colliders = file.scene.colliders;
    const bool gaps = !colliders.empty() && std::none_of(colliders.begin(), colliders.end(),
                                                         [](const auto& c) { return c.mesh.has_value(); });
    std::vector<ViewField> fields;
    for (const VertexFieldName& name : vertex_field_names()) {
        const VertexField field = name.field;
        if (field == VertexField::gap && !gaps) continue;
        const auto given = file.annotation.shade == field ? facts_of(file).shade : std::nullopt;
        fields.push_back({name.name, name.title, name.unit,
                          [field](const ExportFrame& frame) { return frame.field(field); },
                          [field, given](std::vector<double> values, double diagonal) {
                              return given ? *given : shade_range(field, std::move(values), diagonal);
                          }});
    }
    return fields;
}

int view_stride(std::size_t frames, int vertices, std::size_t fields, std::size_t most) {
    const std::size_t per_frame = text_of((6 + fields) * static_cast<std::size_t>(vertices));
    return std::max(1, static_cast<int>((per_frame * frames + most - 1) / most));
}

void ViewRecorder::begin(const ExportScene& scene) {
    scene_ = &scene;
    std::size_t all = 0;
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        colliders_.push_back(c);
        all += bytes_of(scene.colliders[c].surface);
    }
    const auto size_of = [&](std::size_t c) { return bytes_of(scene.colliders[c].surface); };
    Json left_out = Json::array();
    while (text_of(all) > most_ / 2 && !colliders_.empty()) {
        const auto largest =
            std::max_element(colliders_.begin(), colliders_.end(),
                             [&](std::size_t a, std::size_t b) { return size_of(a) < size_of(b); });
        all -= size_of(*largest);
        left_out.push_back(scene.colliders[*largest].name);
        colliders_.erase(largest);
    }
    view_["left_out"] = std::move(left_out);
}

void ViewRecorder::frame(const ExportFrame& frame) {
    Frame& kept = frames_.emplace_back();
    kept.index = frame.index;
    kept.positions = frame.positions;
    kept.camera = frame.camera;
    for (const ViewField& field : fields_) kept.fields.push_back(field.values(frame));
    for (const std::size_t c : colliders_) {
        ColliderPose pose = frame.colliders[c];
        kept.bent.push_back(pose.bent ? pose.bent->positions : Points());
        pose.bent.reset();
        kept.poses.push_back(std::move(pose));
    }
}

std::string ViewRecorder::data(const std::vector<Frame>& frames) const {
    std::string bytes;
    put_triangles(bytes, scene_->topology.triangles);
    for (const std::size_t c : colliders_) {
        const Surface& surface = scene_->colliders[c].surface;
        put_all<float>(bytes, surface.positions);
        put_triangles(bytes, surface.triangles);
    }
    std::vector<std::uint16_t> last;
    std::vector<std::vector<std::uint16_t>> last_bent(colliders_.size());
    for (const Frame& frame : frames) {
        put_rolled(bytes, frame.positions, low_, size_, last);
        for (std::size_t k = 0; k < fields_.size(); ++k)
            for (const double value : frame.fields[k])
                put(bytes, shade_of(value, ranges_[k], fields_[k].log));
        for (std::size_t c = 0; c < colliders_.size(); ++c)
            if (scene_->colliders[colliders_[c]].bends)
                put_rolled(bytes, frame.bent[c], low_, size_, last_bent[c]);
    }
    return base64(deflated(bytes));
}

void ViewRecorder::end() {
    low_ = Eigen::RowVector3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::RowVector3d high = -low_;
    const auto include = [&](const Points& points) {
        if (points.rows() == 0) return;
        low_ = low_.cwiseMin(points.colwise().minCoeff());
        high = high.cwiseMax(points.colwise().maxCoeff());
    };
    for (const Frame& frame : frames_) {
        include(frame.positions);
        for (const Points& bent : frame.bent) include(bent);
    }
    size_ = (high - low_).cwiseMax(1e-9);

    Json fields = Json::array();
    for (std::size_t k = 0; k < fields_.size(); ++k) {
        std::vector<double> values;
        for (const Frame& frame : frames_)
            values.insert(values.end(), frame.fields[k].begin(), frame.fields[k].end());
        const ShadeRange range = fields_[k].range(std::move(values), size_.norm());
        ranges_.push_back(range);
        fields.push_back({{"name", fields_[k].name},
                          {"label", fields_[k].label},
                          {"unit", fields_[k].unit},
                          {"low", range.low},
                          {"high", range.high},
                          {"below", range.below},
                          {"above", range.above},
                          {"log", fields_[k].log}});
    }

    std::size_t every = 1;
    std::string packed = data(frames_);
    while (packed.size() > most_ && frames_.size() > 1) {
        const std::size_t step = std::max<std::size_t>(2, (packed.size() + most_ - 1) / most_);
        std::vector<Frame> fewer;
        for (std::size_t f = 0; f < frames_.size(); f += step) fewer.push_back(std::move(frames_[f]));
        frames_ = std::move(fewer);
        every *= step;
        packed = data(frames_);
    }
    if (packed.size() > most_) packed.clear();

    Json indices = Json::array(), cameras = Json::array(), colliders = Json::array(), cloths = Json::array();
    for (const Frame& frame : frames_) {
        indices.push_back(frame.index);
        cameras.push_back(camera_of(frame.camera));
    }
    for (std::size_t c = 0; c < colliders_.size(); ++c) {
        const ExportCollider& collider = scene_->colliders[colliders_[c]];
        Json poses = Json::array();
        for (const Frame& frame : frames_)
            poses.push_back(frame.poses[c].on ? matrix_of(frame.poses[c].placement) : Json());
        colliders.push_back({{"vertices", collider.surface.positions.rows()},
                             {"triangles", collider.surface.triangles.rows()},
                             {"color", color_of(collider.material.front)},
                             {"bends", collider.bends},
                             {"poses", unrepeated(std::move(poses))}});
    }
    for (std::size_t c = 0; c < scene_->topology.cloths.size(); ++c)
        cloths.push_back({{"first", scene_->topology.cloths[c].first_vertex},
                          {"count", scene_->topology.cloths[c].vertex_count},
                          {"color", color_of(scene_->materials[c].front)}});
    std::string colors;
    for (int i = 0; i <= no_number; ++i) {
        const double share = i == no_number ? std::nan("") : i / (no_number - 1.0);
        for (const std::uint8_t part : render::viridis(share)) colors += static_cast<char>(part);
    }
    view_["frames"] = std::move(indices);
    view_["every"] = every;
    view_["low"] = std::vector<double>(low_.data(), low_.data() + 3);
    view_["size"] = std::vector<double>(size_.data(), size_.data() + 3);
    view_["vertices"] = scene_->vertex_count();
    view_["triangles"] = scene_->triangle_count();
    view_["aspect"] = scene_->aspect;
    view_["cameras"] = unrepeated(std::move(cameras));
    view_["cloths"] = std::move(cloths);
    view_["colliders"] = std::move(colliders);
    view_["fields"] = std::move(fields);
    view_["colors"] = base64(colors);
    view_["data"] = std::move(packed);
    frames_.clear();
}

}  // namespace cloth::pipeline
