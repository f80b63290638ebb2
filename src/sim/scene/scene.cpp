#include "sim/scene/scene.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "sim/scene/schema.h"

namespace cloth {

// ---------------------------------------------------------------- ranges

std::string number_text(double value) {
    char text[32];
    const bool whole = value == std::floor(value) && std::abs(value) < 1e15;
    std::snprintf(text, sizeof text, "%.6g", value);
    const std::string shortest = text;
    // 1e9 says more than a row of noughts.
    const bool round = std::abs(value) > 1e6 && std::strtod(text, nullptr) == value;
    if (whole && !round) {
        std::snprintf(text, sizeof text, "%.0f", value);
        return text;
    }
    const std::size_t e = shortest.find('e');
    if (e == std::string::npos) return shortest;
    // 1e-06 → 1e-6
    const std::size_t digits = shortest.find_first_not_of("+-0", e + 1);
    return shortest.substr(0, e + 1) + (shortest[e + 1] == '-' ? "-" : "") + shortest.substr(digits);
}

bool Range::holds(double value) const {
    return std::isfinite(value) && (above ? value > low : value >= low) &&
           (below ? value < high : value <= high);
}

std::string Range::words() const {
    const bool floor = std::isfinite(low), ceiling = std::isfinite(high);
    if (!floor && !ceiling) return "must be a finite number";
    if (above && below) return "must lie between " + number_text(low) + " and " + number_text(high);
    if (above && ceiling) {
        return "must be greater than " + number_text(low) + " and at most " + number_text(high);
    }
    if (floor && ceiling) return "must be " + number_text(low) + " … " + number_text(high);
    return std::string("must be ") + (above ? "greater than " : "at least ") + number_text(low);
}

std::string Range::brief() const {
    const bool floor = std::isfinite(low), ceiling = std::isfinite(high);
    if (!floor && !ceiling) return "";
    if (above && below) return number_text(low) + " < … < " + number_text(high);
    if (above && ceiling)
        return "> " + number_text(low) + ", ≤ " + number_text(high) +
               (zero_is_none && !holds(0.0) ? " or 0" : "");
    if (floor && ceiling && low == -high) return "±" + number_text(high);
    if (floor && ceiling)
        return number_text(low) + " … " + number_text(high) + (zero_is_none && !holds(0.0) ? " or 0" : "");
    return (above ? "> " : "≥ ") + number_text(low) + (zero_is_none && !holds(0.0) ? " or 0" : "");
}

std::string Range::refusal(double value, const std::string& unit) const {
    return "is " + number_text(value) + (std::isfinite(value) ? "; " : ", not finite; ") + words() +
           (unit.empty() ? "" : " " + unit) + remark;
}

// ---------------------------------------------------------------- checks

namespace {

std::string item(const char* table, std::size_t index, const char* key = "") {
    return std::string(table) + "[" + std::to_string(index) + "]" + (*key ? std::string(".") + key : "");
}

void require(bool good, const std::string& key, const std::string& message) {
    if (!good) throw SceneError(key, message);
}

/// Visitor: refuses what lies outside its key's range or its words.
class RangeCheck {
  public:
    template <class T>
    void operator()(const char* key, const T& value, const char* unit, const Range& range, const char*) {
        for_each_number(value, [&](double number) {
            require(range.holds(number), path_ + key, range.refusal(number, unit));
        });
    }
    void operator()(const char* key, const std::optional<std::string>& value, Words words, const char*) {
        if (!value) return;
        std::string known;
        for (const char* word : words) {
            if (*value == word) return;
            known += (known.empty() ? "" : ", ") + std::string(word);
        }
        require(false, path_ + key, "is \"" + *value + "\"; must be one of " + known);
    }
    template <class T>
    void operator()(const char*, const T&, const char*) {}
    void operator()(const char* key, std::vector<MotionKey>& path, const char*) { list(key, path); }

    template <class F>
    void when(bool applies, F&& keys) {
        if (applies) keys();
    }
    template <class S>
    void table(const char* name, S& desc) {
        const std::string outer = path_;
        path_ += std::string(name) + ".";
        describe(*this, desc);
        path_ = outer;
    }
    template <class S>
    void list(const char* name, std::vector<S>& descs) {
        for (std::size_t i = 0; i < descs.size(); ++i) table(item(name, i).c_str(), descs[i]);
    }

