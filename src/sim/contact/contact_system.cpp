#include "sim/contact/contact_system.h"

#include "sim/shapes/shapes.h"

namespace cloth {

ContactSystem make_contact_system(const Model& model) {
    const Scene& scene = model.scene;
    ContactSystem s;
    std::vector<Vec3> rest;
    for (std::size_t c = 0; c < model.cloths.size(); ++c) {
        const ClothRange& range = model.cloths[c];
        std::vector<std::array<int, 3>> triangles;
        for (int t = range.first_triangle; t < range.first_triangle + range.triangle_count; ++t) {
            triangles.push_back({model.triangles(t, 0) - range.first_vertex,
                                 model.triangles(t, 1) - range.first_vertex,
                                 model.triangles(t, 2) - range.first_vertex});
        }
        s.mesh.add_body({false, static_cast<int>(c), 0.5 * *scene.cloths[c].contact_thickness},
                        range.vertex_count, triangles);
        s.friction.push_back(scene.cloths[c].fabric.friction);
    }
    s.cloth_vertices = model.vertex_count();
    for (int v = 0; v < s.cloth_vertices; ++v) rest.push_back(model.rest_positions.row(v));
    s.mass.assign(model.vertex_mass.begin(), model.vertex_mass.end());
    for (std::size_t c = 0; c < scene.colliders.size(); ++c) {
        const ColliderDesc& collider = scene.colliders[c];
        const ContactPrimitive primitive = make_shape(collider)->primitive();
        if (primitive.half_space) {
            s.planes.push_back({static_cast<int>(c), primitive.half_space->point,
                                primitive.half_space->normal, primitive.radius, collider.friction});
            continue;
        }
        s.mesh.add_body({true, static_cast<int>(c), primitive.radius},
                        static_cast<int>(primitive.points.size()), primitive.triangles, primitive.segments);
        rest.insert(rest.end(), primitive.points.begin(), primitive.points.end());
        s.friction.push_back(collider.friction);
    }
    s.rest.resize(3 * rest.size());
    for (std::size_t v = 0; v < rest.size(); ++v) s.rest.segment<3>(3 * v) = rest[v];
    s.activation = *scene.simulation.contact_activation;
    s.sliding_speed = scene.simulation.sliding_speed.value_or(1e-4);
    s.acceleration = scene.simulation.gravity.norm() + s.activation / (model.time_step * model.time_step);
    return s;
}

}  // namespace cloth
