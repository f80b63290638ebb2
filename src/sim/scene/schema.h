#pragma once
// Every key of a scene, once: its name, unit, range and meaning; its default is the struct's own initialiser.
//
// describe(visitor, desc) calls the visitor for each key, in the order in which scenes are written:
//   visitor(name, value, unit, range, meaning)   a number, or a vector, list or optional of numbers
//   visitor(name, value, words, meaning)         a text that is one of `words`
//   visitor(name, value, meaning)                anything else: text, switch, enum (names_of), key frames,
//                                                vertices and triangles (a file), Reference, IntegratorChange
//   visitor.when(applies, keys)                  calls keys(); where not `applies` another key takes their
//   place visitor.table(name, desc), visitor.list(name, descs)    tables inside this one
// Reading, writing, range checks, the list of keys, the JSON Schema and the tests walk it: a new key is a
// field of scene.h, a line here and its consumer.

#include <limits>
#include <span>
#include <string>
#include <type_traits>

#include "sim/scene/scene.h"

namespace cloth {

// ---------------------------------------------------------------- ranges

/// The numbers that a key takes, of a vector or list each of its numbers. Every key has both ends: what lies
/// beyond them is a slip of the unit or the exponent, and would end in numbers that are none.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool above = false, below = false;  ///< whether `low`, `high` themselves are out of it
    bool zero_is_none = false;          ///< of an optional value: a file leaves it out by 0
    const char* remark = "";            ///< at the end of a refusal

    bool holds(double value) const;
    /// "must be greater than 0", "must be 1 … 20" …
    std::string words() const;
    /// "> 0", "1 … 20", "±100" …; "" where every number is good.
    std::string brief() const;
    /// "is -1 m; must be greater than 0 m".
    std::string refusal(double value, const std::string& unit) const;
};
inline constexpr Range any{};
/// Greater than `low`.
constexpr Range above(double low, double high, const char* remark = "") {
    return {.low = low, .high = high, .above = true, .remark = remark};
}
constexpr Range range(double low, double high) {
    return {.low = low, .high = high};
}
constexpr Range between(double low, double high, const char* remark = "") {
    return {.low = low, .high = high, .above = true, .below = true, .remark = remark};
}
constexpr Range within(double bound) {
    return {.low = -bound, .high = bound};
}
constexpr Range or_none(Range r) {
    r.zero_is_none = true;
    return r;
}

/// What many keys share.
namespace ranges {
inline constexpr Range place = within(1e6);            ///< a coordinate or a way [m]
inline constexpr Range direction = within(1e6);        ///< a part of a vector of any length
inline constexpr Range turn = within(1e6);             ///< an angle or a rate of turning [degree], [degree/s]
inline constexpr Range velocity = within(1e4);         ///< [m/s]
inline constexpr Range speed = range(0.0, 1e4);        ///< [m/s]
inline constexpr Range length = range(1e-6, 1e6);      ///< of a thing [m]
inline constexpr Range gap = range(1e-9, 1e3);         ///< a thickness [m]
inline constexpr Range distance = range(0.0, 1e6);     ///< [m]
inline constexpr Range moment = range(0.0, 1e9);       ///< of time [s]
inline constexpr Range duration = range(1e-9, 1e9);    ///< [s]
inline constexpr Range modulus = range(1e-6, 1e15);    ///< [Pa]
inline constexpr Range rigidity = range(0.0, 1e9);     ///< of bending [N m]
inline constexpr Range stiffness = range(1e-9, 1e15);  ///< of a spring [N/m]
inline constexpr Range coefficient = range(0.0, 1e3);
}  // namespace ranges

/// A number as messages show it: whole ones in full, others by six digits.
std::string number_text(double value);

