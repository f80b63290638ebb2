#pragma once
// All that contact sees of a scene.

#include <vector>

#include "sim/algebra/types.h"
#include "sim/contact/broad_phase.h"
#include "sim/model.h"

namespace cloth {

/// Everything that can touch. Constant in a run.
struct ContactSystem {
    /// A half-space; cloth vertices stay `radius` plus their own radius above it.
    struct Plane {
        int collider = 0;
        Vec3 point = Vec3::Zero(), normal = Vec3::UnitY();  ///< at the start
        double radius = 0.0, friction = 0.0;
    };
    ContactMesh mesh;              ///< cloth first
    int cloth_vertices = 0;        ///< n; the extended positions have those of colliders behind them
    VecX rest;                     ///< cloth: rest shape; colliders: as placed at the start, shape (3N) [m]
    std::vector<double> mass;      ///< of cloth vertices, shape (n) [kg]
    std::vector<double> friction;  ///< Coulomb coefficient, one per body
    std::vector<Plane> planes;
    double activation = 1e-3;     ///< ĝ [m]
    double sliding_speed = 1e-4;  ///< [m/s]
    double acceleration = 10.0;   ///< |gravity| + ĝ/dt² [m/s²]

    bool is_cloth(int vertex) const { return vertex < cloth_vertices; }
    /// The collider that a vertex belongs to; -1: none, it is cloth's.
    int collider_of(int vertex) const {
        const ContactBody& body = mesh.bodies[mesh.vertex_body[vertex]];
        return body.collider ? body.index : -1;
    }
    double radius_of(int vertex) const { return mesh.bodies[mesh.vertex_body[vertex]].radius; }
};

/// Cloths and the primitives of colliders (shapes.h).
ContactSystem make_contact_system(const Model& model);

}  // namespace cloth
