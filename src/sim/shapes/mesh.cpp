#include <cmath>
#include <utility>

#include "sim/geometry/box_tree.h"
#include "sim/geometry/collide.h"
#include "sim/motion/mesh_cache.h"
#include "sim/scene/mesh.h"
#include "sim/shapes/surfaces.h"

namespace cloth {
namespace {

/// Of a point from a box, 0 inside [m].
double distance_from(const Box& box, const Vec3& p) {
    return (box.low - p).cwiseMax(p - box.high).cwiseMax(0.0).norm();
}

class MeshShape final : public ColliderShape {
  public:
    MeshShape(MeshData mesh, double offset)
        : mesh_(std::move(mesh)), offset_(offset), tree_(centres(mesh_)), boxes_(tree_.nodes.size()) {
        for (int n = static_cast<int>(boxes_.size()) - 1; n >= 0; --n) {
            const BoxTree::Node& node = tree_.nodes[n];
            if (node.left < 0) {
                for (int i = node.first; i < node.first + node.count; ++i) {
                    for (int k = 0; k < 3; ++k) boxes_[n].add(corner(tree_.order[i], k));
                }
            } else {
                boxes_[n].add(boxes_[node.left]);
                boxes_[n].add(boxes_[node.right]);
            }
        }
    }

    Surface surface() const override { return flat_surface(mesh_); }
    SurfacePoint distance(const Vec3& point) const override {
        SurfacePoint found{std::numeric_limits<double>::infinity(), Vec3::UnitY()};
        double least = found.distance, reach = found.distance;
        // More than the error of a distance: no half is left out that could hold the least one.
        const double rounding = 1e-12 * mesh_.positions.cwiseAbs().maxCoeff();
        const auto visit = [&](const auto& self, int n) -> void {
            const BoxTree::Node& node = tree_.nodes[n];
            if (node.left >= 0) {
                // The nearer half first: what it holds spares most of the other.
                const double left = distance_from(boxes_[node.left], point);
                const double right = distance_from(boxes_[node.right], point);
                if (left <= right && left <= reach) self(self, node.left);
                if (right <= reach) self(self, node.right);
                if (left > right && left <= reach) self(self, node.left);
                return;
            }
            for (int i = node.first; i < node.first + node.count; ++i) {
                const int t = tree_.order[i];
                const FourPoints x{point, corner(t, 0), corner(t, 1), corner(t, 2)};
                const Nearest nearest = nearest_vertex_face(x);
                if (!(nearest.distance_squared < least)) continue;
                least = nearest.distance_squared;
                found.distance = std::sqrt(least);
                if (least > 0.0) found.normal = nearest.difference(x) / found.distance;
                reach = found.distance + rounding;
            }
        };
        if (!boxes_.empty()) visit(visit, 0);
        return found;
    }
    ContactPrimitive primitive() const override { return triangle_primitive(mesh_, offset_); }

  private:
    static std::vector<Vec3> centres(const MeshData& mesh) {
        std::vector<Vec3> found;
        for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
            Box box;
            for (int k = 0; k < 3; ++k) box.add(Vec3(mesh.positions.row(mesh.triangles(t, k))));
            found.push_back(0.5 * (box.low + box.high));
        }
        return found;
    }
    Vec3 corner(int triangle, int k) const { return mesh_.positions.row(mesh_.triangles(triangle, k)); }

    MeshData mesh_;
    double offset_;
    BoxTree tree_;
    std::vector<Box> boxes_;  ///< one per node
};

}  // namespace

std::unique_ptr<const ColliderShape> make_bent_mesh(const ColliderDesc& collider, const Points& vertices) {
    return std::make_unique<MeshShape>(MeshData{vertices, collider.mesh->triangles}, collider.contact_offset);
}

std::unique_ptr<const ColliderShape> make_mesh(const ColliderDesc& c) {
    if (c.cache) return make_bent_mesh(c, cached_vertices(c, 0.0));
    return std::make_unique<MeshShape>(
        placed(*c.mesh, c.center, rotation_matrix(c.rotate), c.scale * length_of(c.units)), c.contact_offset);
}

}  // namespace cloth