/// Calls f(number) for every number of a value that a Range speaks of.
template <class T, class F>
void for_each_number(const T& value, F&& f) {
    if constexpr (std::is_arithmetic_v<T>) {
        f(static_cast<double>(value));
    } else if constexpr (requires { value.has_value(); }) {
        if (value.has_value()) for_each_number(*value, f);
    } else if constexpr (requires { value.coeff(0); }) {
        for (Eigen::Index i = 0; i < value.size(); ++i) f(value.coeff(i));
    } else {
        for (const auto& each : value) for_each_number(each, f);
    }
}

template <class F>
void for_each_number(const DragDesc::Key& key, F&& f) {
    f(key.time);
    f(key.pixel.x());
    f(key.pixel.y());
}

// ---------------------------------------------------------------- names

/// An enum's value and its name in scenes.
template <class E>
struct EnumName {
    E value;
    const char* name;
};

inline constexpr EnumName<MembraneKind> membrane_names[] = {
    {MembraneKind::corotational, "corotational"},
    {MembraneKind::st_venant_kirchhoff, "st_venant_kirchhoff"},
    {MembraneKind::neo_hookean, "neo_hookean"}};
inline constexpr EnumName<BendingKind> bending_names[] = {{BendingKind::quadratic, "quadratic"},
                                                          {BendingKind::hinges, "hinges"}};
inline constexpr EnumName<RestShape> rest_names[] = {{RestShape::mesh, "mesh"}, {RestShape::uv, "uv"}};
inline constexpr EnumName<Diagonals> diagonal_names[] = {{Diagonals::uniform, "uniform"},
                                                         {Diagonals::mirrored, "mirrored"},
                                                         {Diagonals::alternating, "alternating"}};
inline constexpr EnumName<LengthUnit> length_names[] = {{LengthUnit::metre, "m"},
                                                        {LengthUnit::centimetre, "cm"},
                                                        {LengthUnit::millimetre, "mm"},
                                                        {LengthUnit::inch, "in"},
                                                        {LengthUnit::foot, "ft"}};
inline constexpr EnumName<Shape> shape_names[] = {{Shape::sphere, "sphere"},     {Shape::plane, "plane"},
                                                  {Shape::box, "box"},           {Shape::capsule, "capsule"},
                                                  {Shape::cylinder, "cylinder"}, {Shape::mesh, "mesh"}};
inline constexpr EnumName<IntegratorKind> integrator_names[] = {
    {IntegratorKind::linearly_implicit_euler, "linearly_implicit_euler"},
    {IntegratorKind::implicit_euler, "implicit_euler"},
    {IntegratorKind::tr_bdf2, "tr_bdf2"},
    {IntegratorKind::implicit_midpoint, "implicit_midpoint"}};
inline constexpr EnumName<Switch> switch_names[] = {
    {Switch::on, "on"}, {Switch::off, "off"}, {Switch::toggle, "toggle"}};
inline constexpr EnumName<LinearHessian> hessian_names[] = {{LinearHessian::assignment, "assignment"},
                                                            {LinearHessian::projected, "projected"}};
inline constexpr EnumName<Accuracy> accuracy_names[] = {
    {Accuracy::draft, "draft"}, {Accuracy::fine, "fine"}, {Accuracy::reference, "reference"}};
inline constexpr EnumName<ContactKind> contact_names[] = {{ContactKind::velocity_filter, "velocity_filter"},
                                                          {ContactKind::penalty, "penalty"},
                                                          {ContactKind::barrier, "barrier"}};

/// The names that scenes know an enum's values by.
constexpr std::span<const EnumName<MembraneKind>> names_of(MembraneKind) {
    return membrane_names;
}
constexpr std::span<const EnumName<BendingKind>> names_of(BendingKind) {
    return bending_names;
}
constexpr std::span<const EnumName<RestShape>> names_of(RestShape) {
    return rest_names;
}
constexpr std::span<const EnumName<Diagonals>> names_of(Diagonals) {
    return diagonal_names;
}
constexpr std::span<const EnumName<LengthUnit>> names_of(LengthUnit) {
    return length_names;
}
constexpr std::span<const EnumName<Shape>> names_of(Shape) {
    return shape_names;
}
constexpr std::span<const EnumName<IntegratorKind>> names_of(IntegratorKind) {
    return integrator_names;
}
constexpr std::span<const EnumName<Switch>> names_of(Switch) {
    return switch_names;
}
constexpr std::span<const EnumName<LinearHessian>> names_of(LinearHessian) {
    return hessian_names;
}
constexpr std::span<const EnumName<Accuracy>> names_of(Accuracy) {
    return accuracy_names;
}
constexpr std::span<const EnumName<ContactKind>> names_of(ContactKind) {
    return contact_names;
}

