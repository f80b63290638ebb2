#pragma once
// What a picture shows, and how it is looked at. Nothing here knows of cloth simulation.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <vector>

namespace cloth::render {

struct Image;

using Float3 = std::array<float, 3>;

/// Drawn on rest coordinates, so that it moves and stretches with the cloth. One repeat is pattern_scale
/// wide.
enum class Pattern {
    plain,    ///< the front colour
    stripes,  ///< along v: half a repeat of the front colour, half of the first pattern colour
    checks,   ///< a checkerboard of squares half a repeat wide, front colour and first pattern colour
    tartan,   ///< bands of the front and three pattern colours, woven crosswise
    dots,     ///< of the first pattern colour on the front colour, a quarter of a repeat in radius
    image,    ///< one repeat wide, its upper edge along +v
};

/// Colours are linear Rec. 709 reflectances in 0 … 1.
struct Material {
    Float3 front{0.8f, 0.8f, 0.8f};  ///< the side the normals point to
    Float3 back{0.8f, 0.8f, 0.8f};   ///< the other side
    float roughness = 0.7f;          ///< of the specular lobe, 0 … 1
    float specular = 0.04f;          ///< reflectance at normal incidence
    float sheen = 0.0f;              ///< strength of the soft glow of fibres at grazing angles
    Pattern pattern = Pattern::plain;
    float pattern_scale = 0.1f;              ///< width of one repeat [m]
    std::array<Float3, 3> pattern_colors{};  ///< beside the front colour
    bool pattern_on_back = false;            ///< woven rather than printed: both sides show it
    std::shared_ptr<const Image> image{};    ///< of Pattern::image
    float weave = 0.0f;        ///< spacing of the threads [m]; 0: smooth. Fades where a pixel holds several
    float weave_depth = 0.5f;  ///< slope of a thread's flanks
};

/// A triangle mesh. The spans must outlive draw().
struct Surface {
    std::span<const float> positions;          ///< x y z per vertex [m]
    std::span<const float> normals;            ///< x y z per vertex, unit length
    std::span<const std::uint32_t> triangles;  ///< three vertex indices per triangle
    Material material;
    bool two_sided = false;                ///< lit on both sides (cloth)
    bool casts_shadow = true;              ///< false for large floors and walls: they only receive it
    std::span<const float> coordinates{};  ///< rest coordinates u v per vertex [m], or none: all 0
    std::span<const float> colors{};       ///< r g b per vertex, linear, instead of the material's, or none
};

/// An endless horizontal floor that fades into the background.
struct Ground {
    float height = 0.0f;  ///< y [m]
    Float3 color{0.6f, 0.6f, 0.6f};
    bool operator==(const Ground&) const = default;
};

struct Frame {
    std::vector<Surface> surfaces;
    std::optional<Ground> ground;
    std::optional<Float3> floor_color{};  ///< of a floor among the surfaces, for the light that it returns
};

struct Light {
    Float3 direction{-0.75f, 1.0f, 0.45f};  ///< from the scene towards the light; any length but zero
    Float3 color{1.0f, 0.97f, 0.92f};       ///< linear
    float intensity = 2.6f;  ///< irradiance on a facing plane, in units where π·reflectance⁻¹ is white
    bool shadow = true;
    float softness = 0.003f;  ///< least half-width of a shadow's edge [m]
    float angle = 4.0f;  ///< across the light, as seen from the scene [degree]: edges widen with distance
    bool operator==(const Light&) const = default;
};

struct View {
    int width = 1280, height = 720;   ///< [pixel]
    Float3 eye{0.0f, 0.0f, 3.0f};     ///< [m]
    Float3 target{0.0f, 0.0f, 0.0f};  ///< [m]
    Float3 up{0.0f, 1.0f, 0.0f};
    float field_of_view = 35.0f;  ///< vertical [degree]
    Light light;
    Float3 sky{0.44f, 0.47f, 0.53f};        ///< light from above, linear
    Float3 background{0.8f, 0.82f, 0.85f};  ///< linear
    float exposure = 1.0f;
    bool ambient_occlusion = true;  ///< folds and the floor near objects get less of the sky's light
    /// Two corners [m] of the box inside which surfaces cast shadows and occlude. Empty: that of the frame's
    /// shadow-casting surfaces, widened a little so that it seldom changes from frame to frame.
    std::optional<std::array<Float3, 2>> shadow_bounds;
    bool operator==(const View&) const = default;
};

}  // namespace cloth::render