  private:
    std::string path_;  ///< of the table, with a dot behind it
};

void validate_simulation(const SimulationDesc& s) {
    require(!(s.time_step && s.substeps), "simulation.time_step",
            "stands beside simulation.substeps; give one of the two");
    if (s.time_step) {
        require(1.0 / (s.frame_rate * *s.time_step) <= 1e6, "simulation.time_step",
                "is " + number_text(*s.time_step) + " s, more than a million steps per frame");
    }
}

void validate_fabric(const Fabric& f, const std::string& key) {
    require(f.mu.has_value() == f.lambda.has_value(), key + (f.mu ? ".mu" : ".lambda"),
            "mu and lambda are given together or not at all");
    if (f.mu) {
        require(*f.mu + *f.lambda > 0.0, key + ".lambda",
                "is " + number_text(*f.lambda) + " Pa; mu + lambda must be greater than 0");
    }
    const bool woven = f.young_weft || f.shear_modulus;
    if (woven) {
        require(f.membrane == MembraneKind::st_venant_kirchhoff,
                key + (f.young_weft ? ".young_weft" : ".shear_modulus"),
                "needs membrane = \"st_venant_kirchhoff\", the one that knows warp and weft");
        require(!f.mu, key + ".mu", "stands beside young_weft or shear_modulus; give one or the other");
    }
    if (f.young_weft) {
        const double bound = std::sqrt(f.young_modulus / *f.young_weft);
        require(std::abs(f.poisson_ratio) < bound, key + ".poisson_ratio",
                "is " + number_text(f.poisson_ratio) + "; must lie between -" + number_text(bound) + " and " +
                    number_text(bound) + ", the root of young_modulus / young_weft");
    }
    if (f.bending_bias) {
        const double least = 0.25 * (f.bending + f.bending_weft.value_or(f.bending));
        require(*f.bending_bias >= least, key + ".bending_bias",
                "is " + number_text(*f.bending_bias) + "; must be at least " + number_text(least) +
                    " N m, a quarter of warp's plus weft's, or the sheet would gain energy by bending");
    }
    if (f.yield_curvature) {
        require(f.bending_model == BendingKind::hinges, key + ".yield_curvature",
                "needs bending_model = \"hinges\", the one with rest angles");
    }
}

/// Every fabric of the scene and its key.
std::vector<std::pair<std::string, const Fabric*>> fabrics_of(const Scene& scene) {
    std::vector<std::pair<std::string, const Fabric*>> all;
    for (std::size_t i = 0; i < scene.cloths.size(); ++i)
        all.emplace_back(item("cloth", i, "fabric"), &scene.cloths[i].fabric);
    for (std::size_t i = 0; i < scene.parts.size(); ++i)
        all.emplace_back(item("part", i, "fabric"), &scene.parts[i].fabric);
    return all;
}

/// The velocity filter moves cloth after a step has been solved, by which it may pass a limit.
void validate_strain_limits(const Scene& scene) {
    if (scene.simulation.contact != ContactKind::velocity_filter) return;
    for (std::size_t k = 0; k < scene.colliders.size(); ++k) {
        const ColliderDesc& collider = scene.colliders[k];
        const bool switched = std::any_of(scene.events.begin(), scene.events.end(), [&](const EventDesc& e) {
            return e.collider && static_cast<std::size_t>(*e.collider) == k;
        });
        if (!collider.touchable || !(collider.enabled || switched)) continue;
        for (const auto& [key, fabric] : fabrics_of(scene)) {
            const auto& limit = fabric->strain_limit;
            require(!limit, key + ".strain_limit",
                    "is " + number_text(limit.value_or(0.0)) +
                        " beside simulation.contact = \"velocity_filter\" and " + item("collider", k) +
                        ", \"" + collider.name +
                        "\": the filter moves cloth after a step and would pass the limit; choose contact = "
                        "\"barrier\" or \"penalty\", or set the limit to 0 to leave it out");
        }
    }
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
        "end a step where nothing has looked for collisions; they go with \"penalty\" or "
        "\"velocity_filter\"");
    for (const auto& [key, fabric] : fabrics_of(scene)) {
        require(!fabric->strain_limit, key + ".strain_limit",
                "needs integrator = \"implicit_euler\" or \"tr_bdf2\" throughout; set it to 0 to leave the "
                "limit out");
    }
}

void validate_cloth(const ClothDesc& c, std::size_t i) {
    require(!(c.mesh && c.disc), item("cloth", i, "mesh"), "stands beside radius; give one rest shape");
    const Eigen::Index vertices = c.mesh   ? c.mesh->positions.rows()
                                  : c.disc ? 1 + 3 * Eigen::Index{c.disc->rings} * (c.disc->rings + 1)
                                           : Eigen::Index{c.grid.resolution[0]} * c.grid.resolution[1];
    if (c.pose) {
        require(c.pose->rows() == vertices, item("cloth", i, "pose"),
                "has " + std::to_string(c.pose->rows()) + " vertices; the rest shape has " +
                    std::to_string(vertices));
        require(c.pose->allFinite(), item("cloth", i, "pose"), "has coordinates that are not finite");
    }
    require(c.warp.norm() > 0.0, item("cloth", i, "warp"), "is zero; must point along the rest shape");
    require(c.rest == RestShape::mesh || c.mesh, item("cloth", i, "rest"),
            "is \"uv\", which belongs to a mesh; other shapes have no texture coordinates");
    require(!c.uv_scale || c.rest == RestShape::uv, item("cloth", i, "uv_scale"), "belongs to rest = \"uv\"");
}

void validate_motion(const std::vector<MotionKey>& path, const std::string& key) {
    for (std::size_t k = 0; k < path.size(); ++k) {
        require(k == 0 || path[k].time > path[k - 1].time, key, "has times that do not increase");
    }
}

void validate_cache(const MeshCache& cache, const MeshData& mesh, const std::string& key) {
    require(!cache.frames.empty(), key, "has no frames");
    for (std::size_t f = 0; f < cache.frames.size(); ++f) {
        const Points& frame = cache.frames[f];
        require(frame.rows() == mesh.positions.rows(), key,
                "has " + std::to_string(frame.rows()) + " vertices in frame " + std::to_string(f) +
                    " (counted from 0); the mesh has " + std::to_string(mesh.positions.rows()));
        require(frame.allFinite(), key,
                "has a coordinate that is not finite in frame " + std::to_string(f) + " (counted from 0)");
    }
    require(cache.times.empty() || cache.times.size() == cache.frames.size(), key,
            "has not as many times as frames");
    for (std::size_t f = 1; f < cache.times.size(); ++f)
        require(cache.times[f] > cache.times[f - 1], key, "has times that do not rise");
}

void validate_collider(const ColliderDesc& c, std::size_t i, bool barrier) {
    require(c.shape != Shape::plane || c.normal.norm() > 0.0, item("collider", i, "normal"),
            "is zero; must point out of the plane");
    if (c.contact_radius) {
        require(c.shape == Shape::sphere, item("collider", i, "contact_radius"),
                "belongs to a sphere; a plane has contact_offset");
        require(c.contact_offset == 0.0, item("collider", i, "contact_radius"),
                "stands beside contact_offset; give one of the two");
    }
    require(c.shape != Shape::plane || c.rotate.isZero(0.0), item("collider", i, "rotate"),
            "turns no plane; give its normal");
    validate_motion(c.path, item("collider", i, "path"));
    require(c.shape != Shape::mesh || c.mesh, item("collider", i, "mesh"),
            "is missing; shape = \"mesh\" needs a file");
    if (c.cache) validate_cache(*c.cache, *c.mesh, item("collider", i, "cache"));
    if (barrier || !c.touchable) return;
    require(has_one_curvature(c.shape), item("collider", i, "shape"),
            "needs contact = \"barrier\"; the others know spheres and planes");
    require(c.path.empty() && c.spin.isZero(0.0), item("collider", i, c.path.empty() ? "spin" : "path"),
            "needs contact = \"barrier\"; the others know colliders at rest");
}

void validate_selection(const VertexSelection& s, const std::string& key) {
    const int selections = !s.vertices.empty() + s.box.has_value() + s.nearest.has_value() +
                           s.greatest.has_value() + s.edge.has_value() + s.part.has_value();
    require(selections == 1, key, "give exactly one of vertices, box, nearest, greatest, edge, part");
    if (s.box) {
        require(((*s.box)[0].array() <= (*s.box)[1].array()).all(), key + ".box",
                "has a lower corner above its upper one");
    }
}

void validate_cloth_index(int cloth, const std::string& key, std::size_t cloths) {
    require(cloth >= 0 && static_cast<std::size_t>(cloth) < cloths, key, "there is no such cloth");
}

void validate_pin(const PinDesc& p, std::size_t i, const Scene& scene) {
    validate_cloth_index(p.cloth, item("pin", i, "cloth"), scene.cloths.size());
    validate_selection(p, item("pin", i));
    validate_motion(p.path, item("pin", i, "path"));
    if (!p.collider) return;
    require(*p.collider >= 0 && static_cast<std::size_t>(*p.collider) < scene.colliders.size(),
            item("pin", i, "collider"), "there is no such collider");
    for (const char* key : {"path", "center"})
        require(key == std::string("path") ? p.path.empty() : !p.center, item("pin", i, key),
                "stands beside collider, whose motion the pin follows; give one of the two");
}

void validate_seam(const SeamDesc& s, std::size_t i, std::size_t cloths) {
    for (int side = 0; side < 2; ++side) {
        const std::string key = item("seam", i, side == 0 ? "first" : "second");
        validate_cloth_index(s.sides[side].cloth, key + ".cloth", cloths);
        validate_selection(s.sides[side], key);
    }
}

void validate_air(const AirDesc& a) {
    require(a.lift <= a.drag, "air.lift",
            "is " + number_text(a.lift) + "; must be at most the drag, " + number_text(a.drag) +
                ", or the air would push a sheet that stands still in it");
}

void validate_drag(const DragDesc& d, std::size_t i) {
    require(d.path.size() >= 2, item("drag", i, "path"),
            "needs at least two keys [time, x, y]: press and release");
    for (std::size_t k = 0; k < d.path.size(); ++k) {
        require(k == 0 || d.path[k].time > d.path[k - 1].time, item("drag", i, "path"),
                "has times that do not increase");
    }
    require(d.path.front().time >= 0.0, item("drag", i, "path"),
            "begins at " + number_text(d.path.front().time) + "; must be at least 0 s");
}

void validate_event(const EventDesc& e, std::size_t i, std::size_t colliders) {
    require(e.collider.has_value() + e.toggle_integrator + e.integrator.has_value() == 1, item("event", i),
            "give either a collider or an integrator");
    if (e.collider) {
        require(*e.collider >= 0 && static_cast<std::size_t>(*e.collider) < colliders,
                item("event", i, "collider"), "there is no such collider");
    }
}

}  // namespace

