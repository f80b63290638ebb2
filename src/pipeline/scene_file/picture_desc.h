#pragma once
// What a scene may ask of its pictures beyond the scene itself: how cloths, colliders and the room are drawn,
// how the camera moves, and what is drawn over the pictures. Plain structs with a default, a unit and the
// effect of each field; picture_schema.h names their keys.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "render/frame.h"
#include "render/image/image.h"
#include "sim/algebra/types.h"
#include "sim/fields/vertex_fields.h"

namespace cloth::pipeline {

/// sRGB, each part 0 … 1; used in linear light.
struct Color {
    Vec3 srgb;
    render::Float3 linear() const;
};

/// How the surface of a cloth or collider is drawn.
struct LookDesc {
    Color color{Vec3(0.8, 0.8, 0.8)};  ///< of the front
    std::optional<Color> back_color;   ///< default: as the front
    double roughness = 0.75;           ///< of the specular lobe
    double specular = 0.03;            ///< reflectance at normal incidence
    double sheen = 0.0;                ///< soft glow of fibres at grazing angles
};

struct ClothLookDesc : LookDesc {
    ClothLookDesc() : LookDesc{.color = {Vec3(0.72, 0.16, 0.14)}, .sheen = 0.35} {}
    int subdivisions = 1;  ///< Loop steps that smooth the drawn surface
    std::optional<render::Pattern>
        pattern;                 ///< on rest coordinates; on the back too, unless that has a colour
    double pattern_scale = 0.2;  ///< width of one repeat of pattern or texture [m]
    /// One to three, beside `color`.
    std::vector<Color> pattern_colors{
        {Vec3(0.93, 0.91, 0.86)}, {Vec3(0.10, 0.14, 0.26)}, {Vec3(0.85, 0.68, 0.25)}};
    std::shared_ptr<const render::Image> texture;  ///< instead of a pattern
    double weave = 0.0;                            ///< spacing of the threads [m]; 0: smooth
    double weave_depth = 0.5;                      ///< slope of the threads' flanks
    /// Thickness of the rim as drawn [m]; 0: none; default: usual_length(2e-3).
    std::optional<double> hem;
};

struct ColliderLookDesc : LookDesc {
    ColliderLookDesc() : LookDesc{.color = {Vec3(0.35, 0.42, 0.5)}, .roughness = 0.35, .specular = 0.05} {}
};

struct LightDesc {
    render::Float3 direction = render::Light{}.direction;  ///< from the scene towards the light
    Color color{Vec3(1.0, 0.985, 0.96)};
    float intensity = render::Light{}.intensity;  ///< irradiance of a facing plane
    float softness = render::Light{}.softness;    ///< least half-width of a shadow's edge [m]
    float angle = render::Light{}.angle;          ///< across the light, as seen from the scene [degree]
    bool shadow = render::Light{}.shadow;
};

struct GroundDesc {
    double height = 0.0;  ///< y of the floor [m]
    Color color{Vec3(0.78, 0.78, 0.78)};
};

struct BackgroundDesc {
    Color color{Vec3(0.87, 0.89, 0.91)};  ///< behind everything
    Color sky{Vec3(0.69, 0.71, 0.75)};    ///< light from above
    bool ambient_occlusion = render::View{}.ambient_occlusion;
    double exposure = 1.0;  ///< factor on all light
};

/// A place of the camera on its way; what is left out is as in CameraDesc.
struct CameraKey {
    double time = 0.0;  ///< [s]
    std::optional<Vec3> position, target;
    std::optional<double> field_of_view;
};

enum class Framing {
    fixed,      ///< as position, target and path say
    automatic,  ///< along the same line of sight, so that all cloth is in the picture during the whole run
};

struct CameraDesc {
    Vec3 position{0.9, 0.8, 1.9}, target{0.0, 0.0, 0.0};  ///< [m]
    Vec3 up{0.0, 1.0, 0.0};
    double field_of_view = 35.0;  ///< vertical [degree]
    std::vector<CameraKey> path;  ///< times ascend
    double turntable = 0.0;       ///< turn about the target, counter-clockwise seen from above [degree/s]
    Framing framing = Framing::fixed;
};

/// Numbers and lines about a run, one per frame.
enum class Curve { energy, kinetic, stretch, gap, iterations, contacts };

struct CurveName {
    Curve curve;
    const char *name, *title;  ///< as in scene files; for people, with its unit
};
inline constexpr CurveName curve_names[] = {
    {Curve::energy, "energy", "energy [J]"},         {Curve::kinetic, "kinetic", "kinetic energy [J]"},
    {Curve::stretch, "stretch", "greatest stretch"}, {Curve::gap, "gap", "smallest gap [mm]"},
    {Curve::iterations, "iterations", "iterations"}, {Curve::contacts, "contacts", "contacts"}};

/// A circle in the picture [pixel].
struct PicturePlace {
    double x = 0, y = 0, radius = 0;  ///< radius 0: a twentieth of the picture's height
};

/// What is drawn over a picture. By default nothing is.
struct AnnotationDesc {
    std::optional<std::string> caption;  ///< with {scene}, {time}, {frame} and {description} filled in
    std::optional<VertexField> shade;    ///< shown in colours instead of the fabric
    std::optional<std::array<double, 2>> shade_range;  ///< of the colours; default: that of the whole run
    bool wireframe = false;                            ///< edges of the simulated triangles
    std::optional<PicturePlace> ids;                   ///< vertices and triangles there, magnified
    std::vector<Curve> curves;
    int motion_blur = 1;   ///< pictures of which each frame is the mean; 1: none
    double shutter = 0.5;  ///< share of the frame's time during which they are taken, up to its end
};

/// Width and height [pixel].
struct PixelSize {
    int width, height;
};

struct OutputDesc {
    PixelSize size{1280, 720};            ///< of the pictures
    int frames = 300;                     ///< when the command line does not say
    int preview_frames = 60;              ///< when --preview asks for a short run
    std::optional<double> playback_rate;  ///< frames per second of the movie; default: simulation frame rate
    int quality = 18;                     ///< H.264 constant rate factor, 0 (lossless) … 51
};

/// What a scene is held to: how near its golden states must be, and limits that no frame of a run may break.
struct ExpectDesc {
    double state_tolerance = 1e-6;          ///< greatest distance of any vertex where the build differs [m]
    std::vector<int> frames;                ///< golden frames
    std::optional<double> max_stretch;      ///< greatest principal stretch of any triangle
    std::optional<double> min_gap;          ///< left between any two surfaces [m]
    std::optional<double> max_residual;     ///< of a frame's solves
    std::optional<double> max_energy_rise;  ///< within a frame [J]
    bool all_converged = false;             ///< no step had to be halved
    std::optional<double> max_seconds_per_frame;  ///< of simulation [s]
};

inline const std::string default_caption = "{scene}   t = {time} s   frame {frame}";

}  // namespace cloth::pipeline
