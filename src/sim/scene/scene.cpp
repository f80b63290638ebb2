#include "sim/scene/scene.h"

#include <cmath>
#include <cstdio>
#include <set>

namespace cloth {
namespace {

std::string number(double value) {
    char text[32];
    std::snprintf(text, sizeof text, "%.6g", value);
    return text;
}

std::string item(const char* table, std::size_t index, const char* key = "") {
    return std::string(table) + "[" + std::to_string(index) + "]" + (*key ? std::string(".") + key : "");
}

void require(bool good, const std::string& key, const std::string& message) {
    if (!good) throw SceneError(key, message);
}

void require_finite(const Vec3& v, const std::string& key) {
    require(v.allFinite(), key, "must be finite numbers");
}

void require_positive(double value, const std::string& key, const char* unit) {
    require(std::isfinite(value) && value > 0.0, key,
            "is " + number(value) + "; must be greater than 0" + (*unit ? std::string(" ") + unit : ""));
}

void require_not_negative(double value, const std::string& key, const char* unit) {
    require(std::isfinite(value) && value >= 0.0, key,
            "is " + number(value) + "; must be at least 0" + (*unit ? std::string(" ") + unit : ""));
}

void validate_simulation(const SimulationDesc& s) {
    require_finite(s.gravity, "simulation.gravity");
    require_positive(s.frame_rate, "simulation.frame_rate", "1/s");
    require(s.frame_rate <= 1e6, "simulation.frame_rate",
            "is " + number(s.frame_rate) + "; must be at most 1e6 1/s");
    require(!(s.time_step && s.substeps), "simulation.time_step",
            "stands beside simulation.substeps; give one of the two");
    if (s.time_step) {
        require_positive(*s.time_step, "simulation.time_step", "s");
        require(1.0 / (s.frame_rate * *s.time_step) <= 1e6, "simulation.time_step",
                "is " + number(*s.time_step) + " s, more than a million steps per frame");
    }
    if (s.substeps) {
        require(*s.substeps >= 1 && *s.substeps <= 1000000, "simulation.substeps",
                "is " + std::to_string(*s.substeps) + "; must be 1 … 1000000");
    }
    require_positive(s.contact_stiffness, "simulation.contact_stiffness", "N/m");
    if (s.sliding_speed) require_positive(*s.sliding_speed, "simulation.sliding_speed", "m/s");
    require_positive(s.contact_activation, "simulation.contact_activation", "m");
    require(s.newton_iterations >= 1, "simulation.newton_iterations",
            "is " + std::to_string(s.newton_iterations) + "; must be at least 1");
    require(s.retries >= 0 && s.retries <= 20, "simulation.retries",
            "is " + std::to_string(s.retries) + "; must be 0 … 20");
    require(s.newton_tolerance > 0.0 && s.newton_tolerance < 1.0, "simulation.newton_tolerance",
            "is " + number(s.newton_tolerance) + "; must lie between 0 and 1");
    require(s.newton_speed >= 0.0 && std::isfinite(s.newton_speed), "simulation.newton_speed",
            "is " + number(s.newton_speed) + " m/s; must be at least 0 m/s");
}

void validate_fabric(const Fabric& f, const std::string& key) {
    require_positive(f.density, key + ".density", "kg/m²");
    require_positive(f.thickness, key + ".thickness", "m");
    require(f.mu.has_value() == f.lambda.has_value(), key + (f.mu ? ".mu" : ".lambda"),
            "mu and lambda are given together or not at all");
    if (f.mu) {
        require_positive(*f.mu, key + ".mu", "Pa");
        require(std::isfinite(*f.lambda) && *f.mu + *f.lambda > 0.0, key + ".lambda",
                "is " + number(*f.lambda) + " Pa; mu + lambda must be greater than 0");
    }
    require_positive(f.young_modulus, key + ".young_modulus", "Pa");
    require(f.poisson_ratio > -1.0 && f.poisson_ratio < 1.0, key + ".poisson_ratio",
            "is " + number(f.poisson_ratio) + "; must lie between -1 and 1 (plane stress)");
    const bool woven = f.young_weft || f.shear_modulus;
    if (woven) {
        require(f.membrane == MembraneKind::st_venant_kirchhoff,
                key + (f.young_weft ? ".young_weft" : ".shear_modulus"),
                "needs membrane = \"st_venant_kirchhoff\", the one that knows warp and weft");
        require(!f.mu, key + ".mu", "stands beside young_weft or shear_modulus; give one or the other");
    }
    if (f.young_weft) {
        require_positive(*f.young_weft, key + ".young_weft", "Pa");
        const double bound = std::sqrt(f.young_modulus / *f.young_weft);
        require(std::abs(f.poisson_ratio) < bound, key + ".poisson_ratio",
                "is " + number(f.poisson_ratio) + "; must lie between -" + number(bound) + " and " +
                    number(bound) + ", the root of young_modulus / young_weft");
    }
    if (f.shear_modulus) require_positive(*f.shear_modulus, key + ".shear_modulus", "Pa");
    if (f.strain_limit) {
        require(std::isfinite(*f.strain_limit) && *f.strain_limit > 1.0, key + ".strain_limit",
                "is " + number(*f.strain_limit) + "; must be above 1, a stretch such as 1.05");
    }
    require_not_negative(f.bending, key + ".bending", "N m");
    if (f.bending_weft) require_not_negative(*f.bending_weft, key + ".bending_weft", "N m");
    if (f.bending_bias) {
        const double least = 0.25 * (f.bending + f.bending_weft.value_or(f.bending));
        require(std::isfinite(*f.bending_bias) && *f.bending_bias >= least, key + ".bending_bias",
                "is " + number(*f.bending_bias) + "; must be at least " + number(least) +
                    " N m, a quarter of warp's plus weft's, or the sheet would gain energy by bending");
    }
    if (f.yield_curvature) {
        require_positive(*f.yield_curvature, key + ".yield_curvature", "1/m");
        require(f.bending_model == BendingKind::hinges, key + ".yield_curvature",
                "needs bending_model = \"hinges\", the one with rest angles");
    }
    require_not_negative(f.membrane_damping, key + ".membrane_damping", "s");
    require_not_negative(f.bending_damping, key + ".bending_damping", "s");
    require_not_negative(f.friction, key + ".friction", "");
}

/// Strain limits and hinges need an integrator that searches along its steps.
void validate_integrators(const Scene& scene) {
    bool linear = scene.simulation.integrator == IntegratorKind::linearly_implicit_euler;
    bool midpoint = scene.simulation.integrator == IntegratorKind::implicit_midpoint;
    for (const EventDesc& e : scene.events) {
        linear = linear || e.toggle_integrator || e.integrator == IntegratorKind::linearly_implicit_euler;
        midpoint = midpoint || e.integrator == IntegratorKind::implicit_midpoint;
    }
    if (!linear && !midpoint) return;
    require(
        scene.simulation.contact != ContactKind::barrier, "simulation.contact",
        "is \"barrier\", which needs integrator = \"implicit_euler\" or \"tr_bdf2\" throughout: the others "
        "end a step where nothing has looked for collisions");
    for (std::size_t i = 0; i < scene.cloths.size(); ++i) {
        require(!scene.cloths[i].fabric.strain_limit, item("cloth", i, "fabric.strain_limit"),
                "needs integrator = \"implicit_euler\" or \"tr_bdf2\" throughout; set it to 0 to leave the "
                "limit out");
    }
}

void validate_cloth(const ClothDesc& c, std::size_t i) {
    require(!(c.mesh && c.disc), item("cloth", i, "mesh"), "stands beside radius; give one rest shape");
    if (c.disc) {
        require_positive(c.disc->radius, item("cloth", i, "radius"), "m");
        require(c.disc->rings >= 1 && c.disc->rings <= 1000, item("cloth", i, "rings"),
                "is " + std::to_string(c.disc->rings) + "; must be 1 … 1000");
    } else if (!c.mesh) {
        for (int a = 0; a < 2; ++a) require_positive(c.grid.size(a), item("cloth", i, "size"), "m");
        for (int r : c.grid.resolution) {
            require(r >= 2 && r <= 4096, item("cloth", i, "resolution"),
                    "is " + std::to_string(r) + "; must be 2 … 4096 vertices");
        }
    }
    const Eigen::Index vertices = c.mesh   ? c.mesh->positions.rows()
                                  : c.disc ? 1 + 3 * Eigen::Index{c.disc->rings} * (c.disc->rings + 1)
                                           : Eigen::Index{c.grid.resolution[0]} * c.grid.resolution[1];
    if (c.pose) {
        require(c.pose->rows() == vertices, item("cloth", i, "pose"),
                "has " + std::to_string(c.pose->rows()) + " vertices; the rest shape has " +
                    std::to_string(vertices));
        require(c.pose->allFinite(), item("cloth", i, "pose"), "has coordinates that are not finite");
    }
    require_positive(c.transform.scale, item("cloth", i, "scale"), "");
    require_finite(c.transform.rotate, item("cloth", i, "rotate"));
    require_finite(c.transform.translate, item("cloth", i, "translate"));
    require_finite(c.velocity, item("cloth", i, "velocity"));
    require_positive(c.contact_thickness, item("cloth", i, "contact_thickness"), "m");
    require(std::isfinite(c.bump), item("cloth", i, "bump"), "must be a finite number");
    require_finite(c.warp, item("cloth", i, "warp"));
    require(c.warp.norm() > 0.0, item("cloth", i, "warp"), "is zero; must point along the rest shape");
    validate_fabric(c.fabric, item("cloth", i, "fabric"));
}

void validate_motion(const std::vector<MotionKey>& path, const std::string& key) {
    for (std::size_t k = 0; k < path.size(); ++k) {
        require_not_negative(path[k].time, key, "s");
        require_finite(path[k].translate, key);
        require_finite(path[k].rotate, key);
        require(k == 0 || path[k].time > path[k - 1].time, key, "has times that do not increase");
    }
}

void validate_collider(const ColliderDesc& c, std::size_t i, bool barrier) {
    require_finite(c.center, item("collider", i, "center"));
    require_finite(c.normal, item("collider", i, "normal"));
    require(c.shape != Shape::plane || c.normal.norm() > 0.0, item("collider", i, "normal"),
            "is zero; must point out of the plane");
    require_positive(c.radius, item("collider", i, "radius"), "m");
    require_not_negative(c.contact_offset, item("collider", i, "contact_offset"), "m");
    if (c.contact_radius) {
        require_positive(*c.contact_radius, item("collider", i, "contact_radius"), "m");
        require(c.shape == Shape::sphere, item("collider", i, "contact_radius"),
                "belongs to a sphere; a plane has contact_offset");
        require(c.contact_offset == 0.0, item("collider", i, "contact_radius"),
                "stands beside contact_offset; give one of the two");
    }
    require_not_negative(c.friction, item("collider", i, "friction"), "");
    require_positive(c.height, item("collider", i, "height"), "m");
    for (int a = 0; a < 3; ++a) require_positive(c.size(a), item("collider", i, "size"), "m");
    require_positive(c.scale, item("collider", i, "scale"), "");
    require_finite(c.rotate, item("collider", i, "rotate"));
    require(c.shape != Shape::plane || c.rotate.isZero(0.0), item("collider", i, "rotate"),
            "turns no plane; give its normal");
    require_finite(c.spin, item("collider", i, "spin"));
    validate_motion(c.path, item("collider", i, "path"));
    require(c.shape != Shape::mesh || c.mesh, item("collider", i, "mesh"),
            "is missing; shape = \"mesh\" needs a file");
    if (barrier || !c.touchable) return;
    require(has_one_curvature(c.shape), item("collider", i, "shape"),
            "needs contact = \"barrier\"; the others know spheres and planes");
    require(c.path.empty() && c.spin.isZero(0.0), item("collider", i, c.path.empty() ? "spin" : "path"),
            "needs contact = \"barrier\"; the others know colliders at rest");
}

void validate_selection(const VertexSelection& s, const std::string& key) {
    const int selections = !s.vertices.empty() + s.box.has_value() + s.nearest.has_value() +
                           s.greatest.has_value() + s.edge.has_value();
    require(selections == 1, key, "give exactly one of vertices, box, nearest, greatest, edge");
    if (s.box) {
        require_finite((*s.box)[0], key + ".box");
        require_finite((*s.box)[1], key + ".box");
        require(((*s.box)[0].array() <= (*s.box)[1].array()).all(), key + ".box",
                "has a lower corner above its upper one");
    }
    if (s.nearest) require_finite(*s.nearest, key + ".nearest");
    if (s.greatest) {
        static const std::set<std::string> directions{"x", "y", "z", "-x", "-y", "-z"};
        require(directions.count(*s.greatest) == 1, key + ".greatest",
                "is \"" + *s.greatest + "\"; must be one of x, y, z, -x, -y, -z");
    }
    if (s.edge) {
        static const std::set<std::string> edges{"left", "right", "bottom", "top"};
        require(edges.count(*s.edge) == 1, key + ".edge",
                "is \"" + *s.edge + "\"; must be one of left, right, bottom, top");
    }
    require_not_negative(s.tolerance, key + ".tolerance", "m");
}

void validate_cloth_index(int cloth, const std::string& key, std::size_t cloths) {
    require(cloth >= 0 && static_cast<std::size_t>(cloth) < cloths, key, "there is no such cloth");
}

void validate_pin(const PinDesc& p, std::size_t i, std::size_t cloths) {
    validate_cloth_index(p.cloth, item("pin", i, "cloth"), cloths);
    validate_selection(p, item("pin", i));
    validate_motion(p.path, item("pin", i, "path"));
    if (p.center) require_finite(*p.center, item("pin", i, "center"));
    if (p.until) require_positive(*p.until, item("pin", i, "until"), "s");
}

void validate_seam(const SeamDesc& s, std::size_t i, std::size_t cloths) {
    for (int side = 0; side < 2; ++side) {
        const std::string key = item("seam", i, side == 0 ? "first" : "second");
        validate_cloth_index(s.sides[side].cloth, key + ".cloth", cloths);
        validate_selection(s.sides[side], key);
    }
    require_not_negative(s.begin, item("seam", i, "begin"), "s");
    require_positive(s.close_time, item("seam", i, "close_time"), "s");
    require_positive(s.stiffness, item("seam", i, "stiffness"), "N/m");
}

void validate_air(const AirDesc& a) {
    require_positive(a.density, "air.density", "kg/m³");
    require_not_negative(a.drag, "air.drag", "");
    require_not_negative(a.lift, "air.lift", "");
    require(a.lift <= a.drag, "air.lift",
            "is " + number(a.lift) + "; must be at most the drag, " + number(a.drag) +
                ", or the air would push a sheet that stands still in it");
    require_finite(a.wind, "air.wind");
    require_not_negative(a.gusts, "air.gusts", "m/s");
    require_positive(a.gust_length, "air.gust_length", "m");
}

void validate_drag(const DragDesc& d, std::size_t i) {
    require(d.path.size() >= 2, item("drag", i, "path"),
            "needs at least two keys [time, x, y]: press and release");
    for (std::size_t k = 0; k < d.path.size(); ++k) {
        require(std::isfinite(d.path[k].time) && d.path[k].pixel.allFinite(), item("drag", i, "path"),
                "must be finite numbers");
        require(k == 0 || d.path[k].time > d.path[k - 1].time, item("drag", i, "path"),
                "has times that do not increase");
    }
    require_not_negative(d.path.front().time, item("drag", i, "path"), "s");
    require_not_negative(d.radius, item("drag", i, "radius"), "m");
    require_positive(d.stiffness, item("drag", i, "stiffness"), "N/m");
    for (int a = 0; a < 2; ++a) require_positive(d.viewport(a), item("drag", i, "viewport"), "pixel");
}

void validate_event(const EventDesc& e, std::size_t i, std::size_t colliders) {
    require_not_negative(e.time, item("event", i, "time"), "s");
    require(e.collider.has_value() + e.toggle_integrator + e.integrator.has_value() == 1, item("event", i),
            "give either a collider or an integrator");
    if (e.collider) {
        require(*e.collider >= 0 && static_cast<std::size_t>(*e.collider) < colliders,
                item("event", i, "collider"), "there is no such collider");
    }
}

}  // namespace

int SimulationDesc::steps_per_frame() const {
    if (substeps) return *substeps;
    if (!time_step) return 1;
    // The slack keeps 1 / (60 · 0.0166666667) at one step.
    return std::max(1, static_cast<int>(std::ceil(1.0 / (frame_rate * *time_step) * (1.0 - 1e-6))));
}

void validate(const Scene& scene) {
    validate_simulation(scene.simulation);
    require(!scene.cloths.empty(), "cloth", "the scene has no [[cloth]]");
    for (std::size_t i = 0; i < scene.cloths.size(); ++i) validate_cloth(scene.cloths[i], i);
    const bool barrier = scene.simulation.contact == ContactKind::barrier;
    for (std::size_t i = 0; i < scene.colliders.size(); ++i)
        validate_collider(scene.colliders[i], i, barrier);
    for (std::size_t i = 0; i < scene.pins.size(); ++i) validate_pin(scene.pins[i], i, scene.cloths.size());
    for (std::size_t i = 0; i < scene.seams.size(); ++i) {
        validate_seam(scene.seams[i], i, scene.cloths.size());
    }
    validate_air(scene.simulation.air);
    for (std::size_t i = 0; i < scene.drags.size(); ++i) validate_drag(scene.drags[i], i);
    for (std::size_t i = 0; i < scene.events.size(); ++i) {
        validate_event(scene.events[i], i, scene.colliders.size());
    }
    validate_integrators(scene);
}

}  // namespace cloth
