#pragma once
// All that is constant while a simulation runs.

#include <memory>
#include <string>
#include <vector>

#include "sim/algebra/block_matrix.h"
#include "sim/algebra/types.h"
#include "sim/energies/energy.h"
#include "sim/energies/membrane.h"
#include "sim/motion/pins.h"
#include "sim/scene/scene.h"
#include "sim/scene/state.h"

namespace cloth {

/// A cloth's share of the common vertex and triangle lists.
struct ClothRange {
    std::string name;
    int first_vertex = 0, vertex_count = 0;
    int first_triangle = 0, triangle_count = 0;
};

struct Model {
    Scene scene;            ///< events sorted by time, lengths settled (mesh.h)
    Points rest_positions;  ///< shape (n, 3), all cloths one after another [m]
    Triangles triangles;    ///< shape (m, 3), into all vertices
    Points rest_corners;    ///< shape (3m, 3), each triangle's own (rest_shape.h) [m]
    std::vector<ClothRange> cloths;
    std::vector<int> part;  ///< per triangle, into Scene::parts; -1: of the cloth's own fabric
    VecX triangle_areas;    ///< shape (m), at rest [m²]
    std::vector<PinGroup> pin_groups;
    std::vector<int> pinned;  ///< at the start; sorted, without repeats
    BlockPattern pattern;     ///< of mass and Hessians
    ScalarBlockMatrix mass;   ///< consistent mass [kg]
    VecX vertex_mass;         ///< its row sums, shape (n) [kg]
    double weight = 0.0;      ///< |gravity force| over all vertices, for the scale of residuals [N]
    std::vector<std::unique_ptr<Energy>> energies;  ///< the sum that a step minimises
    std::vector<TriangleRest> triangle_rest;        ///< per triangle, for stretches
    double time_step = 0.0;                         ///< [s]
    int steps_per_frame = 1;

    /// Of a triangle.
    const Fabric& fabric(int t) const;

    int vertex_count() const { return static_cast<int>(rest_positions.rows()); }
    int triangle_count() const { return static_cast<int>(triangles.rows()); }
};

/// Validates the scene and lists its energies; throws SceneError.
Model build_model(const Scene& scene);

/// Terms of the sum that depend on the step.
std::vector<std::unique_ptr<StageEnergy>> make_stage_energies(const Model& model);

/// State at time 0.
State start_state(const Model& model);

/// Vertices selected of a cloth whose rest shape is `rest` and that stands at `start`, numbered within it;
/// throws SceneError where there are none.
std::vector<int> select_vertices(const VertexSelection& selection, const ClothDesc& cloth,
                                 const MeshData& rest, const Points& start, const std::string& key);

/// What each [[pin]] holds; throws SceneError where one selects nothing. `rest`: one per cloth.
std::vector<PinGroup> make_pin_groups(const Scene& scene, const std::vector<MeshData>& rest);

}  // namespace cloth
