#include "pipeline/formats/point_cache.h"

#include <fmt/format.h>

#include <cstdint>
#include <limits>
#include <optional>

#include "base/text.h"
#include "pipeline/formats/error.h"
#include "pipeline/formats/file_io.h"
#include "pipeline/formats/raw_bytes.h"

namespace cloth::pipeline {

namespace fs = std::filesystem;

namespace {

enum class CacheKind { pc2, mdd };

class PointCache : public Exporter {
  public:
    PointCache(CacheKind kind, fs::path file) : kind_(kind), path_(std::move(file)) {}

    void begin(const ExportScene& scene) override {
        const auto& cloths = scene.topology.cloths;
        if (cloths.size() > 1) {
            std::vector<std::string> names;
            for (const ClothRange& cloth : cloths) names.push_back(cloth.name);
            throw Error(ExitCode::usage,
                        fmt::format("--file {}: a {} holds the vertices of one object, and the "
                                    "run has {}; name one by --cloth, of {}",
                                    path_.string(), kind_ == CacheKind::pc2 ? "PC2" : "MDD",
                                    plural(static_cast<std::int64_t>(cloths.size()), "cloth"), join(names)));
        }
        const auto samples = static_cast<std::int32_t>(scene.frames.size());
        std::string head;
        if (kind_ == CacheKind::pc2) {
            head = std::string("POINTCACHE2\0", 12);
            put(head, std::int32_t{1});
            put(head, std::int32_t{scene.vertex_count()});
            put(head, scene.frames.empty() ? 0.0f : static_cast<float>(scene.frames.front()));
            put(head, 1.0f);
            put(head, samples);
        } else {
            put_big_endian(head, samples);
            put_big_endian(head, std::int32_t{scene.vertex_count()});
            for (const std::int64_t frame : scene.frames)
                put_big_endian(head, static_cast<float>(scene.time(frame)));
        }
        file_.emplace(path_);
        file_->write(head);
    }
    void frame(const ExportFrame& frame) override {
        std::string bytes;
        bytes.reserve(static_cast<std::size_t>(frame.positions.size()) * sizeof(float));
        for (Eigen::Index i = 0; i < frame.positions.size(); ++i) {
            const auto number = static_cast<float>(frame.positions.data()[i]);
            if (kind_ == CacheKind::pc2) {
                put(bytes, number);
            } else {
                put_big_endian(bytes, number);
            }
        }
        file_->write(bytes);
    }
    void end() override { file_->finish(); }

  private:
    CacheKind kind_;
    fs::path path_;
    std::optional<GrowingFile> file_;
};

}  // namespace

std::unique_ptr<Exporter> pc2_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<PointCache>(CacheKind::pc2, file);
}

std::unique_ptr<Exporter> mdd_exporter(const fs::path& file, FrameNames /*names*/) {
    return std::make_unique<PointCache>(CacheKind::mdd, file);
}

}  // namespace cloth::pipeline
