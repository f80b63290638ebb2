#pragma once
// Kept frames for the page's view in three dimensions: small enough to be in it.

#include <functional>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/formats/exporter.h"
#include "pipeline/picture/survey.h"
#include "pipeline/scene_file/scene_file.h"

namespace cloth::pipeline {

/// Numbers at vertices that the view can show as colours.
struct ViewField {
    std::string name, label, unit;
    std::function<VecX(const ExportFrame&)> values;  ///< shape (n); NaN where there is none
    /// Of the colours, from all values of the run and the diagonal of the box that it goes through [m].
    std::function<ShadeRange(std::vector<double>, double)> range;
    bool log = false;  ///< colours follow the number's logarithm
};

/// Fields that pictures can be shaded by: all, but for gaps where a mesh has no quick answer or nothing
/// collides. Their ranges are those of the pictures.
std::vector<ViewField> view_fields(const SceneFile& file);

/// Takes a run as an exporter does and makes `view` of it, as view.js reads it: positions in 65,536ths of the
/// box that the cloths go through, fields in 254ths of their range. Where that takes more than `most` bytes
/// of the page it leaves out frames, and colliders whose meshes alone take half of it.
class ViewRecorder final : public Exporter {
  public:
    ViewRecorder(std::vector<ViewField> fields, std::size_t most) : fields_(std::move(fields)), most_(most) {}
    void begin(const ExportScene& scene) override;
    void frame(const ExportFrame& frame) override;
    void end() override;

    /// After end(). "data" is empty where not even one frame has room.
    const nlohmann::ordered_json& view() const { return view_; }

  private:
    struct Frame {
        std::int64_t index = 0;
        Points positions;
        std::vector<VecX> fields;
        std::vector<Points> bent;  ///< of each collider that bends
        std::vector<ColliderPose> poses;
        ExportCamera camera;
    };
    std::string data(const std::vector<Frame>& frames) const;

    std::vector<ViewField> fields_;
    std::size_t most_;
    const ExportScene* scene_ = nullptr;
    std::vector<std::size_t> colliders_;  ///< of the scene's, those that are shown
    std::vector<Frame> frames_;
    Eigen::RowVector3d low_, size_;  ///< of the box
    std::vector<ShadeRange> ranges_;
    nlohmann::ordered_json view_;
};

/// Of how many of `frames` frames with so many vertices and fields the view has one, so that about `most`
/// bytes of a page hold them: 1, 2, 3 …
int view_stride(std::size_t frames, int vertices, std::size_t fields, std::size_t most);

}  // namespace cloth::pipeline
