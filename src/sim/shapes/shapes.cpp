#include "sim/shapes/shapes.h"

namespace cloth {

// Each stands in the file of its name.
std::unique_ptr<const ColliderShape> make_sphere(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_plane(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_box(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_capsule(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_cylinder(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_mesh(const ColliderDesc&);
std::unique_ptr<const ColliderShape> make_bent_mesh(const ColliderDesc&, const Points& vertices);

std::unique_ptr<const ColliderShape> make_shape(const ColliderDesc& collider) {
    switch (collider.shape) {
        case Shape::sphere:
            return make_sphere(collider);
        case Shape::plane:
            return make_plane(collider);
        case Shape::box:
            return make_box(collider);
        case Shape::capsule:
            return make_capsule(collider);
        case Shape::cylinder:
            return make_cylinder(collider);
        case Shape::mesh:
            return make_mesh(collider);
    }
    return nullptr;
}

std::unique_ptr<const ColliderShape> make_shape(const ColliderDesc& collider, const Placement& placement) {
    return placement.bent ? make_bent_mesh(collider, *placement.bent) : make_shape(collider);
}

}  // namespace cloth
