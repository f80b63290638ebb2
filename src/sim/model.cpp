#include "sim/model.h"

#include <algorithm>
#include <limits>

#include "sim/energies/air.h"
#include "sim/energies/bending.h"
#include "sim/energies/gravity.h"
#include "sim/energies/isotropic.h"
#include "sim/energies/membrane.h"
#include "sim/energies/seam.h"
#include "sim/energies/woven.h"
#include "sim/model/possible.h"
#include "sim/scene/mesh.h"
#include "sim/scene/rest_shape.h"

namespace cloth {
namespace {

/// Moduli handed to the membrane [Pa].
std::array<double, 2> membrane_moduli(const Fabric& f) {
    if (f.mu) return {*f.mu, *f.lambda};
    // Plane stress: a sheet is free to change its thickness.
    const double E = f.young_modulus, nu = f.poisson_ratio;
    return {E / (2.0 * (1.0 + nu)), E * nu / (1.0 - nu * nu)};
}

Mat3 stiffness(const Fabric& f) {
    if (f.mu) {
        const double scale = 2.0 * *f.mu + *f.lambda;
        Mat3 C;
        C << scale, *f.lambda, 0.0, *f.lambda, scale, 0.0, 0.0, 0.0, *f.mu;
        return C;
    }
    return woven_stiffness(f.young_modulus, f.young_weft.value_or(f.young_modulus), f.poisson_ratio,
                           f.shear_modulus.value_or(f.young_modulus / (2.0 * (1.0 + f.poisson_ratio))));
}

/// Triangles of one kind of element and their constants.
template <class Rest>
struct ElementList {
    std::vector<std::array<int, 3>> triangles;
    std::vector<Rest> rest;
};

/// body(fabric, cloth, triangle) for each triangle of each cloth.
template <class Body>
void for_each_triangle(const Model& model, const Body& body) {
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothDesc& cloth = model.scene.cloths[c];
        const ClothRange& range = model.cloths[c];
        for (int t = range.first_triangle; t < range.first_triangle + range.triangle_count; ++t) {
            body(model.fabric(t), cloth, t);
        }
    }
}

std::array<int, 3> corners(const Model& model, int t) {
    return {model.triangles(t, 0), model.triangles(t, 1), model.triangles(t, 2)};
}

WovenRest woven_rest(const Model& model, const ClothDesc& cloth, int t, const Mat3& C) {
    const Points& X = model.rest_corners;
    return make_woven_rest(X.row(3 * t), X.row(3 * t + 1), X.row(3 * t + 2), cloth.warp,
                           model.fabric(t).thickness, C);
}

std::vector<TriangleRest> make_triangle_rests(const Model& model) {
    std::vector<TriangleRest> rest;
    for_each_triangle(model, [&](const Fabric& fabric, const ClothDesc&, int t) {
        const Points& X = model.rest_corners;
        const auto [mu, lambda] = membrane_moduli(fabric);
        rest.push_back(make_triangle_rest(X.row(3 * t), X.row(3 * t + 1), X.row(3 * t + 2), fabric.thickness,
                                          mu, lambda));
    });
    return rest;
}

void add_membranes(Model& model) {
    ElementList<TriangleRest> corotational, neo_hookean, limited;
    ElementList<WovenRest> woven;
    std::vector<NeoHookean> rubber;
    std::vector<StrainLimit> limits;
    for_each_triangle(model, [&](const Fabric& fabric, const ClothDesc& cloth, int t) {
        const TriangleRest& rest = model.triangle_rest[t];
        switch (fabric.membrane) {
            case MembraneKind::corotational:
                corotational.triangles.push_back(corners(model, t));
                corotational.rest.push_back(rest);
                break;
            case MembraneKind::neo_hookean:
                neo_hookean.triangles.push_back(corners(model, t));
                neo_hookean.rest.push_back(rest);
                rubber.push_back({rest.mu, rest.lambda});
                break;
            case MembraneKind::st_venant_kirchhoff:
                woven.triangles.push_back(corners(model, t));
                woven.rest.push_back(woven_rest(model, cloth, t, stiffness(fabric)));
                break;
        }
        if (fabric.strain_limit) {
            limited.triangles.push_back(corners(model, t));
            limited.rest.push_back(rest);
            limits.push_back({stiffness(fabric).diagonal().head<2>().maxCoeff(), *fabric.strain_limit});
        }
    });
    if (!corotational.rest.empty()) {
        model.energies.push_back(
            std::make_unique<MembraneEnergy>(corotational.triangles, std::move(corotational.rest)));
    }
    if (!neo_hookean.rest.empty()) {
        model.energies.push_back(std::make_unique<IsotropicEnergy<NeoHookean>>(
            "membrane", neo_hookean.triangles, std::move(neo_hookean.rest), std::move(rubber)));
    }
    if (!woven.rest.empty()) {
        model.energies.push_back(std::make_unique<WovenEnergy>(woven.triangles, std::move(woven.rest)));
    }
    if (!limited.rest.empty()) {
        model.energies.push_back(std::make_unique<IsotropicEnergy<StrainLimit>>(
            "strain limit", limited.triangles, std::move(limited.rest), std::move(limits)));
    }
}

/// Bending patches of the triangles whose fabric `wanted` names, with a rigidity each.
struct Plates {
    std::vector<BendingPatch> patches;
    std::vector<Mat3> rigidity;
    std::vector<const Fabric*> fabric;
};

template <class Wanted>
Plates make_plates(const Model& model, const Wanted& wanted) {
    Plates plates;
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        const auto bends = [&](int t) {
            const Fabric& f = model.fabric(t);
            const Mat3 D = bending_rigidity(f.bending, f.bending_weft.value_or(f.bending), f.bending_bias);
            return wanted(f) && !D.isZero(0.0) ? std::optional(D) : std::nullopt;
        };
        std::vector<std::optional<Mat3>> rigidity;
        bool any = false;
        for (int t = 0; t < range.triangle_count; ++t) {
            rigidity.push_back(bends(range.first_triangle + t));
            any = any || rigidity.back();
        }
        if (!any) continue;
        const auto patches = make_bending_patches(
            model.rest_corners.middleRows(3 * range.first_triangle, 3 * range.triangle_count),
            model.triangles.middleRows(range.first_triangle, range.triangle_count),
            model.scene.cloths[c].warp);
        for (int t = 0; t < range.triangle_count; ++t) {
            if (!rigidity[t]) continue;
            plates.patches.push_back(patches[t]);
            plates.rigidity.push_back(*rigidity[t]);
            plates.fabric.push_back(&model.fabric(range.first_triangle + t));
        }
    }
    return plates;
}

