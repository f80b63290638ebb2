#pragma once
// Kept frames for the page's view in three dimensions: small enough to be in it.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipeline/formats/exporter.h"

namespace cloth::pipeline {

/// Takes a run as an exporter does and makes `view` of it, as view.js reads it: positions in 65,536ths of the
/// box that the cloths go through, fields in 255ths of their range.
class ViewRecorder final : public Exporter {
  public:
    void begin(const ExportScene& scene) override;
    void frame(const ExportFrame& frame) override;
    void end() override;

    /// After end().
    const nlohmann::ordered_json& view() const { return view_; }

  private:
    struct Frame {
        Points positions;
        std::vector<VecX> fields;
        std::vector<Points> bent;  ///< of each collider that bends
        std::vector<ColliderPose> poses;
    };

    const ExportScene* scene_ = nullptr;
    std::vector<Frame> frames_;
    std::vector<std::int64_t> indices_;
    nlohmann::ordered_json view_;
};

/// Fields that the view has: quickly found, of the state alone.
const std::vector<VertexField>& view_fields();

/// Of how many of `frames` frames with so many vertices the view has one, so that its numbers stay below
/// `bytes`: 1, 2, 3 …
int view_stride(std::size_t frames, int vertices, double bytes);

}  // namespace cloth::pipeline