using Words = std::span<const char* const>;
inline constexpr const char* directions[] = {"x", "y", "z", "-x", "-y", "-z"};
inline constexpr const char* grid_edges[] = {"left", "right", "bottom", "top"};

// ---------------------------------------------------------------- values that are not a field each

/// A field of an optional struct: setting it makes the struct.
template <class S, class T>
struct Inside {
    std::optional<S>& owner;
    T S::*member;

    bool has_value() const { return owner.has_value(); }
    const T& operator*() const { return (*owner).*member; }
    void set(const T& value) const {
        if (!owner) owner.emplace();
        (*owner).*member = value;
    }
};
template <class S, class T>
Inside<S, T> inside(std::optional<S>& owner, T S::*member) {
    return {owner, member};
}

/// A cloth or collider, by its index in the scene's list; files may name it.
enum class Listed { cloth, collider };
struct Reference {
    Listed list;
    int* index = nullptr;  ///< always given, or
    std::optional<int>* optional_index = nullptr;
};

/// What an event does to the integrator: "toggle", or the name of one.
struct IntegratorChange {
    bool& toggle;
    std::optional<IntegratorKind>& integrator;
};

/// A cloth's mesh and, of a sewing pattern, the usual length of its edges.
struct MeshSource {
    std::optional<MeshData>& mesh;
    const std::optional<double>& edge_length;
};

// ---------------------------------------------------------------- keys

template <class V>
void describe(V& v, SimulationDesc& s) {
    v("gravity", s.gravity, "m/s²", within(1e4), "acceleration");
    v("frame_rate", s.frame_rate, "1/s", range(1e-3, 1e6), "frame k stands at time k / frame_rate");
    v("time_step", s.time_step, "s", range(1e-9, 1e3),
      "longest step; a frame is cut into the fewest equal ones");
    v("substeps", s.substeps, "", range(1, 1e6), "steps per frame, instead of time_step");
    v("integrator", s.integrator, "how a step is made");
    v("hessian", s.hessian, "of linearly_implicit_euler");
    v("contact", s.contact, "how cloth meets colliders");
    v("contact_stiffness", s.contact_stiffness, "N/m", range(1e-9, 1e15),
      "of contact = \"penalty\", per vertex");
    v("sliding_speed", s.sliding_speed, "m/s", range(1e-9, 1e4),
      "friction is in full force above it; default: 1e-3 with penalty, 1e-4 with barrier");
    v("contact_activation", s.contact_activation, "m", ranges::gap,
      "of contact = \"barrier\": gap at which repulsion begins; default: the least contact_thickness that a "
      "cloth here has by default");
    v("newton_iterations", s.newton_iterations, "", range(1, 1e6),
      "most of one solve; of all but linearly_implicit_euler");
    v("accuracy", s.accuracy,
      "how far each step is solved: until an iteration moves no vertex faster than a share of the cloth's "
      "own "
      "speed; reference: by the residual alone");
    v("newton_tolerance", s.newton_tolerance, "", between(0.0, 1.0),
      "in place of accuracy: residual at which a solve stops, against the step's start; default: 1e-6");
    v("newton_speed", s.newton_speed, "m/s", ranges::speed,
      "in place of accuracy: a solve stops as well where its last iteration moves no vertex faster, and the "
      "forces left no cloth's mean by a hundredth of it; default: 0, by newton_tolerance alone");
    v("retries", s.retries, "", range(0, 20), "times that a step which does not converge is halved");
}

