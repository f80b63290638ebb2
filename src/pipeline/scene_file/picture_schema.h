#pragma once
// Every key of a scene's pictures, once, as sim/scene/schema.h has those of the scene itself; and the tables
// of a scene file. Two more kinds of value:
//   visitor(name, CaptionText, meaning)     a text, or true and false
//   visitor.one_of_a_list(name, desc)       a list of tables that holds one

#include <string>
#include <vector>

#include "pipeline/scene_file/picture_desc.h"
#include "pipeline/scene_file/scene_file.h"
#include "sim/scene/schema.h"

namespace cloth::render {

inline constexpr EnumName<Pattern> pattern_names[] = {{Pattern::plain, "plain"},
                                                      {Pattern::stripes, "stripes"},
                                                      {Pattern::checks, "checks"},
                                                      {Pattern::tartan, "tartan"},
                                                      {Pattern::dots, "dots"}};
constexpr std::span<const EnumName<Pattern>> names_of(Pattern) {
    return pattern_names;
}

}  // namespace cloth::render

namespace cloth {

inline std::vector<EnumName<VertexField>> names_of(VertexField) {
    std::vector<EnumName<VertexField>> names;
    for (const VertexFieldName& n : vertex_field_names()) names.push_back({n.field, n.name});
    return names;
}

}  // namespace cloth

