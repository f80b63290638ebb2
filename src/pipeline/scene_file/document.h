#pragma once
// What a scene file says, table by table: the entries with their fields.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "pipeline/scene_file/field.h"
#include "pipeline/scene_file/scene_file.h"
#include "render/image/image.h"

namespace cloth::pipeline {

class Reader;

inline const Names<IntegratorKind> integrator_names{
    {"linearly_implicit_euler", IntegratorKind::linearly_implicit_euler},
    {"implicit_euler", IntegratorKind::implicit_euler},
    {"tr_bdf2", IntegratorKind::tr_bdf2},
    {"implicit_midpoint", IntegratorKind::implicit_midpoint}};
inline const Names<MembraneKind> membrane_names{{"corotational", MembraneKind::corotational},
                                                {"st_venant_kirchhoff", MembraneKind::st_venant_kirchhoff},
                                                {"neo_hookean", MembraneKind::neo_hookean}};
inline const Names<BendingKind> bending_names{{"quadratic", BendingKind::quadratic},
                                              {"hinges", BendingKind::hinges}};
inline const Names<LinearHessian> hessian_names{{"assignment", LinearHessian::assignment},
                                                {"projected", LinearHessian::projected}};
inline const Names<ContactKind> contact_names{{"velocity_filter", ContactKind::velocity_filter},
                                              {"penalty", ContactKind::penalty},
                                              {"barrier", ContactKind::barrier}};
inline const Names<Diagonals> diagonal_names{{"uniform", Diagonals::uniform},
                                             {"mirrored", Diagonals::mirrored},
                                             {"alternating", Diagonals::alternating}};
inline const Names<Shape> shape_names{{"sphere", Shape::sphere},     {"plane", Shape::plane},
                                      {"box", Shape::box},           {"capsule", Shape::capsule},
                                      {"cylinder", Shape::cylinder}, {"mesh", Shape::mesh}};
inline const Names<render::Pattern> pattern_names{{"plain", render::Pattern::plain},
                                                  {"stripes", render::Pattern::stripes},
                                                  {"checks", render::Pattern::checks},
                                                  {"tartan", render::Pattern::tartan},
                                                  {"dots", render::Pattern::dots}};
inline const Names<Framing> framing_names{{"fixed", Framing::fixed}, {"auto", Framing::automatic}};
inline const Names<Curve> curve_choices = [] {
    Names<Curve> names;
    for (const CurveName& n : curve_names) names.emplace_back(n.name, n.curve);
    return names;
}();
inline const Names<VertexField> shade_names = [] {
    Names<VertexField> names;
    for (const VertexFieldName& n : vertex_field_names()) names.emplace_back(n.name, n.field);
    return names;
}();
inline const Names<Switch> switch_names{{"on", Switch::on}, {"off", Switch::off}, {"toggle", Switch::toggle}};

// ---------------------------------------------------------------- what a file says

struct LookEntry {
    Color color{Vec3(0.8, 0.8, 0.8)};
    std::optional<Color> back_color;
    double roughness = 0.75, specular = 0.03, sheen = 0.0;

