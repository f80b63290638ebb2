#pragma once
// What writes a run in a format of meshes, frame by frame; and what it is told of the run.

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/formats/state_store.h"
#include "render/frame.h"
#include "sim/fields/vertex_fields.h"
#include "sim/motion/placement.h"
#include "sim/scene/scene.h"
#include "sim/shapes/shapes.h"

namespace cloth::pipeline {

/// A collider that pictures show, where it stands without keys and spin.
struct ExportCollider {
    std::string name;
    Surface surface;  ///< of one that bends, as it is at time 0
    render::Material material;
    bool bends = false;
};

/// What is the same in all frames.
struct ExportScene {
    std::string name;  ///< the scene's
    Topology topology;
    TexturePoints uv;                         ///< one row a vertex
    std::vector<render::Material> materials;  ///< one per cloth
    std::vector<ExportCollider> colliders;
    double frame_rate = 60.0;                  ///< frames per second of simulated time
    double aspect = 1.0;                       ///< a picture's width over its height
    std::vector<std::int64_t> frames;          ///< all that will come, in rising order
    std::vector<VertexFieldName> fields = {};  ///< those that ExportFrame::field() has

    int vertex_count() const { return static_cast<int>(topology.rest_positions.rows()); }
    int triangle_count() const { return static_cast<int>(topology.triangles.rows()); }
    /// k / frame_rate [s].
    double time(std::int64_t frame) const { return static_cast<double>(frame) / frame_rate; }
    /// The corners of a cloth's triangles, counted from its first vertex.
    Triangles triangles_of(const ClothRange& cloth) const {
        return topology.triangles.middleRows(cloth.first_triangle, cloth.triangle_count).array() -
               cloth.first_vertex;
    }
};

/// How a collider stands in a frame.
struct ColliderPose {
    bool on = true;
    Placement placement;
    std::optional<Surface> bent = {};  ///< of one that bends: before the placement, of the same triangles
};

/// Where pictures are taken from.
struct ExportCamera {
    Vec3 position, target, up;
    double field_of_view;  ///< vertical [degree]

    /// Columns: to its right, up, and back from what it looks at.
    Mat3 axes() const {
        const Vec3 back = (position - target).normalized();
        const Vec3 right = up.cross(back).normalized();
        Mat3 R;
        R << right, back.cross(right), back;
        return R;
    }
};

struct ExportFrame {
    std::int64_t index;
    double time;                          ///< [s]
    Points positions, velocities;         ///< shape (n, 3) [m], [m/s]
    std::vector<ColliderPose> colliders;  ///< one for each of the scene's
    ExportCamera camera;
    std::function<VecX(VertexField)> field;  ///< one number a vertex
};

/// begin(), then frame() for each frame in rising order, then end(). Its files appear under their names in
/// end(); one that is destroyed without leaves none. Each call throws Error(other) naming the file that
/// cannot be written, and the cause; begin() throws Error(usage) where the format cannot hold what the scene
/// has.
class Exporter {
  public:
    Exporter() = default;
    Exporter(const Exporter&) = delete;
    Exporter& operator=(const Exporter&) = delete;
    virtual ~Exporter() = default;

    /// `scene` must live until end().
    virtual void begin(const ExportScene& scene) = 0;
    virtual void frame(const ExportFrame& frame) = 0;
    virtual void end() = 0;
};

}  // namespace cloth::pipeline
