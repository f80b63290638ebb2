#include "sim/model.h"

#include <algorithm>
#include <limits>

#include "sim/bending.h"
#include "sim/gravity.h"
#include "sim/membrane.h"
#include "sim/mesh.h"

namespace cloth {
namespace {

/// Moduli handed to the membrane [Pa].
std::array<double, 2> membrane_moduli(const Fabric& f) {
    if (f.mu) return {*f.mu, *f.lambda};
    // Plane stress: a sheet is free to change its thickness.
    const double E = f.young_modulus, nu = f.poisson_ratio;
    return {E / (2.0 * (1.0 + nu)), E * nu / (1.0 - nu * nu)};
}

MeshData rest_shape(const ClothDesc& cloth) {
    return cloth.mesh ? *cloth.mesh : make_grid(cloth.grid);
}

std::unique_ptr<MembraneEnergy> make_membrane(const Model& model) {
    std::vector<std::array<int, 3>> stencils;
    std::vector<TriangleRest> rest;
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const Fabric& fabric = model.scene.cloths[c].fabric;
        const auto [mu, lambda] = membrane_moduli(fabric);
        const ClothRange& range = model.cloths[c];
        for (int t = range.first_triangle; t < range.first_triangle + range.triangle_count; ++t) {
            const std::array<int, 3> v{model.triangles(t, 0), model.triangles(t, 1), model.triangles(t, 2)};
            stencils.push_back(v);
            rest.push_back(make_triangle_rest(model.rest_positions.row(v[0]), model.rest_positions.row(v[1]),
                                              model.rest_positions.row(v[2]), fabric.thickness, mu, lambda));
        }
    }
    return std::make_unique<MembraneEnergy>(std::move(stencils), std::move(rest));
}

/// Null where no cloth resists bending.
std::unique_ptr<BendingEnergy> make_bending(const Model& model) {
    std::vector<BendingPatch> patches;
    std::vector<double> rigidity;
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const double D = model.scene.cloths[c].fabric.bending;
        if (D == 0.0) continue;
        const ClothRange& range = model.cloths[c];
        for (const BendingPatch& patch :
             make_bending_patches(model.rest_positions,
                                  model.triangles.middleRows(range.first_triangle, range.triangle_count))) {
            patches.push_back(patch);
            rigidity.push_back(D);
        }
    }
    if (patches.empty()) return nullptr;
    return std::make_unique<BendingEnergy>(patches, rigidity);
}

/// Consistent mass over the pattern, and the row sums (shape n) that gravity acts on.
VecX assemble_mass(Model& model) {
    VecX lumped = VecX::Zero(model.vertex_count());
    model.mass.values.assign(model.pattern.slot_count(), 0.0);
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        for (int t = range.first_triangle; t < range.first_triangle + range.triangle_count; ++t) {
            const double mass = model.scene.cloths[c].fabric.density * model.triangle_areas(t);
            for (int i = 0; i < 3; ++i) {
                const int a = model.triangles(t, i);
                lumped(a) += mass / 3.0;
                for (int j = 0; j < 3; ++j) {
                    const int b = model.triangles(t, j);
                    if (a <= b) model.mass.values[model.pattern.slot(a, b)] += mass / (i == j ? 6.0 : 12.0);
                }
            }
        }
    }
    return lumped;
}

std::vector<PinGroup> make_pin_groups(const Scene& scene, const Model& model,
                                      const std::vector<MeshData>& meshes) {
    std::vector<PinGroup> groups;
    for (std::size_t p = 0; p < scene.pins.size(); ++p) {
        const PinDesc& pin = scene.pins[p];
        const ClothDesc& cloth = scene.cloths[pin.cloth];
        const Points start = start_positions(cloth, meshes[pin.cloth]);
        PinGroup group{.center = Vec3::Zero(), .path = pin.path, .until = pin.until};
        for (int v : select_vertices(pin, start, "pin[" + std::to_string(p) + "]",
                                     cloth.mesh ? nullptr : &cloth.grid)) {
            group.vertices.push_back(model.cloths[pin.cloth].first_vertex + v);
            group.start.push_back(start.row(v));
            group.center += group.start.back();
        }
        group.center = pin.center.value_or(group.center / static_cast<double>(group.vertices.size()));
        groups.push_back(std::move(group));
    }
    return groups;
}

}  // namespace

std::vector<std::unique_ptr<StageEnergy>> make_stage_energies(const Model&) {
    return {};
}