    Fields fields() {
        return {field("color", "sRGB", "colour of the front", color),
                field("back_color", "sRGB", "colour of the back; default: as the front", back_color),
                field("roughness", "", "of the specular lobe", roughness, 0.0, 1.0),
                field("specular", "", "reflectance at normal incidence", specular, 0.0, 1.0),
                field("sheen", "", "soft glow of fibres at grazing angles", sheen, 0.0, 10.0)};
    }
    Look look() const {
        render::Material m;
        m.front = color.linear();
        m.back = back_color.value_or(color).linear();
        m.roughness = static_cast<float>(roughness);
        m.specular = static_cast<float>(specular);
        m.sheen = static_cast<float>(sheen);
        return {m};
    }
};

inline Fields operator+(Fields a, const Fields& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

struct ClothEntry {
    ClothDesc desc;
    std::optional<Vec2> size;
    std::optional<Resolution> resolution;
    std::optional<Diagonals> diagonals;
    std::optional<double> radius;
    std::optional<int> rings;
    std::optional<std::string> mesh, pose;
    LookEntry look{.color = {Vec3(0.72, 0.16, 0.14)}, .back_color = {}, .sheen = 0.35};
    int subdivisions = 1;
    std::optional<render::Pattern> pattern;
    double pattern_scale = 0.2, weave = 0.0, weave_depth = 0.5, hem = 0.002;
    std::vector<Color> pattern_colors{
        {Vec3(0.93, 0.91, 0.86)}, {Vec3(0.10, 0.14, 0.26)}, {Vec3(0.85, 0.68, 0.25)}};
    std::optional<std::string> texture;
    std::shared_ptr<const render::Image> image;

    Look cloth_look() const {
        Look all = look.look();
        render::Material& m = all.material;
        m.pattern = image ? render::Pattern::image : pattern.value_or(render::Pattern::plain);
        m.pattern_scale = static_cast<float>(pattern_scale);
        for (std::size_t i = 0; i < m.pattern_colors.size(); ++i)
            m.pattern_colors[i] = pattern_colors[std::min(i, pattern_colors.size() - 1)].linear();
        m.pattern_on_back = !look.back_color;
        m.image = image;
        m.weave = static_cast<float>(weave);
        m.weave_depth = static_cast<float>(weave_depth);
        all.subdivisions = subdivisions;
        all.hem = hem;
        return all;
    }
    Fields fields() {
        return Fields{
                   field("name", "", "by which pins refer to it", desc.name),
                   field("size", "m", "of a grid: [along x, along y]", size),
                   field("resolution", "", "of a grid: vertices per side, one number or [along x, along y]",
                         resolution),
                   choice("diagonals", "of a grid: how squares are cut", diagonals, diagonal_names),
                   field("radius", "m", "of a disc, instead of a grid", radius),
                   field("rings", "", "of a disc: rings of vertices around the middle one", rings),
                   field("mesh", "file", "rest shape, instead of a grid or disc", mesh),
                   field("pose", "file", "mesh of the start positions; default: the rest shape", pose),
                   field("scale", "", "of the start pose", desc.transform.scale),
                   field("rotate", "degree", "of the start pose, about fixed x, then y, then z",
                         desc.transform.rotate),
                   field("translate", "m", "of the start pose, after scale and rotate",
                         desc.transform.translate),
                   field("velocity", "m/s", "at the start, of the free vertices", desc.velocity),
                   field("bump", "m", "height of a smooth out-of-plane offset of the start pose", desc.bump),
                   field("warp", "", "direction of the warp on the rest shape", desc.warp),
                   field("contact_thickness", "m", "of contact = \"barrier\": of the sheet as others feel it",
                         desc.contact_thickness),
                   field("subdivisions", "", "Loop steps that smooth the drawn surface", subdivisions, 0, 3),
                   choice("pattern", "on rest coordinates; on the back too, unless that has a colour",
                          pattern, pattern_names),
                   field("pattern_scale", "m", "width of one repeat of pattern or texture", pattern_scale,
                         1e-4, 1000.0),
                   field("pattern_colors", "sRGB", "one to three, beside color", pattern_colors),
                   field("texture", "file", "PNG on rest coordinates, instead of a pattern", texture),
                   field("weave", "m", "spacing of the threads; 0: smooth", weave, 0.0, 1.0),
                   field("weave_depth", "", "slope of the threads' flanks", weave_depth, 0.0, 2.0),
                   field("hem", "m", "thickness of the rim as drawn; 0: none", hem, 0.0, 0.1)} +
               look.fields();
    }
    Fields fabric_fields() {
        Fabric& f = desc.fabric;
        const auto unless_mu = [&f](Field plain) {
            plain.write = [&f, write = plain.write] { return f.mu ? std::string() : write(); };
            return plain;
        };
        return {field("name", "", "what lists call it", f.name),
                field("density", "kg/m²", "mass per area", f.density),
                field("thickness", "m", "multiplies the membrane's moduli", f.thickness),
                choice("membrane", "resistance in the plane", f.membrane, membrane_names),
                unless_mu(field("young_modulus", "Pa", "in-plane; of st_venant_kirchhoff along the warp",
                                f.young_modulus)),
                unless_mu(field("poisson_ratio", "",
                                "in-plane, plane stress; weft's shortening over warp's stretch",
                                f.poisson_ratio)),
                field("young_weft", "Pa", "of st_venant_kirchhoff, along the weft; default: as young_modulus",
                      f.young_weft),
                field("shear_modulus", "Pa",
                      "of st_venant_kirchhoff, of warp against weft; default: as isotropic", f.shear_modulus),
                field("mu", "Pa", "handed to the membrane as it is, with lambda, instead of the moduli above",
                      f.mu),
                field("lambda", "Pa", "see mu", f.lambda),
                field_or_none("strain_limit", "", "stretch that no triangle reaches, above 1; 0: none",
                              f.strain_limit),
                choice("bending_model", "resistance to bending", f.bending_model, bending_names),
                field("bending", "N m", "bending rigidity along the warp", f.bending),
                field("bending_weft", "N m", "along the weft; default: as bending", f.bending_weft),
                field("bending_bias", "N m", "at 45 degrees; default: between warp and weft", f.bending_bias),
                field_or_none("yield_curvature", "1/m", "of hinges: a sharper fold stays in part; 0: elastic",
                              f.yield_curvature),
                field("membrane_damping", "s", "viscous stress over stiffness times strain rate",
                      f.membrane_damping),
                field("bending_damping", "s", "viscous moment over rigidity times curvature rate",
                      f.bending_damping),
                field("friction", "", "Coulomb coefficient", f.friction)};
    }
};

struct ColliderEntry {
    ColliderDesc desc;
    std::optional<std::string> mesh;
    LookEntry look{.color = {Vec3(0.35, 0.42, 0.5)}, .back_color = {}, .roughness = 0.35, .specular = 0.05};

    Fields fields() {
        return Fields{
                   field("name", "", "by which events refer to it", desc.name),
                   choice("shape", "of the collider", desc.shape, shape_names),
                   field("center", "m", "where the shape's origin stands; a point on a plane", desc.center),
                   field("normal", "", "of a plane, outward", desc.normal),
                   field("radius", "m", "of a sphere, capsule or cylinder, as drawn", desc.radius),
                   field("height", "m", "of a capsule's axis or a cylinder, along y", desc.height),
                   field("size", "m", "of a box", desc.size),
                   field("mesh", "file", "of shape = \"mesh\"; open or closed", mesh),
                   field("scale", "", "of a mesh", desc.scale),
                   field("rotate", "degree",
                         "of a box, capsule, cylinder or mesh, about fixed x, then y, then z", desc.rotate),
                   field("path", "",
                         "[{ time, translate, rotate }, …] in s, m, degree: moves it; about center",
                         desc.path),
                   field("spin", "degree/s", "steady turn about center: axis times rate", desc.spin),
                   field("contact_offset", "m", "contact begins this far outside the drawn surface",
                         desc.contact_offset),
                   field("contact_radius", "m", "of a sphere: contact begins here, instead of contact_offset",
                         desc.contact_radius),
                   field("friction", "", "Coulomb coefficient", desc.friction),
                   field("enabled", "", "whether it is on at the start", desc.enabled),
                   field("drawn", "", "whether pictures show it (while it is on)", desc.drawn),
                   field("touchable", "", "whether cloth feels it; false: only drawn", desc.touchable)} +
               look.fields();
    }
};

/// Some of a cloth's vertices, as a pin or a side of a seam names them.
struct SelectionEntry {
    std::optional<ClothReference> cloth;
    std::optional<std::vector<int>> vertices;
    Fields fields(VertexSelection& s) {
        return {field("cloth", "", "name or index of the cloth; default: the first", cloth),
                field("vertices", "", "indices into the cloth's vertices", vertices),
                field("box", "m", "[[x, y, z], [x, y, z]]: lower and upper corner, start pose", s.box),
                field("nearest", "m", "the vertex nearest this point of the start pose", s.nearest),
                field("greatest", "", "x, y, z, -x, -y or -z: the vertices furthest that way", s.greatest),
                field("edge", "", "of a grid: left, right, bottom or top", s.edge),
                field("tolerance", "m", "of greatest", s.tolerance)};
    }
};

struct PinEntry {
    PinDesc desc;
    SelectionEntry selection;
    Fields fields() {
        return selection.fields(desc) +
               Fields{
                   field("path", "", "[{ time, translate, rotate }, …] in s, m, degree: moves the vertices",
                         desc.path),
                   field("center", "m", "of rotate; default: the mean of the vertices", desc.center),
                   field("until", "s", "lets go then; default: never", desc.until)};
    }
};

struct SeamEntry {
    SeamDesc desc;
    std::array<SelectionEntry, 2> selections;
    Fields fields() {
        return {field("reverse", "", "the second side in the opposite order", desc.reverse),
                field("begin", "s", "closing starts", desc.begin),
                field("close_time", "s", "from the start distance to none", desc.close_time),
                field("stiffness", "N/m", "of each spring", desc.stiffness)};
    }
    Fields side_fields(int side) { return selections[side].fields(desc.sides[side]); }
};
inline const char* const seam_sides[] = {"first", "second"};

struct DragEntry {
    DragDesc desc;
    Fields fields() {
        return {field("path", "s, pixel", "[[time, x, y], …]: pressed at the first, let go at the last",
                      desc.path),
                field("radius", "m", "vertices this near the picked one are picked too", desc.radius),
                field("stiffness", "N/m", "of each spring", desc.stiffness),
                field("viewport", "pixel", "the window that the pixels refer to", desc.viewport)};
    }
};

struct EventEntry {
    EventDesc desc;
    std::optional<std::string> collider, integrator;
    std::optional<Switch> action;
    Fields fields() {
        return {field("time", "s", "acts from the first step that starts then", desc.time),
                field("collider", "name", "the collider that is switched", collider),
                choice("action", "on the collider; default: toggle", action, switch_names),
                field("integrator", "", "toggle, or the name of one", integrator)};
    }
};

struct CameraEntry : CameraDesc {
    Fields fields() {
        return {field("position", "m", "of the eye", position),
                field("target", "m", "what it looks at", target),
                field("up", "", "direction that is up in the picture", up),
                field("field_of_view", "degree", "vertical", field_of_view, 1.0, 160.0),
                field("path", "",
                      "[{ time, position, target, field_of_view }, …]: smooth between these; "
                      "drags still look from where the camera rests",
                      path),
                field("turntable", "degree/s", "turn about the target", turntable, -3600.0, 3600.0),
                choice("frame", "auto: along the same line of sight, all cloth in the picture during the run",
                       framing, framing_names)};
    }
};

struct LightEntry {
    Vec3 direction;
    Color color{Vec3(1.0, 0.985, 0.96)};
    double intensity, softness, angle;
    bool shadow;
    LightEntry() {
        const render::Light light;
        direction = Vec3(light.direction[0], light.direction[1], light.direction[2]);
        intensity = light.intensity;
        softness = std::round(1e6 * light.softness) / 1e6;
        angle = std::round(1e6 * light.angle) / 1e6;
        shadow = light.shadow;
    }
    Fields fields() {
        return {
            field("direction", "", "from the scene towards the light", direction),
            field("color", "sRGB", "of the light", color),
            field("intensity", "", "irradiance of a facing plane", intensity, 0.0, 1e6),
            field("softness", "m", "least half-width of a shadow's edge", softness, 0.0, 1.0),
            field("angle", "degree", "across the light, as seen from the scene; shadows soften with distance",
                  angle, 0.0, 45.0),
            field("shadow", "", "whether it casts shadows", shadow)};
    }
};

struct GroundEntry {
    double height = 0.0;
    Color color{Vec3(0.78, 0.78, 0.78)};
    Fields fields() {
        return {field("height", "m", "y of the floor", height),
                field("color", "sRGB", "of the floor", color)};
    }
};

struct BackgroundEntry {
    Color color{Vec3(0.87, 0.89, 0.91)}, sky{Vec3(0.69, 0.71, 0.75)};
    double exposure = 1.0;
    bool ambient_occlusion = render::View{}.ambient_occlusion;
    Fields fields() {
        return {field("color", "sRGB", "behind everything", color),
                field("sky", "sRGB", "light from above", sky),
                field("ambient_occlusion", "", "folds and corners get less of the sky's light",
                      ambient_occlusion),
                field("exposure", "", "factor on all light", exposure, 1e-6, 1e6)};
    }
};

struct Document {
    int version = 1;
    std::string description;
    Scene scene;
    std::vector<ClothEntry> cloths;
    std::vector<ColliderEntry> colliders;
    std::vector<PinEntry> pins;
    std::vector<SeamEntry> seams;
    std::vector<DragEntry> drags;
    std::vector<EventEntry> events;
    CameraEntry camera;
    LightEntry light;
    std::optional<GroundEntry> ground;
    BackgroundEntry background;
    OutputDesc output;
    AnnotationDesc annotation;
    CaptionText caption;
    PixelSize size{1280, 720};
    ExpectDesc expect;

    Fields top_fields() {
        return {field("version", "", "of the scene format: 1", version),
                field("description", "", "one line for lists", description)};
    }
    Fields simulation_fields() {
        SimulationDesc& s = scene.simulation;
        return {
            field("gravity", "m/s²", "acceleration", s.gravity),
            field("frame_rate", "1/s", "frame k stands at time k / frame_rate", s.frame_rate),
            field("time_step", "s", "longest step; a frame is cut into the fewest equal ones", s.time_step),
            field("substeps", "", "steps per frame, instead of time_step", s.substeps),
            choice("integrator", "how a step is made", s.integrator, integrator_names),
            choice("hessian", "of linearly_implicit_euler", s.hessian, hessian_names),
            choice("contact", "how cloth meets colliders", s.contact, contact_names),
            field("contact_stiffness", "N/m", "of contact = \"penalty\", per vertex", s.contact_stiffness),
            field("sliding_speed", "m/s",
                  "friction is in full force above it; default: 1e-3 with penalty, 1e-5 with barrier",
                  s.sliding_speed),
            field("contact_activation", "m", "of contact = \"barrier\": gap at which repulsion begins",
                  s.contact_activation),
            field("newton_iterations", "", "most of one solve; of all but linearly_implicit_euler",
                  s.newton_iterations),
            field("newton_tolerance", "", "residual at which a solve stops, against the step's start",
                  s.newton_tolerance),
            field(
                "newton_speed", "m/s",
                "of contact = \"barrier\": a solve stops as well where its last step moves no vertex faster, "
                "and the forces left no cloth's mean by a hundredth of it; 0: by newton_tolerance alone",
                s.newton_speed),
            field("retries", "", "times that a step which does not converge is halved", s.retries)};
    }
    Fields air_fields() {
        AirDesc& a = scene.simulation.air;
        return {field("density", "kg/m³", "of the air", a.density),
                field("drag", "", "coefficient of a triangle's projected area; 0: no air", a.drag),
                field("lift", "", "coefficient, at most drag", a.lift),
                field("wind", "m/s", "mean", a.wind),
                field("gusts", "m/s", "root mean square of each component", a.gusts),
                field("gust_length", "m", "longest wave of the gusts", a.gust_length),
                field("seed", "", "of the gusts", a.seed)};
    }
    Fields output_fields() {
        return {
            field("size", "pixel", "of pictures and movie", size),
            field("frames", "", "when the command line does not say", output.frames, 1, 10'000'000),
            field("playback_rate", "1/s", "frames per second of the movie; default: frame_rate",
                  output.playback_rate, 0.01, 1000.0),
            field("quality", "", "H.264 constant rate factor; 0: lossless", output.quality, 0, 51),
            field("caption", "", "true, or a text with {scene}, {time}, {frame}, {description}", caption),
            choice("shade", "shown in colours instead of the fabric", annotation.shade, shade_names),
            field("shade_range", "", "numbers at the ends of the colours; default: of the whole run",
                  annotation.shade_range),
            field("wireframe", "", "the edges of the simulated triangles", annotation.wireframe),
            field("ids", "pixel", "[x, y] or [x, y, radius]: vertex and triangle numbers there, magnified",
                  annotation.ids),
            choices("curves", "drawn in the picture", annotation.curves, curve_choices),
            field("motion_blur", "", "pictures of which each frame is the mean; 1: none",
                  annotation.motion_blur, 1, 64),
            field("shutter", "", "share of a frame's time during which they are taken", annotation.shutter,
                  0.01, 1.0)};
    }
    Fields expect_fields() {
        return {field("state_tolerance", "m", "of golden states made by another build",
                      expect.state_tolerance, 1e-15, 1.0),
                field("frames", "", "golden frames", expect.frames, 0, 10'000'000)};
    }
};
void read_document(Reader& reader, Document& document);

/// Files, names and numbers become what the simulation takes: `document.scene`. Reader::fail() for what does
/// not fit together.
void resolve(Reader& reader, Document& document);

/// TOML of a resolved document, every default written out.
std::string write_document(Document& document);

}  // namespace cloth::pipeline
