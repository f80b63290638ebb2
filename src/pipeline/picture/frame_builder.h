#pragma once
// State → Frame: doubles become floats here, once.

#include <array>
#include <cstdint>
#include <vector>

#include "pipeline/picture/clearance.h"
#include "pipeline/picture/subdivision.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/frame.h"
#include "sim/model.h"
#include "sim/scene/state.h"

namespace cloth::pipeline {

/// Keeps the buffers that a Frame's spans refer to; collider meshes are made once.
class FrameBuilder {
  public:
    FrameBuilder(const SceneFile& file, const Model& model);
    /// Cloth, subdivided as its look says, with smooth area-weighted normals, colliders that are on, then the
    /// cloths' rims; ground. The smooth surface and the rims keep so near to the simulated triangles that
    /// they pass through nothing that those do not. Valid until the next call.
    render::Frame build(const State& state);
    /// How the surface of a cloth, the frame's surface of that index, follows from the simulated vertices.
    const Subdivision& subdivision(std::size_t cloth) const { return subdivisions_.at(cloth); }

  private:
    struct Mesh {
        std::vector<float> positions, normals, coordinates;
        std::vector<std::uint32_t> triangles;
    };
    /// The rolled edge of a cloth, drawn with its thickness: an upper and a lower half along each stretch of
    /// rim.
    struct Rim {
        struct Vertex {
            int at, before, after;  ///< vertices of the subdivided cloth
            Vec2 outward;           ///< in rest coordinates, unit length
        };
        std::vector<Vertex> vertices;
        std::array<Mesh, 2> halves;
    };
    Rim make_rim(const Subdivision& fine, const Mesh& cloth) const;
    /// `half`: of the thickness, at each vertex of the subdivided cloth [m].
    void place_rim(Rim& rim, const Mesh& cloth, const std::vector<double>& half) const;

    /// Where a cloth is drawn, and how thick its rim is there.
    struct Sheet {
        Points smooth;             ///< by subdivision, and its normals' source
        Points flat, drawn;        ///< on the simulated triangles; between the two
        VecX way;                  ///< from flat to smooth, one per vertex [m]
        std::vector<double> half;  ///< of the rim's thickness, one per vertex [m]
    };
    std::vector<Sheet> sheets(const State& state) const;

    struct Collider {
        Mesh mesh;
        bool endless = false;  ///< a plane
        bool floor = false;    ///< a plane that faces up
        /// A plane that stands still and level, or turns in itself: drawn as the ground, it has no edge.
        bool ground = false;
    };
    /// A collider that moves, as it stands at the start.
    struct Moving {
        int collider;
        Mesh start;
    };

    const SceneFile& file_;
    const Model& model_;
    std::vector<Mesh> cloths_;
    std::vector<Collider> colliders_;
    std::vector<Moving> moving_;
    std::vector<Rim> rims_;                  ///< one per cloth
    std::vector<Subdivision> subdivisions_;  ///< one per cloth
    Clearance clearance_;
};

}  // namespace cloth::pipeline