std::vector<int> select_vertices(const VertexSelection& selection, const Points& start,
                                 const std::string& key, const Grid* grid) {
    const int n = static_cast<int>(start.rows());
    std::vector<int> selected;
    if (!selection.vertices.empty()) {
        for (int v : selection.vertices) {
            if (v < 0 || v >= n) {
                throw SceneError(key + ".vertices", "vertex " + std::to_string(v) +
                                                        " does not exist; the cloth has vertices 0 … " +
                                                        std::to_string(n - 1));
            }
            selected.push_back(v);
        }
    } else if (selection.box) {
        for (int v = 0; v < n; ++v) {
            const Vec3 p = start.row(v);
            if ((p.array() >= (*selection.box)[0].array()).all() &&
                (p.array() <= (*selection.box)[1].array()).all()) {
                selected.push_back(v);
            }
        }
    } else if (selection.nearest) {
        Eigen::Index nearest = 0;
        (start.rowwise() - selection.nearest->transpose()).rowwise().squaredNorm().minCoeff(&nearest);
        selected.push_back(static_cast<int>(nearest));
    } else if (selection.greatest) {
        const double sign = selection.greatest->front() == '-' ? -1.0 : 1.0;
        const int axis = selection.greatest->back() - 'x';
        const double extreme = (sign * start.col(axis)).maxCoeff();
        for (int v = 0; v < n; ++v) {
            if (sign * start(v, axis) >= extreme - selection.tolerance) selected.push_back(v);
        }
    } else if (selection.edge) {
        if (!grid) throw SceneError(key + ".edge", "names a grid's edge; this cloth is a mesh");
        const auto [nx, ny] = grid->resolution;
        const std::string& edge = *selection.edge;
        for (int v = 0; v < n; ++v) {
            const int column = v % nx, row = v / nx;
            if ((edge == "left" && column == 0) || (edge == "right" && column == nx - 1) ||
                (edge == "bottom" && row == 0) || (edge == "top" && row == ny - 1)) {
                selected.push_back(v);
            }
        }
    }
    if (selected.empty()) throw SceneError(key, "selects no vertex of the cloth's start pose");
    return selected;
}

Model build_model(const Scene& scene) {
    validate(scene);
    Model model;
    model.scene = scene;
    std::stable_sort(model.scene.events.begin(), model.scene.events.end(),
                     [](const EventDesc& a, const EventDesc& b) { return a.time < b.time; });
    model.steps_per_frame = scene.simulation.steps_per_frame();
    model.time_step = scene.simulation.step_size();

    std::vector<MeshData> meshes;
    int vertices = 0, triangles = 0;
    for (std::size_t c = 0; c < scene.cloths.size(); ++c) {
        meshes.push_back(rest_shape(scene.cloths[c]));
        check_cloth_mesh(meshes.back(), "cloth[" + std::to_string(c) + "].mesh");
        ClothRange range{scene.cloths[c].name, vertices, static_cast<int>(meshes[c].positions.rows()),
                         triangles, static_cast<int>(meshes[c].triangles.rows())};
        vertices += range.vertex_count;
        triangles += range.triangle_count;
        model.cloths.push_back(range);
    }
    model.rest_positions.resize(vertices, 3);
    model.triangles.resize(triangles, 3);
    for (std::size_t c = 0; c < meshes.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        model.rest_positions.middleRows(range.first_vertex, range.vertex_count) = meshes[c].positions;
        model.triangles.middleRows(range.first_triangle, range.triangle_count) =
            meshes[c].triangles.array() + range.first_vertex;
    }
    model.triangle_areas.resize(triangles);
    for (int t = 0; t < triangles; ++t) {
        const Vec3 a = model.rest_positions.row(model.triangles(t, 0));
        const Vec3 b = model.rest_positions.row(model.triangles(t, 1));
        const Vec3 c = model.rest_positions.row(model.triangles(t, 2));
        model.triangle_areas(t) = 0.5 * (b - a).cross(c - a).norm();
    }

    model.pin_groups = make_pin_groups(scene, model, meshes);
    for (const Pin& pin : pins_of_step(model.pin_groups, 0.0, 0.0)) model.pinned.push_back(pin.vertex);

    auto membrane = make_membrane(model);
    model.membrane = membrane.get();
    model.energies.push_back(std::move(membrane));
    if (auto bending = make_bending(model)) model.energies.push_back(std::move(bending));

    std::vector<std::array<int, 2>> pairs;
    for (const auto& energy : model.energies) energy->append_pairs(pairs);
    model.pattern = BlockPattern(vertices, std::move(pairs));
    const VecX lumped = assemble_mass(model);
    model.weight = lumped.norm() * scene.simulation.gravity.norm();
    model.energies.push_back(std::make_unique<GravityEnergy>(lumped, scene.simulation.gravity));
    for (const auto& energy : model.energies) energy->bind(model.pattern);
    return model;
}

State start_state(const Model& model) {
    State state;
    state.positions.resize(3 * model.vertex_count());
    state.velocities.resize(3 * model.vertex_count());
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothDesc& cloth = model.scene.cloths[c];
        const ClothRange& range = model.cloths[c];
        MeshData rest;
        rest.positions = model.rest_positions.middleRows(range.first_vertex, range.vertex_count);
        const Points start = start_positions(cloth, rest);
        for (int i = 0; i < range.vertex_count; ++i) {
            state.positions.segment<3>(3 * (range.first_vertex + i)) = start.row(i).transpose();
            state.velocities.segment<3>(3 * (range.first_vertex + i)) = cloth.velocity;
        }
    }
    for (int v : model.pinned) state.velocities.segment<3>(3 * v).setZero();
    state.integrator = model.scene.simulation.integrator;
    for (const ColliderDesc& collider : model.scene.colliders) state.collider_on.push_back(collider.enabled);
    state.drags.resize(model.scene.drags.size());
    return state;
}

}  // namespace cloth