Plates make_hinged_plates(const Model& model) {
    return make_plates(model, [](const Fabric& f) { return f.bending_model == BendingKind::hinges; });
}

void add_bending(Model& model) {
    const Plates plates =
        make_plates(model, [](const Fabric& f) { return f.bending_model == BendingKind::quadratic; });
    if (plates.patches.empty()) return;
    model.energies.push_back(std::make_unique<BendingEnergy>(plates.patches, plates.rigidity));
}

/// Null where no cloth is damped.
std::unique_ptr<StageEnergy> make_membrane_viscosity(const Model& model) {
    ElementList<WovenRest> list;
    for_each_triangle(model, [&](const Fabric& fabric, const ClothDesc& cloth, int t) {
        if (fabric.membrane_damping == 0.0) return;
        list.triangles.push_back(corners(model, t));
        list.rest.push_back(woven_rest(model, cloth, t, fabric.membrane_damping * stiffness(fabric)));
    });
    if (list.rest.empty()) return nullptr;
    return std::make_unique<MembraneViscosity>(list.triangles, std::move(list.rest));
}

std::unique_ptr<StageEnergy> make_bending_viscosity(const Model& model) {
    const Plates plates = make_plates(model, [](const Fabric& f) { return f.bending_damping != 0.0; });
    if (plates.patches.empty()) return nullptr;
    std::vector<Mat3> viscosity;
    for (std::size_t k = 0; k < plates.patches.size(); ++k)
        viscosity.push_back(plates.fabric[k]->bending_damping * plates.rigidity[k]);
    return std::make_unique<BendingViscosity>(plates.patches, viscosity);
}

/// Of each hinged plate, 0: elastic [1/m].
std::vector<double> yield_curvatures(const Plates& plates) {
    std::vector<double> yield;
    for (const Fabric* fabric : plates.fabric) yield.push_back(fabric->yield_curvature.value_or(0.0));
    return yield;
}

