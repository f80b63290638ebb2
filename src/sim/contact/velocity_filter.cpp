#include "sim/contact/velocity_filter.h"

#include <algorithm>

#include "sim/assignment/assignment.h"
#include "sim/shapes/shapes.h"

namespace cloth {

std::vector<FilterContact> find_filter_contacts(const std::vector<ColliderDesc>& colliders,
                                                const std::vector<std::uint8_t>& collider_on, const VecX& q) {
    std::vector<FilterContact> contacts;
    for (std::size_t c = 0; c < colliders.size(); ++c) {
        if (!collider_on[c]) continue;
        const ColliderDesc& collider = colliders[c];
        const ContactPrimitive primitive = make_shape(collider)->primitive();
        if (primitive.half_space) {
            const auto& [point, normal] = *primitive.half_space;
            for (int i = 0; i < q.size() / 3; ++i) {
                if (normal.dot(q.segment<3>(3 * i) - point) < primitive.radius) {
                    contacts.push_back({i, normal, collider.friction});
                }
            }
            continue;
        }
        const SphereContacts found =
            collision_detection_cloth_sphere(q, primitive.points.front(), primitive.radius);
        for (std::size_t k = 0; k < found.vertices.size(); ++k) {
            contacts.push_back({found.vertices[k], found.normals[k], collider.friction});
        }
    }
    return contacts;
}

void filter_velocities(const std::vector<FilterContact>& contacts, VecX& qdot) {
    for (const FilterContact& contact : contacts) {
        auto v = qdot.segment<3>(3 * contact.vertex);
        const double inward = contact.normal.dot(v);
        if (inward >= 0.0) continue;
        v -= inward * contact.normal;
        const double sliding = v.norm();
        if (contact.friction > 0.0 && sliding > 0.0) {
            v *= std::max(0.0, 1.0 + contact.friction * inward / sliding);
        }
    }
}

}  // namespace cloth
