#pragma once
// What a scene may ask of its pictures beyond the scene itself: how the camera moves, and what is drawn over
// them. Plain structs; scene_file.h fills them.

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "sim/algebra/types.h"
#include "sim/fields/vertex_fields.h"

namespace cloth::pipeline {

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
    Vec3 position{0.0, 0.3, 2.5}, target{0.0, 0.0, 0.0};  ///< [m]
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
    {Curve::energy, "energy", "energy [J]"},
    {Curve::kinetic, "kinetic", "kinetic energy [J]"},
    {Curve::stretch, "stretch", "greatest stretch"},
    {Curve::gap, "gap", "smallest gap [mm]"},
    {Curve::iterations, "iterations", "iterations"},
    {Curve::contacts, "contacts", "contacts"}};

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

inline const std::string default_caption = "{scene}   t = {time} s   frame {frame}";

}  // namespace cloth::pipeline