StoppingLimits SimulationDesc::stopping() const {
    constexpr double residual = 1e-6;
    if (newton_tolerance || newton_speed)
        return {newton_tolerance.value_or(residual), newton_speed.value_or(0.0), 0.0};
    switch (accuracy) {
        case Accuracy::draft:
            return {residual, 0.3, 0.3};
        case Accuracy::fine:
            return {residual, 0.03, 0.05};
        case Accuracy::reference:
            break;
    }
    return {residual, 0.0, 0.0};
}

int SimulationDesc::steps_per_frame() const {
    if (substeps) return *substeps;
    if (!time_step) return 1;
    // The slack keeps 1 / (60 · 0.0166666667) at one step.
    return std::max(1, static_cast<int>(std::ceil(1.0 / (frame_rate * *time_step) * (1.0 - 1e-6))));
}

void validate(const Scene& scene) {
    RangeCheck check;
    describe(check, const_cast<Scene&>(scene));  // it only reads
    validate_simulation(scene.simulation);
    require(!scene.cloths.empty(), "cloth", "the scene has no [[cloth]]");
    for (std::size_t i = 0; i < scene.cloths.size(); ++i) validate_cloth(scene.cloths[i], i);
    for (std::size_t i = 0; i < scene.parts.size(); ++i)
        validate_cloth_index(scene.parts[i].cloth, item("part", i, "cloth"), scene.cloths.size());
    for (const auto& [key, fabric] : fabrics_of(scene)) validate_fabric(*fabric, key);
    const bool barrier = scene.simulation.contact == ContactKind::barrier;
    for (std::size_t i = 0; i < scene.colliders.size(); ++i)
        validate_collider(scene.colliders[i], i, barrier);
    for (std::size_t i = 0; i < scene.pins.size(); ++i) validate_pin(scene.pins[i], i, scene);
    for (std::size_t i = 0; i < scene.seams.size(); ++i) {
        validate_seam(scene.seams[i], i, scene.cloths.size());
    }
    validate_air(scene.simulation.air);
    for (std::size_t i = 0; i < scene.drags.size(); ++i) validate_drag(scene.drags[i], i);
    for (std::size_t i = 0; i < scene.events.size(); ++i) {
        validate_event(scene.events[i], i, scene.colliders.size());
    }
    validate_integrators(scene);
    validate_strain_limits(scene);
}

}  // namespace cloth