template <class V>
void describe(V& v, AirDesc& a) {
    v("density", a.density, "kg/m³", range(1e-6, 1e6), "of the air");
    v("drag", a.drag, "", ranges::coefficient, "coefficient of a triangle's projected area; 0: no air");
    v("lift", a.lift, "", ranges::coefficient, "coefficient, at most drag");
    v("wind", a.wind, "m/s", ranges::velocity, "mean");
    v("gusts", a.gusts, "m/s", ranges::speed, "root mean square of each component");
    v("gust_length", a.gust_length, "m", range(1e-3, 1e6), "longest wave of the gusts");
    v("seed", a.seed, "", range(0, 4294967295.0), "of the gusts");
}

template <class V>
void describe(V& v, Fabric& f) {
    v("name", f.name, "what lists call it");
    v("density", f.density, "kg/m²", range(1e-6, 1e6), "mass per area");
    v("thickness", f.thickness, "m", ranges::gap, "multiplies the membrane's moduli");
    v("membrane", f.membrane, "resistance in the plane");
    v.when(!f.mu, [&] {
        v("young_modulus", f.young_modulus, "Pa", ranges::modulus,
          "in-plane; of st_venant_kirchhoff along the warp");
        v("poisson_ratio", f.poisson_ratio, "", between(-1.0, 1.0, " (plane stress)"),
          "in-plane, plane stress; weft's shortening over warp's stretch");
    });
    v("young_weft", f.young_weft, "Pa", ranges::modulus,
      "of st_venant_kirchhoff, along the weft; default: as young_modulus");
    v("shear_modulus", f.shear_modulus, "Pa", ranges::modulus,
      "of st_venant_kirchhoff, of warp against weft; default: as isotropic");
    v("mu", f.mu, "Pa", ranges::modulus,
      "handed to the membrane as it is, with lambda, instead of the moduli above");
    v("lambda", f.lambda, "Pa", within(1e15), "see mu");
    v("strain_limit", f.strain_limit, "", or_none(above(1.0, 1e3, ", a stretch such as 1.05")),
      "stretch that no triangle reaches; 0: none");
    v("bending_model", f.bending_model, "resistance to bending");
    v("bending", f.bending, "N m", ranges::rigidity, "bending rigidity along the warp");
    v("bending_weft", f.bending_weft, "N m", ranges::rigidity, "along the weft; default: as bending");
    v("bending_bias", f.bending_bias, "N m", ranges::rigidity,
      "at 45 degrees; default: between warp and weft");
    v("yield_curvature", f.yield_curvature, "1/m", or_none(range(1e-6, 1e9)),
      "of hinges: a sharper fold stays in part; 0: elastic");
    v("membrane_damping", f.membrane_damping, "s", range(0.0, 1e6),
      "viscous stress over stiffness times strain rate");
    v("bending_damping", f.bending_damping, "s", range(0.0, 1e6),
      "viscous moment over rigidity times curvature rate");
    v("friction", f.friction, "", ranges::coefficient, "Coulomb coefficient");
}