std::vector<SeamSpring> make_seam_springs(const Model& model) {
    std::vector<SeamSpring> springs;
    for (std::size_t i = 0; i < model.scene.seams.size(); ++i) {
        const SeamDesc& seam = model.scene.seams[i];
        std::array<std::vector<int>, 2> vertices;
        std::array<Points, 2> start;
        for (int side = 0; side < 2; ++side) {
            const int c = seam.sides[side].cloth;
            const ClothDesc& cloth = model.scene.cloths[c];
            const MeshData rest = rest_shape(cloth);
            start[side] = start_positions(cloth, rest);
            vertices[side] =
                select_vertices(seam.sides[side], cloth, rest, start[side],
                                "seam[" + std::to_string(i) + "]." + (side == 0 ? "first" : "second"));
        }
        if (vertices[0].size() != vertices[1].size()) {
            throw SceneError("seam[" + std::to_string(i) + "]",
                             "sews " + std::to_string(vertices[0].size()) + " vertices to " +
                                 std::to_string(vertices[1].size()) + "; both sides need as many");
        }
        if (seam.reverse) std::reverse(vertices[1].begin(), vertices[1].end());
        for (std::size_t k = 0; k < vertices[0].size(); ++k) {
            const int a = model.cloths[seam.sides[0].cloth].first_vertex + vertices[0][k];
            const int b = model.cloths[seam.sides[1].cloth].first_vertex + vertices[1][k];
            if (a == b) {
                throw SceneError("seam[" + std::to_string(i) + "]",
                                 "sews vertex " + std::to_string(vertices[0][k]) + " to itself");
            }
            springs.push_back({a, b, seam.stiffness,
                               (start[0].row(vertices[0][k]) - start[1].row(vertices[1][k])).norm(),
                               seam.begin, seam.close_time});
        }
    }
    return springs;
}

/// Consistent mass over the pattern, and its row sums.
void assemble_mass(Model& model) {
    model.vertex_mass = VecX::Zero(model.vertex_count());
    model.mass.values.assign(model.pattern.slot_count(), 0.0);
    for (int t = 0; t < model.triangle_count(); ++t) {
        const double mass = model.fabric(t).density * model.triangle_areas(t);
        for (int i = 0; i < 3; ++i) {
            const int a = model.triangles(t, i);
            model.vertex_mass(a) += mass / 3.0;
            for (int j = 0; j < 3; ++j) {
                const int b = model.triangles(t, j);
                if (a <= b) model.mass.values[model.pattern.slot(a, b)] += mass / (i == j ? 6.0 : 12.0);
            }
        }
    }
}

}  // namespace

const Fabric& Model::fabric(int t) const {
    if (part[t] >= 0) return scene.parts[part[t]].fabric;
    std::size_t c = 0;
    while (t >= cloths[c].first_triangle + cloths[c].triangle_count) ++c;
    return scene.cloths[c].fabric;
}

std::vector<std::unique_ptr<StageEnergy>> make_stage_energies(const Model& model) {
    std::vector<std::unique_ptr<StageEnergy>> energies;
    const Plates hinged = make_hinged_plates(model);
    if (!hinged.patches.empty()) {
        energies.push_back(
            std::make_unique<HingeEnergy>(hinged.patches, hinged.rigidity, yield_curvatures(hinged)));
    }
    if (!model.scene.seams.empty())
        energies.push_back(std::make_unique<SeamEnergy>(make_seam_springs(model)));
    if (auto viscosity = make_membrane_viscosity(model)) energies.push_back(std::move(viscosity));
    if (auto viscosity = make_bending_viscosity(model)) energies.push_back(std::move(viscosity));
    const AirDesc& air = model.scene.simulation.air;
    if (air.drag > 0.0) energies.push_back(std::make_unique<AirEnergy>(model.triangles, air));
    return energies;
}

