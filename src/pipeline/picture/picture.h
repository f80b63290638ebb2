#pragma once
// State → finished picture: the camera at its time, the Rasterizer's picture, colours and edges over the
// cloth, motion blur, and what is written over all of it.

#include <optional>

#include "pipeline/picture/frame_builder.h"
#include "pipeline/picture/survey.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/image/image.h"
#include "render/raster/rasterizer.h"
#include "sim/fields/vertex_fields.h"
#include "sim/model.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

class PictureMaker {
  public:
    /// `model` and `rasterizer` must outlive this; `read_state` is for motion blur.
    PictureMaker(SceneFile file, const Model& model, RunFacts facts, render::Rasterizer& rasterizer,
                 StateReader read_state = {});
    PictureMaker(const PictureMaker&) = delete;  // parts refer to each other
    PictureMaker& operator=(const PictureMaker&) = delete;

    /// `label` at the top, where there is one. Throws as Rasterizer::draw().
    render::Image draw(const State& state, const std::string& label = "", bool with_legend = true);
    /// Of the colours, where there are any.
    std::optional<Legend> legend() const;

    const SceneFile& file() const { return file_; }

  private:
    render::Image draw_scene(const State& state, const render::View& view, bool with_edges);
    void paint(render::Image& image, const render::Frame& frame, const render::View& view, const State& state,
               bool with_edges) const;
    /// `right`: the column where the legend begins.
    void draw_ids(render::Image& image, const State& state, const render::View& view, int right);

    SceneFile file_;
    const Model& model_;
    RunFacts facts_;
    render::Rasterizer& rasterizer_;
    StateReader read_state_;
    FrameBuilder builder_;
    std::optional<VertexFields> fields_;
    /// Per cloth: corners of the triangles that one simulated triangle became, in shares of its own corners.
    std::vector<std::vector<std::array<render::Float3, 3>>> parts_;
};

/// Triangle t of a surface subdivided `steps` times is part t % 4^steps of the simulated triangle t /
/// 4^steps.
std::vector<std::array<render::Float3, 3>> subdivision_parts(int steps);

}  // namespace cloth::pipeline
