#include "sim/fields/vertex_fields.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <Eigen/Dense>

#include "base/parallel.h"
#include "sim/motion/placement.h"

namespace cloth {
namespace {

/// Eigenvalues of a real matrix that has real ones.
std::array<double, 2> eigenvalues(const Mat2& m) {
    const double mean = 0.5 * m.trace(), half = 0.5 * (m(0, 0) - m(1, 1));
    const double root = std::sqrt(std::max(half * half + m(0, 1) * m(1, 0), 0.0));
    return {mean + root, mean - root};
}

}  // namespace

const std::vector<VertexFieldName>& vertex_field_names() {
    static const std::vector<VertexFieldName> names{
        {VertexField::stretch, "stretch", "greatest stretch", ""},
        {VertexField::bending, "bending", "curvature", "1/m"},
        {VertexField::kinetic, "kinetic", "kinetic energy", "J/m²"},
        {VertexField::gap, "gap", "gap", "m"},
        {VertexField::strain_rate, "strain_rate", "strain rate", "1/s"}};
    return names;
}

const VertexFieldName& name_of(VertexField field) {
    return *std::find_if(vertex_field_names().begin(), vertex_field_names().end(),
                         [&](const VertexFieldName& n) { return n.field == field; });
}

VertexFields::VertexFields(const Model& model) : model_(model), densities_(model.vertex_count()) {
    patches_ = make_bending_patches(model.rest_corners, model.triangles, Vec3::UnitX());
    VecX areas = VecX::Zero(model.vertex_count());
    densities_.setZero();
    for (int t = 0; t < model.triangle_count(); ++t) {
        for (int k = 0; k < 3; ++k) {
            areas(model.triangles(t, k)) += model.triangle_areas(t);
            densities_(model.triangles(t, k)) += model.triangle_areas(t) * model.fabric(t).density;
        }
    }
    densities_.array() /= areas.array();
    for (const ColliderDesc& collider : model.scene.colliders) shapes_.push_back(make_shape(collider));
}

double VertexFields::curvature(const State& state, int t) const {
    const BendingPatch& patch = patches_[t];
    const auto x = [&](int i) { return Vec3(state.positions.segment<3>(3 * patch.vertices[i])); };
    // 2 tan(θ/2) → θ: what is folded flat has a curvature that its triangles' heights bound.
    const auto angle = [](double fold) { return 2.0 * std::atan(0.5 * fold); };
    Vec3 folds = Vec3::Zero();
    for (int i = 0; i < 3; ++i) {
        if (patch.fold_weights.col(i).isZero(0.0)) continue;  // the rim
        folds(i) =
            angle(hinge_fold(x((i + 1) % 3), x((i + 2) % 3), x(i), x(3 + i))) - angle(patch.rest_folds(i));
    }
    const Vec3 k = patch.fold_weights * folds;
    return std::sqrt(k(0) * k(0) + 2.0 * k(1) * k(1) + k(2) * k(2));
}

double VertexFields::of_triangle(VertexField field, const State& state, int t) const {
    if (field == VertexField::bending) return curvature(state, t);
    const auto gradient = [&](const VecX& q) {
        Mat32 G = Mat32::Zero();
        for (int i = 0; i < 3; ++i)
            G += q.segment<3>(3 * model_.triangles(t, i)) * model_.triangle_rest[t].b.row(i);
        return G;
    };
    const Mat32 G = gradient(state.positions);
    const Mat2 C = G.transpose() * G;
    if (field == VertexField::stretch) return std::sqrt(eigenvalues(C)[0]);
    const Mat32 rate = gradient(state.velocities);
    const Mat2 C_rate = G.transpose() * rate + rate.transpose() * G;
    const double area = C.determinant();
    if (!(area > 1e-18)) return 0.0;  // squeezed to a line: there is no rate to speak of
    const auto [a, b] = eigenvalues(0.5 * C.inverse() * C_rate);
    return std::max(std::abs(a), std::abs(b));
}

VecX VertexFields::at(VertexField field, const State& state) const {
    const int n = model_.vertex_count();
    VecX values = VecX::Zero(n);
    if (field == VertexField::kinetic) {
        for (int i = 0; i < n; ++i)
            values(i) = 0.5 * densities_(i) * state.velocities.segment<3>(3 * i).squaredNorm();
        return values;
    }
    if (field == VertexField::gap) {
        values.setConstant(std::numeric_limits<double>::quiet_NaN());
        for (std::size_t c = 0; c < model_.scene.colliders.size(); ++c) {
            if (!state.collider_on[c]) continue;
            const Placement placement = placement_at(model_.scene.colliders[c], state.time);
            const auto bent = placement.bent ? make_shape(model_.scene.colliders[c], placement) : nullptr;
            const ColliderShape& shape = bent ? *bent : *shapes_[c];
            parallel_for(n, [&](int i) {
                const Vec3 point = state.positions.segment<3>(3 * i);
                const Vec3 at_start = placement.rotation.transpose() * (point - placement.translation);
                const double gap = shape.distance(at_start).distance;
                if (!(values(i) <= gap)) values(i) = gap;
            });
        }
        return values;
    }
    VecX areas = VecX::Zero(n);
    for (int t = 0; t < model_.triangle_count(); ++t) {
        const double area = model_.triangle_areas(t), value = of_triangle(field, state, t);
        for (int i = 0; i < 3; ++i) {
            values(model_.triangles(t, i)) += area * value;
            areas(model_.triangles(t, i)) += area;
        }
    }
    return values.cwiseQuotient(areas);
}

}  // namespace cloth