namespace cloth::pipeline {

inline constexpr EnumName<Framing> framing_names[] = {{Framing::fixed, "fixed"},
                                                      {Framing::automatic, "auto"}};
constexpr std::span<const EnumName<Framing>> names_of(Framing) {
    return framing_names;
}
inline std::vector<EnumName<Curve>> names_of(Curve) {
    std::vector<EnumName<Curve>> names;
    for (const CurveName& n : curve_names) names.push_back({n.curve, n.name});
    return names;
}

using cloth::for_each_number;
template <class F>
void for_each_number(const PixelSize& size, F&& f) {
    f(size.width);
    f(size.height);
}

template <class F>
void for_each_number(const PicturePlace& place, F&& f) {
    f(place.x);
    f(place.y);
    f(place.radius);
}

/// true: the default text; false: none.
struct CaptionText {
    std::optional<std::string>& text;
};

template <class V>
void describe(V& v, LookDesc& l) {
    v("color", l.color, "sRGB, of the front");
    v("back_color", l.back_color, "sRGB, of the back; default: as the front");
    v("roughness", l.roughness, "", range(0.0, 1.0), "of the specular lobe");
    v("specular", l.specular, "", range(0.0, 1.0), "reflectance at normal incidence");
    v("sheen", l.sheen, "", range(0.0, 10.0), "soft glow of fibres at grazing angles");
}

template <class V>
void describe(V& v, ClothLookDesc& l) {
    v("subdivisions", l.subdivisions, "", range(0, 3), "Loop steps that smooth the drawn surface");
    v("pattern", l.pattern, "on rest coordinates; on the back too, unless that has a colour");
    v("pattern_scale", l.pattern_scale, "m", range(1e-4, 1000.0),
      "width of one repeat of pattern or texture");
    v("pattern_colors", l.pattern_colors, "sRGB, one to three, beside color");
    v("texture", l.texture, "PNG on rest coordinates, instead of a pattern");
    v("weave", l.weave, "m", range(0.0, 1.0), "spacing of the threads; 0: smooth");
    v("weave_depth", l.weave_depth, "", range(0.0, 2.0), "slope of the threads' flanks");
    v("hem", l.hem, "m", range(0.0, 0.1),
      "thickness of the rim as drawn; 0: none; default: 2 mm, within the same bounds as contact_thickness");
    describe(v, static_cast<LookDesc&>(l));
}

template <class V>
void describe(V& v, ColliderLookDesc& l) {
    describe(v, static_cast<LookDesc&>(l));
}

/// A key frame of the camera's path.
template <class V>
void describe(V& v, CameraKey& k) {
    v("time", k.time, "s", within(1e9), "");
    v("position", k.position, "m", ranges::place, "");
    v("target", k.target, "m", ranges::place, "");
    v("field_of_view", k.field_of_view, "degree", range(1.0, 160.0), "");
}

template <class V>
void describe(V& v, CameraDesc& c) {
    v("position", c.position, "m", ranges::place, "of the eye");
    v("target", c.target, "m", ranges::place, "what it looks at");
    v("up", c.up, "", ranges::direction, "direction that is up in the picture");
    v("field_of_view", c.field_of_view, "degree", range(1.0, 160.0), "vertical");
    v("path", c.path, "smooth between these; drags still look from where the camera rests");
    v("turntable", c.turntable, "degree/s", range(-3600.0, 3600.0), "turn about the target");
    v("frame", c.framing, "auto: along the same line of sight, all cloth in the picture during the run");
}

template <class V>
void describe(V& v, LightDesc& l) {
    v("direction", l.direction, "", ranges::direction, "from the scene towards the light");
    v("color", l.color, "sRGB");
    v("intensity", l.intensity, "", range(0.0, 1e6), "irradiance of a facing plane");
    v("softness", l.softness, "m", range(0.0, 1.0), "least half-width of a shadow's edge");
    v("angle", l.angle, "degree", range(0.0, 45.0),
      "across the light, as seen from the scene; shadows soften with distance");
    v("shadow", l.shadow, "whether it casts shadows");
}

template <class V>
void describe(V& v, GroundDesc& g) {
    v("height", g.height, "m", ranges::place, "y of the floor");
    v("color", g.color, "sRGB, of the floor");
}

template <class V>
void describe(V& v, BackgroundDesc& b) {
    v("color", b.color, "sRGB, behind everything");
    v("sky", b.sky, "sRGB, light from above");
    v("ambient_occlusion", b.ambient_occlusion, "folds and corners get less of the sky's light");
    v("exposure", b.exposure, "", range(1e-6, 1e6), "factor on all light");
}

/// The pictures of a run have numbers of six digits.
inline constexpr int most_frames = 999'999;

template <class V>
void describe(V& v, OutputDesc& o) {
    v("size", o.size, "pixel", range(16, 8192), "of pictures and movie");
    v("frames", o.frames, "", range(1, most_frames), "when the command line does not say");
    v("preview_frames", o.preview_frames, "", range(1, most_frames), "frames of --preview, at most `frames`");
    v("playback_rate", o.playback_rate, "1/s", range(0.01, 1000.0),
      "frames per second of the movie; default: frame_rate");
    v("quality", o.quality, "", range(0, 51), "H.264 constant rate factor; 0: lossless");
}

template <class V>
void describe(V& v, AnnotationDesc& a) {
    v("caption", CaptionText{a.caption},
      "with {scene}, {time}, {frame}, {description} filled in; true: a usual one");
    v("shade", a.shade, "shown in colours instead of the fabric");
    v("shade_range", a.shade_range, "", within(1e12),
      "numbers at the ends of the colours; default: of the whole run");
    v("wireframe", a.wireframe, "the edges of the simulated triangles");
    v("ids", a.ids, "pixel", within(1e5), "vertex and triangle numbers there, magnified");
    v("curves", a.curves, "drawn in the picture");
    v("motion_blur", a.motion_blur, "", range(1, 64), "pictures of which each frame is the mean; 1: none");
    v("shutter", a.shutter, "", range(0.01, 1.0), "share of a frame's time during which they are taken");
}

template <class V>
void describe(V& v, ExpectDesc& e) {
    v("state_tolerance", e.state_tolerance, "m", range(1e-15, 1.0), "of golden states made by another build");
    v("frames", e.frames, "", range(0, most_frames - 1), "golden frames");
    v("max_stretch", e.max_stretch, "", range(0.0, 1e6), "greatest stretch of any triangle in a run");
    v("min_gap", e.min_gap, "m", ranges::distance,
      "of contact = \"barrier\", less than contact_activation: what stays between any two surfaces");
    v("max_residual", e.max_residual, "", range(0.0, 1.0), "that a solve may end with");
    v("max_energy_rise", e.max_energy_rise, "J", range(0.0, 1e12),
      "of kinetic and potential energy within a frame");
    v("all_converged", e.all_converged, "true: no step may have to be halved");
    v("max_seconds_per_frame", e.max_seconds_per_frame, "s", range(0.0, 1e6),
      "that simulating a frame may take");
}

template <class V>
void describe(V& v, SceneFile& f) {
    v("version", f.version, "", range(0, 1000), "of the scene format: 1");
    v("description", f.description, "one line for lists");
    v.table("simulation", f.scene.simulation);
    v.table("air", f.scene.simulation.air);
    v.list("cloth", f.scene.cloths, f.looks.cloths);
    v.list("part", f.scene.parts);
    v.list("collider", f.scene.colliders, f.looks.colliders);
    v.list("pin", f.scene.pins);
    v.list("seam", f.scene.seams);
    v.list("drag", f.scene.drags);
    v.list("event", f.scene.events);
    v.table("camera", f.camera);
    v.one_of_a_list("light", f.looks.light);
    v.table("ground", f.looks.ground);
    v.table("background", f.looks.background);
    v.table("output", f.output, f.annotation);
    v.table("expect", f.expect);
}

}  // namespace cloth::pipeline