template <class V>
void describe(V& v, ClothDesc& c) {
    v("name", c.name, "by which pins refer to it");
    v.when(c.rest_grid() != nullptr, [&] {
        v("size", c.grid.size, "m", ranges::length, "of a grid: [along x, along y]");
        v("resolution", c.grid.resolution, "vertices", range(2, 4096),
          "of a grid: per side, one number or [along x, along y]");
        v("diagonals", c.grid.diagonals, "of a grid: how squares are cut");
    });
    v("radius", inside(c.disc, &Disc::radius), "m", ranges::length, "of a disc, instead of a grid");
    v("rings", inside(c.disc, &Disc::rings), "", range(1, 1000),
      "of a disc: rings of vertices around the middle one");
    v("mesh", MeshSource{c.mesh, c.edge_length},
      "rest shape, instead of a grid or disc: a mesh, or a sewing pattern in GarmentCode's JSON");
    v("edge_length", c.edge_length, "m", ranges::length,
      "of a sewing pattern: usual length of the triangles' edges; default: 0.02");
    v("pose", c.pose, "mesh of the start positions; default: the rest shape");
    v.when(c.mesh || c.pose, [&] { v("units", c.units, "of the coordinates in mesh and pose; default: m"); });
    v.when(c.mesh.has_value(), [&] {
        v("weld", c.weld, "of a mesh: vertices at one place become one; default: true");
        v("rest", c.rest,
          "of a mesh: uv: each triangle is at rest as its texture coordinates have it, as a pattern is cut; "
          "default: mesh");
    });
    v.when(c.rest == RestShape::uv, [&] {
        v("uv_scale", c.uv_scale, "m", ranges::length,
          "of rest = \"uv\": a unit of texture coordinates; default: as large as the mesh");
    });
    v("scale", c.transform.scale, "", range(1e-6, 1e6), "of the start pose");
    v("rotate", c.transform.rotate, "degree", ranges::turn,
      "of the start pose, about fixed x, then y, then z");
    v("translate", c.transform.translate, "m", ranges::place, "of the start pose, after scale and rotate");
    v("velocity", c.velocity, "m/s", ranges::velocity, "at the start, of the free vertices");
    v("bump", c.bump, "m", ranges::place, "height of a smooth out-of-plane offset of the start pose");
    v("warp", c.warp, "", ranges::direction, "direction of the warp on the rest shape");
    v("contact_thickness", c.contact_thickness, "m", ranges::gap,
      "of contact = \"barrier\": of the sheet as others feel it; default: 1 mm, but at most a hundredth and "
      "at least a ten-thousandth of the diagonal of the rest shape's box");
    v.table("fabric", c.fabric);
}

template <class V>
void describe(V& v, PartDesc& p) {
    v("cloth", Reference{Listed::cloth, &p.cloth}, "that it is of");
    v("name", p.name, "of a material, group or object in the cloth's mesh file");
    v.table("fabric", p.fabric);
}

/// A key frame of a path; lists of them are one value.
template <class V>
void describe(V& v, MotionKey& k) {
    v("time", k.time, "s", ranges::moment, "");
    v("translate", k.translate, "m", ranges::place, "");
    v("rotate", k.rotate, "degree", ranges::turn, "");
}

template <class V>
void describe(V& v, ColliderDesc& c) {
    v("name", c.name, "by which events refer to it");
    v("shape", c.shape, "of the collider");
    v("center", c.center, "m", ranges::place, "where the shape's origin stands; a point on a plane");
    v("normal", c.normal, "", ranges::direction, "of a plane, outward");
    v("radius", c.radius, "m", ranges::length, "of a sphere, capsule or cylinder, as drawn");
    v("height", c.height, "m", ranges::length, "of a capsule's axis or a cylinder, along y");
    v("size", c.size, "m", ranges::length, "of a box");
    v("mesh", c.mesh, "of shape = \"mesh\"; open or closed");
    v("cache", c.cache, "of shape = \"mesh\": where its vertices are over time");
    v.when(c.mesh || c.cache,
           [&] { v("units", c.units, "of the coordinates in mesh and cache; default: m"); });
    v.when(c.cache != nullptr, [&] {
        v("cache_start", c.cache_start, "s", within(1e9), "when the cache's first frame stands; default: 0");
        v("cache_speed", c.cache_speed, "", range(1e-6, 1e6),
          "of the cache's time against the run's; default: 1");
        v("cache_loop", c.cache_loop,
          "whether the first frame comes after the last; default: false, that stays");
    });
    v("cache_rate", c.cache_rate, "1/s", range(1e-3, 1e6),
      "frames of the cache per second; default: as the file says, or 24");
    v("scale", c.scale, "", range(1e-6, 1e6), "of a mesh");
    v("rotate", c.rotate, "degree", ranges::turn,
      "of a box, capsule, cylinder or mesh, about fixed x, then y, then z");
    v("path", c.path, "in s, m, degree: moves it; about center");
    v("spin", c.spin, "degree/s", ranges::turn, "steady turn about center: axis times rate");
    v("contact_offset", c.contact_offset, "m", ranges::distance,
      "contact begins this far outside the drawn surface");
    v("contact_radius", c.contact_radius, "m", ranges::length,
      "of a sphere: contact begins here, instead of contact_offset");
    v("friction", c.friction, "", ranges::coefficient, "Coulomb coefficient");
    v("enabled", c.enabled, "whether it is on at the start");
    v("drawn", c.drawn, "whether pictures show it (while it is on)");
    v("touchable", c.touchable, "whether cloth feels it; false: only drawn");
}

