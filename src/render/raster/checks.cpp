#include "render/raster/checks.h"

#include <stdexcept>
#include <string>
#include <utility>

#include "render/raster/projection.h"

namespace cloth::render {
namespace {

constexpr int smallest_side = 16, largest_side = 8192;

std::string text(const Float3& a) {
    return "(" + std::to_string(a[0]) + ", " + std::to_string(a[1]) + ", " + std::to_string(a[2]) + ")";
}

[[noreturn]] void refuse(const std::string& message) {
    throw std::invalid_argument(message);
}

}  // namespace

void require_view(const View& view) {
    for (const int side : {view.width, view.height})
        if (side < smallest_side || side > largest_side)
            refuse("view: a size of " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                   " pixels; each side must be " + std::to_string(smallest_side) + " to " +
                   std::to_string(largest_side));
    for (const auto& [name, value] : {std::pair{"eye", view.eye},
                                      {"target", view.target},
                                      {"up", view.up},
                                      {"light.direction", view.light.direction}})
        if (!finite(value)) refuse("view: " + std::string(name) + " " + text(value) + " is not finite");
    const Float3 forward = view.target - view.eye;
    if (!(length(forward) > 1e-6f))
        refuse("view: eye and target are both at " + text(view.eye) +
               "; they must be apart to look anywhere");
    if (!(length(cross(normalized(forward), view.up)) > 1e-4f * length(view.up)) || !(length(view.up) > 0))
        refuse("view: up " + text(view.up) + " is parallel to the line of sight " + text(forward));
    if (!(view.field_of_view >= 1 && view.field_of_view <= 160))
        refuse("view: a field of view of " + std::to_string(view.field_of_view) +
               " degrees; it must be 1 to 160");
    if (!(length(view.light.direction) > 0)) refuse("view: the light's direction is zero");
    if (!(view.light.softness >= 0) || !std::isfinite(view.light.softness))
        refuse("view: a shadow softness of " + std::to_string(view.light.softness) +
               " m; it must be 0 or more");
    if (!(view.light.angle >= 0 && view.light.angle <= 45))
        refuse("view: a light of " + std::to_string(view.light.angle) + " degrees; it must be 0 to 45");
    if (!(view.exposure >= 0) || !std::isfinite(view.exposure))
        refuse("view: an exposure of " + std::to_string(view.exposure) + "; it must be 0 or more");
}

void require_ground(const Ground& ground) {
    if (!std::isfinite(ground.height)) refuse("the ground's height is not finite");
}

Bounds checked_bounds(const Surface& surface, std::size_t number) {
    const std::string name = "surface " + std::to_string(number) + ": ";
    if (surface.positions.size() % 3 != 0 || surface.normals.size() != surface.positions.size())
        refuse(name + std::to_string(surface.positions.size()) + " position and " +
               std::to_string(surface.normals.size()) + " normal components; both must be 3 per vertex");
    if (surface.triangles.size() % 3 != 0)
        refuse(name + std::to_string(surface.triangles.size()) +
               " triangle indices; there must be 3 per triangle");
    const std::size_t vertices = surface.positions.size() / 3;
    if (!surface.coordinates.empty() && surface.coordinates.size() != 2 * vertices)
        refuse(name + std::to_string(surface.coordinates.size()) +
               " rest coordinates; there must be none or 2 per vertex");
    if (!surface.colors.empty() && surface.colors.size() != 3 * vertices)
        refuse(name + std::to_string(surface.colors.size()) +
               " colour components; there must be none or 3 per vertex");
    for (std::size_t i = 0; i < surface.triangles.size(); ++i)
        if (surface.triangles[i] >= vertices)
            refuse(name + "triangle " + std::to_string(i / 3) + " names vertex " +
                   std::to_string(surface.triangles[i]) + " of " + std::to_string(vertices));
    const Material& m = surface.material;
    if (m.pattern != Pattern::plain && !(m.pattern_scale > 0))
        refuse(name + "a pattern scale of " + std::to_string(m.pattern_scale) + " m; it must be above 0");
    if (m.pattern == Pattern::image && !m.image) refuse(name + "an image pattern without an image");
    if (!(m.weave >= 0)) refuse(name + "a weave of " + std::to_string(m.weave) + " m; it must be 0 or more");
    Bounds b = nothing;
    for (std::size_t v = 0; v < vertices; ++v) {
        const Float3 p{surface.positions[3 * v], surface.positions[3 * v + 1], surface.positions[3 * v + 2]};
        if (!finite(p)) refuse(name + "the position of vertex " + std::to_string(v) + " is not finite");
        b = merged(b, {p, p});
    }
    return b;
}

Bounds shadow_bounds(const View& view, const Bounds& casting) {
    if (view.shadow_bounds) {
        const auto& [a, b] = *view.shadow_bounds;
        if (!finite(a) || !finite(b))
            refuse("view: shadow bounds " + text(a) + ", " + text(b) + " are not finite");
        return merged({a, a}, {b, b});
    }
    return casting.low[0] <= casting.high[0] ? widened(casting) : casting;
}

}  // namespace cloth::render
