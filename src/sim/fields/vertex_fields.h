#pragma once
// What a picture can show of a state in colours: one number per vertex, from the state and the rest shape
// alone.
//
// With G the deformation gradient of a triangle over its rest plane, C = GᵀG:
//   stretch      greater principal stretch, root of C's greater eigenvalue [1]
//   bending      Frobenius norm of the change of curvature since rest, by the angles between triangles [1/m]
//   kinetic      ½ ρ |v|², ρ the mass per area of the sheet at rest [J/m²]
//   gap          distance to the nearest collider that is on [m], where it stands at the time; negative
//                inside, but for meshes; NaN where none is on
//   strain_rate  rate at which the direction that changes most changes its length [1/s]: of the eigenvalues
//                of C⁻¹ dC/dt / 2 the one of greatest magnitude, taken without sign
// What belongs to triangles is averaged at each vertex over those around it by their rest areas.

#include <memory>
#include <string_view>
#include <vector>

#include "sim/energies/bending.h"
#include "sim/model.h"
#include "sim/scene/state.h"
#include "sim/shapes/shapes.h"

namespace cloth {

enum class VertexField { stretch, bending, kinetic, gap, strain_rate };

struct VertexFieldName {
    VertexField field;
    const char *name, *title, *unit;  ///< as in scene files, for people, SI
};
const std::vector<VertexFieldName>& vertex_field_names();
const VertexFieldName& name_of(VertexField field);

class VertexFields {
  public:
    /// `model` must outlive this.
    explicit VertexFields(const Model& model);
    /// Shape (n), over all cloths.
    VecX at(VertexField field, const State& state) const;

  private:
    double of_triangle(VertexField field, const State& state, int triangle) const;
    double curvature(const State& state, int triangle) const;

    const Model& model_;
    std::vector<BendingPatch> patches_;                         ///< numbered over all vertices
    VecX densities_;                                            ///< per vertex [kg/m²]
    std::vector<std::unique_ptr<const ColliderShape>> shapes_;  ///< one per collider
};

}  // namespace cloth