template <class V>
void describe(V& v, VertexSelection& s) {
    v.when(!s.vertices.empty(), [&] {
        v("vertices", s.vertices, "", range(0, 2147483647.0), "indices into the cloth's vertices");
    });
    v("box", s.box, "m", ranges::place, "lower and upper corner, start pose");
    v("nearest", s.nearest, "m", ranges::place, "the vertex nearest this point of the start pose");
    v("greatest", s.greatest, directions, "the vertices furthest that way");
    v("edge", s.edge, grid_edges, "of a grid");
    v("part", s.part, "of a mesh: a material, group or object of its file");
    v("tolerance", s.tolerance, "m", ranges::distance, "of greatest");
}

template <class V>
void describe(V& v, PinDesc& p) {
    v("cloth", Reference{Listed::cloth, &p.cloth}, "that it holds");
    describe(v, static_cast<VertexSelection&>(p));
    v("path", p.path, "in s, m, degree: moves the vertices");
    v("collider", Reference{Listed::collider, nullptr, &p.collider}, "that carries the vertices with it");
    v("center", p.center, "m", ranges::place, "of rotate; default: the mean of the vertices");
    v("until", p.until, "s", ranges::duration, "lets go then; default: never");
}

template <class V>
void describe(V& v, SeamDesc::Side& s) {
    v("cloth", Reference{Listed::cloth, &s.cloth}, "that it is on");
    describe(v, static_cast<VertexSelection&>(s));
}

template <class V>
void describe(V& v, SeamDesc& s) {
    v("reverse", s.reverse, "the second side in the opposite order");
    v("begin", s.begin, "s", ranges::moment, "closing starts");
    v("close_time", s.close_time, "s", ranges::duration, "from the start distance to none");
    v("stiffness", s.stiffness, "N/m", ranges::stiffness, "of each spring");
    v.table("first", s.sides[0]);
    v.table("second", s.sides[1]);
}

/// The camera that the pixels look through is the scene's.
template <class V>
void describe(V& v, DragDesc& d) {
    v("path", d.path, "", within(1e6),
      "[[time, x, y], …] in s, pixel: pressed at the first, let go at the last");
    v("radius", d.radius, "m", ranges::distance, "vertices this near the picked one are picked too");
    v("stiffness", d.stiffness, "N/m", ranges::stiffness, "of each spring");
    v("viewport", d.viewport, "pixel", range(1.0, 1e6), "the window that the pixels refer to");
}

template <class V>
void describe(V& v, EventDesc& e) {
    v("time", e.time, "s", ranges::moment, "acts from the first step that starts then");
    v("collider", Reference{Listed::collider, nullptr, &e.collider}, "the collider that is switched");
    v.when(e.collider.has_value(), [&] { v("action", e.action, "on the collider; default: toggle"); });
    v("integrator", IntegratorChange{e.toggle_integrator, e.integrator},
      "switches to it, or to the other one");
}

template <class V>
void describe(V& v, Scene& s) {
    v.table("simulation", s.simulation);
    v.table("air", s.simulation.air);
    v.list("cloth", s.cloths);
    v.list("part", s.parts);
    v.list("collider", s.colliders);
    v.list("pin", s.pins);
    v.list("seam", s.seams);
    v.list("drag", s.drags);
    v.list("event", s.events);
}

}  // namespace cloth
