#pragma once
// State → Frame: doubles become floats here, once.

#include <cstdint>
#include <vector>

#include "pipeline/scene_file.h"
#include "pipeline/subdivision.h"
#include "render/frame.h"
#include "sim/model.h"
#include "sim/state.h"

namespace cloth::pipeline {

/// Keeps the buffers that a Frame's spans refer to; collider meshes are made once.
class FrameBuilder {
  public:
    FrameBuilder(const SceneFile& file, const Model& model);
    /// Cloth, subdivided as its look says, with smooth area-weighted normals, colliders that are on, ground.
    /// Valid until the next call.
    render::Frame build(const State& state);
    /// How the surface of a cloth, the frame's surface of that index, follows from the simulated vertices.
    const Subdivision& subdivision(std::size_t cloth) const { return subdivisions_.at(cloth); }

  private:
    struct Mesh {
        std::vector<float> positions, normals;
        std::vector<std::uint32_t> triangles;
    };
    const SceneFile& file_;
    const Model& model_;
    std::vector<Mesh> cloths_, colliders_;
    std::vector<Subdivision> subdivisions_;  ///< one per cloth
};

}  // namespace cloth::pipeline
