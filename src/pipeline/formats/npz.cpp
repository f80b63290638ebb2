#include "pipeline/formats/npz.h"

#include <fmt/format.h>

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "pipeline/formats/file_io.h"
#include "pipeline/formats/npy.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

class Npz : public Exporter {
  public:
    explicit Npz(fs::path file) : path_(std::move(file)) {}

    void begin(const ExportScene& scene) override {
        scene_ = &scene;
        file_.emplace(path_);
        velocities_.emplace(path_);
        zip_.emplace(file_->part(), path_);
        zip_->begin("positions", "<f8", motion_shape());
    }
    void frame(const ExportFrame& frame) override {
        zip_->write(bytes_of(frame.positions));
        velocities_->write(bytes_of(frame.velocities));
    }
    void end() override {
        zip_->end();
        zip_->begin("velocities", "<f8", motion_shape());
        velocities_->read_back([&](std::string_view bytes) { zip_->write(bytes); });
        zip_->end();
        velocities_.reset();
        rest();
        zip_->close();
        file_->finish();
    }

  private:
    std::vector<std::int64_t> motion_shape() const {
        return {static_cast<std::int64_t>(scene_->frames.size()), scene_->vertex_count(), 3};
    }
    static std::string_view bytes_of(const Points& points) {
        return {reinterpret_cast<const char*>(points.data()),
                static_cast<std::size_t>(points.size()) * sizeof(double)};
    }
    void rest() {
        const Topology& topology = scene_->topology;
        const auto count = static_cast<std::int64_t>(scene_->frames.size());
        std::string times, frames, rate, rest, triangles, uv, names, vertices, corners;
        for (const std::int64_t frame : scene_->frames) {
            put(times, scene_->time(frame));
            put(frames, frame);
        }
        put(rate, scene_->frame_rate);
        put_all<double>(rest, topology.rest_positions);
        put_all<std::int32_t>(triangles, topology.triangles);
        put_all<double>(uv, scene_->uv);
        std::size_t longest = 1;
        for (const ClothRange& cloth : topology.cloths) longest = std::max(longest, cloth.name.size());
        for (const ClothRange& cloth : topology.cloths) {
            names += cloth.name + std::string(longest - cloth.name.size(), '\0');
            put(vertices, std::int32_t{cloth.first_vertex});
            put(corners, std::int32_t{cloth.first_triangle});
        }
        put(vertices, std::int32_t{scene_->vertex_count()});
        put(corners, std::int32_t{scene_->triangle_count()});
        const auto cloths = static_cast<std::int64_t>(topology.cloths.size());
        zip_->array("times", "<f8", {count}, times);
        zip_->array("frames", "<i8", {count}, frames);
        zip_->array("frame_rate", "<f8", {}, rate);
        zip_->array("rest_positions", "<f8", {scene_->vertex_count(), 3}, rest);
        zip_->array("triangles", "<i4", {scene_->triangle_count(), 3}, triangles);
        zip_->array("uv", "<f8", {scene_->vertex_count(), 2}, uv);
        zip_->array("cloth_names", fmt::format("|S{}", longest), {cloths}, names);
        zip_->array("cloth_first_vertex", "<i4", {cloths + 1}, vertices);
        zip_->array("cloth_first_triangle", "<i4", {cloths + 1}, corners);
    }

    const ExportScene* scene_ = nullptr;
    fs::path path_;
    std::optional<GrowingFile> file_, velocities_;  // the second waits: a zip has one entry behind the other
    std::optional<NpzWriter> zip_;
};

}  // namespace

std::unique_ptr<Exporter> npz_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<Npz>(file);
}

}  // namespace cloth::pipeline