std::vector<int> select_vertices(const VertexSelection& selection, const ClothDesc& cloth,
                                 const MeshData& rest, const Points& start, const std::string& key) {
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
        const Grid* grid = cloth.rest_grid();
        if (!grid) throw SceneError(key + ".edge", "names a grid's edge; this cloth is no grid");
        const auto [nx, ny] = grid->resolution;
        const std::string& edge = *selection.edge;
        for (int v = 0; v < n; ++v) {
            const int column = v % nx, row = v / nx;
            if ((edge == "left" && column == 0) || (edge == "right" && column == nx - 1) ||
                (edge == "bottom" && row == 0) || (edge == "top" && row == ny - 1)) {
                selected.push_back(v);
            }
        }
    } else if (selection.part) {
        const MeshPart* part = find_part(rest, *selection.part);
        if (!part)
            throw SceneError(key + ".part",
                             "cloth \"" + cloth.name + "\" " + unknown_part(rest, *selection.part));
        for (const int t : part->triangles)
            for (int k = 0; k < 3; ++k) selected.push_back(rest.triangles(t, k));
        std::sort(selected.begin(), selected.end());
        selected.erase(std::unique(selected.begin(), selected.end()), selected.end());
    }
    if (selected.empty()) throw SceneError(key, "selects no vertex of the cloth's start pose");
    return selected;
}

std::vector<PinGroup> make_pin_groups(const Scene& scene, const std::vector<MeshData>& rest) {
    std::vector<int> first_vertex(1, 0);
    for (const MeshData& mesh : rest) {
        first_vertex.push_back(first_vertex.back() + static_cast<int>(mesh.positions.rows()));
    }
    std::vector<PinGroup> groups;
    for (std::size_t p = 0; p < scene.pins.size(); ++p) {
        const PinDesc& pin = scene.pins[p];
        const ClothDesc& cloth = scene.cloths[pin.cloth];
        const Points start = start_positions(cloth, rest[pin.cloth]);
        PinGroup group{.center = Vec3::Zero(), .path = pin.path, .until = pin.until};
        for (int v : select_vertices(pin, cloth, rest[pin.cloth], start, "pin[" + std::to_string(p) + "]")) {
            group.vertices.push_back(first_vertex[pin.cloth] + v);
            group.start.push_back(start.row(v));
            group.center += group.start.back();
        }
        group.center = pin.center.value_or(group.center / static_cast<double>(group.vertices.size()));
        if (pin.collider)
            group.carrier = std::make_shared<const Carrier>(scene.colliders[*pin.collider], group.start);
        groups.push_back(std::move(group));
    }
    return groups;
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
        const std::string key = "cloth[" + std::to_string(c) + "]";
        check_cloth_mesh(meshes.back(), key + ".mesh");
        if (scene.cloths[c].rest == RestShape::uv) check_uv(meshes.back(), key + ".rest");
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
    settle_lengths(model.scene, meshes);
    model.rest_corners.resize(3 * triangles, 3);
    for (std::size_t c = 0; c < meshes.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        model.rest_corners.middleRows(3 * range.first_triangle, 3 * range.triangle_count) =
            rest_corners(model.scene.cloths[c], meshes[c]);
        const std::vector<int> parts = part_of_triangles(scene, c, meshes[c]);
        model.part.insert(model.part.end(), parts.begin(), parts.end());
    }
    model.triangle_areas.resize(triangles);
    for (int t = 0; t < triangles; ++t) {
        const Vec3 a = model.rest_corners.row(3 * t), b = model.rest_corners.row(3 * t + 1),
                   c = model.rest_corners.row(3 * t + 2);
        model.triangle_areas(t) = 0.5 * (b - a).cross(c - a).norm();
    }

    require_start_within_limits(scene, meshes);
    model.pin_groups = make_pin_groups(scene, meshes);
    for (const Pin& pin : pins_of_step(model.pin_groups, 0.0, 0.0)) model.pinned.push_back(pin.vertex);

    model.triangle_rest = make_triangle_rests(model);
    add_membranes(model);
    add_bending(model);

    std::vector<std::array<int, 2>> pairs;
    for (const auto& energy : model.energies) energy->append_pairs(pairs);
    for (const auto& energy : make_stage_energies(model)) energy->append_pairs(pairs);
    model.pattern = BlockPattern(vertices, std::move(pairs));
    assemble_mass(model);
    model.weight = model.vertex_mass.norm() * scene.simulation.gravity.norm();
    model.energies.push_back(std::make_unique<GravityEnergy>(model.vertex_mass, scene.simulation.gravity));
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
    const Plates hinged = make_hinged_plates(model);
    for (double yield : yield_curvatures(hinged)) {
        if (yield > 0.0) state.rest_folds = HingeEnergy::rest_folds(hinged.patches);
    }
    return state;
}

}  // namespace cloth
