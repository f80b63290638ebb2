#include "render/raster/rasterizer.h"

#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <thread>

#include "render/gl/fabric_shader.h"
#include "render/gl/gl_objects.h"
#include "render/gl/shaders.h"
#include "render/raster/ambient_occlusion.h"
#include "render/raster/backdrop.h"
#include "render/raster/checks.h"
#include "render/raster/mesh_list.h"
#include "render/raster/projection.h"
#include "render/raster/tile_mask.h"

namespace cloth::render {
namespace {

constexpr int supersampling = 2;  // along each axis; the shaders are written for 2
constexpr int search_taps = 8, surface_taps = 14, ground_search_taps = 8, ground_taps = 20, settled_taps = 8;
constexpr int ground_occlusion_size = 40;
constexpr int tile = 8;            // pixels that are shaded or left out together
constexpr int caster_cells = 128;  // of the shadow map, along a side, that hold a caster or none
// What is shaded, and by which program, is told by the depth of its squares.
constexpr std::array<float, 2> layer_depths{-0.5f, 0.0f};
constexpr Matrix unchanged{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr int most_images = 4, image_unit = 5;
constexpr std::size_t most_vertices =
    (std::size_t{1} << 28) - 2;  // the bits that a sample has for its number

/// What hides sky or floor returns a part of their light: more than half is left where 0.4 of it comes
/// straight.
AmbientLight with_reflections(const AmbientLight& light, const AmbientLight& open) {
    const auto returned = [](float share, float all) {
        return all > 0 ? share * (1.7f - 0.7f * std::min(share / all, 1.0f)) : 0.0f;
    };
    return {returned(light.from_above, open.from_above), returned(light.from_below, open.from_below)};
}

/// What all passes of one draw share.
struct Shot {
    const Frame& frame;
    const View& view;
    Camera camera;
    Bounds bounds;      // of what casts shadows and occludes
    PixelBox box{};     // pixels that can show surfaces
    Float3 to_light{};  // unit length
    Float3 key{};       // radiance of a white plane that faces the light
    Float3 bounce{};    // light from below
    ShadowView shadow_view{};
    bool shadow = false, occlusion = false, ground = false;
};

/// Ray of pixel p: corner + p.x x + p.y y, of distance 1.
struct Rays {
    Float3 corner, x, y;
};
/// `step`: pixels of the picture per pixel of what is drawn.
Rays make_rays(const Shot& shot, int step) {
    const Camera& c = shot.camera;
    const auto halves = static_cast<float>(2 * step);
    return {c.forward - c.half_width * c.right - c.half_height * c.up,
            (halves * c.half_width / static_cast<float>(shot.view.width)) * c.right,
            (halves * c.half_height / static_cast<float>(shot.view.height)) * c.up};
}

/// What a frame's surfaces need of the shading program.
struct Features {
    bool patterns = false, weave = false, colors = false;
    int images = 0;
    auto operator<=>(const Features&) const = default;

    std::string defines() const {
        std::string text;
        if (patterns) text += "#define PATTERNS\n";
        if (weave) text += "#define WEAVE\n";
        if (colors) text += "#define COLORS\n";
        if (images > 0) text += "#define IMAGES " + std::to_string(images) + "\n";
        return text;
    }
};

}  // namespace

struct Rasterizer::Impl {
    Impl(int thread_count, GlLibrary library)
        : context(thread_count, library),
          threads(thread_count > 0 ? static_cast<std::size_t>(thread_count)
                                   : std::max<std::size_t>(1, std::thread::hardware_concurrency())) {
        gl.GenVertexArrays(1, &mesh_array);
        gl.BindVertexArray(mesh_array);
        gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.buffer());
        point_at(vertices, 4);
        gl.GenVertexArrays(1, &layer_array);
        gl.BindVertexArray(layer_array);
        point_at(layers, 3);
        gl.GenTextures(1, &ground_occlusion);
        for (GLuint* sampler : {&comparing, &smooth}) {
            gl.GenSamplers(1, sampler);
            for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
                gl.SamplerParameteri(*sampler, filter, GL_LINEAR);
            for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
                gl.SamplerParameteri(*sampler, wrap, GL_CLAMP_TO_EDGE);
        }
        gl.SamplerParameteri(comparing, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
        gl.SamplerParameteri(comparing, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        gl.ClearColor(1, 1, 1, 1);
        gl.DepthFunc(GL_LEQUAL);
        gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
        gl.PixelStorei(GL_UNPACK_ALIGNMENT, 1);
    }
    ~Impl() {
        context.make_current();
        gl.DeleteVertexArrays(1, &mesh_array);
        gl.DeleteVertexArrays(1, &layer_array);
        gl.DeleteTextures(1, &ground_occlusion);
        gl.DeleteSamplers(1, &comparing);
        gl.DeleteSamplers(1, &smooth);
        for (const auto& [image, texture] : textures) gl.DeleteTextures(1, &texture);
    }

    GlContext context;
    GlFunctions& gl = context.gl;
    std::size_t threads;
    Program depth_program{gl, {shaders::depth_vertex}, {shaders::depth_fragment}};
    Program visibility_program{gl, {shaders::visibility_vertex}, {shaders::visibility_fragment}};
    Program ground_shadow_program{
        gl,
        {shaders::depth_vertex},
        {"#define SHADOW\n", shaders::shadow, shaders::ground_point, shaders::ground_light_fragment}};
    Program ground_open_program{
        gl, {shaders::depth_vertex}, {shaders::ground_point, shaders::ground_light_fragment}};
    std::map<Features, std::unique_ptr<Program>> surface_programs;
    Target shadow_map{context, 0, GL_DEPTH_COMPONENT32F};
    Target samples{context, GL_R32UI, GL_DEPTH_COMPONENT32F};
    Target ground_light{context, GL_RGBA8, GL_DEPTH_COMPONENT16};
    Target shaded{context, GL_RGBA8, GL_DEPTH_COMPONENT16};
    ListBuffer vertices{context, GL_RGBA32UI}, corners{context, GL_RGBA32UI};
    ListBuffer ambients{context, GL_R32UI}, coordinates{context, GL_RG32F};
    ListBuffer materials{context, GL_RGBA32F}, colors{context, GL_RGBA32F};
    ListBuffer indices{context, 0}, layers{context, 0};
    GLuint mesh_array = 0, layer_array = 0, ground_occlusion = 0, comparing = 0, smooth = 0;
    std::map<std::shared_ptr<const Image>, GLuint> textures;
    MeshList list;
    AmbientOcclusion occlusion;
    std::vector<float> ambient;
    std::vector<std::uint8_t> pixels, ground_pixels;
    std::optional<Backdrop> backdrop;

    Image draw(const Frame& frame, const View& view);

    struct GroundTiles {
        TileMask shadowed, occluded;
    };
    void point_at(const ListBuffer& list_buffer, int components);
    void upload(const Frame& frame);
    void compute_ambient(const Shot& shot);
    Features upload_materials(const Frame& frame);
    GLuint texture_of(const std::shared_ptr<const Image>& image);
    Program& surface_program(const Features& features);
    void draw_shadow_map(const Shot& shot);
    void draw_samples(const Shot& shot);
    void bind_texture(int unit, GLuint texture, GLuint sampler);
    void set_rays(Program& program, const Shot& shot, int step);
    void set_shadow(Program& program, const Shot& shot, int first_unit);
    void draw_layers(const TileMask& layer_0, const TileMask& layer_1);
    void fill_layer(int layer);
    GroundTiles ground_tiles(const Shot& shot, const GroundPatch& patch, bool shadow) const;
    void draw_ground_light(const Shot& shot);
    Image compose(const Shot& shot);
    void shade(const Shot& shot, const Features& features);
    void read_back(int width, int height, std::vector<std::uint8_t>& pixels);
};

// ---------------------------------------------------------------- what shaders read
void Rasterizer::Impl::point_at(const ListBuffer& list_buffer, int components) {
    gl.BindBuffer(GL_ARRAY_BUFFER, list_buffer.buffer());
    gl.EnableVertexAttribArray(0);
    gl.VertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, static_cast<GLsizei>(components * sizeof(float)),
                           nullptr);
}

void Rasterizer::Impl::upload(const Frame& frame) {
    const bool changed = list.assemble(frame.surfaces);
    if (list.first_vertex.back() > most_vertices)
        throw std::invalid_argument("the surfaces have more than " + std::to_string(most_vertices) +
                                    " vertices");
    gl.BindVertexArray(mesh_array);
    if (changed) {
        indices.fill(std::span<const std::uint32_t>(list.indices));
        corners.fill(std::span<const std::uint32_t>(list.corners));
    }
    vertices.fill(std::span<const std::uint32_t>(list.vertices));
    if (!list.coordinates.empty()) coordinates.fill(std::span<const float>(list.coordinates));
    if (!list.colors.empty()) colors.fill(std::span<const float>(list.colors));
}

/// Light from above and below at each vertex: computed at some, spread from there over the others.
void Rasterizer::Impl::compute_ambient(const Shot& shot) {
    ambient.resize(4 * std::size_t{list.first_vertex.back()});
    for (std::size_t i = 0; i < shot.frame.surfaces.size(); ++i) {
        const Surface& surface = shot.frame.surfaces[i];
        const SurfaceTopology& topology = list.topologies[i];
        const std::span<float> values =
            std::span(ambient).subspan(4 * std::size_t{list.first_vertex[i]}, 4 * topology.vertices);
        const auto compute = [&](std::size_t v) {
            const Float3 p{surface.positions[3 * v], surface.positions[3 * v + 1],
                           surface.positions[3 * v + 2]};
            const Float3 n{surface.normals[3 * v], surface.normals[3 * v + 1], surface.normals[3 * v + 2]};
            AmbientLight front{0.5f * (1 + n[1]), 0.5f * (1 - n[1])};
            AmbientLight back{front.from_below, front.from_above};
            if (shot.occlusion) {
                front = with_reflections(occlusion.at(p, n), front);
                if (surface.two_sided) back = with_reflections(occlusion.at(p, -1.0f * n), back);
            }
            const std::array<float, 4> value{front.from_above, front.from_below, back.from_above,
                                             back.from_below};
            std::copy(value.begin(), value.end(), values.begin() + static_cast<std::ptrdiff_t>(4 * v));
        };
        if (!shot.occlusion) {
            for (std::size_t v = 0; v < topology.vertices; ++v) compute(v);
            list.set_ambient(i, values);
            continue;
        }
        // Each anchor stands alone, so how they are shared out changes nothing.
        const auto compute_anchors = [&](std::size_t first, std::size_t last) {
            for (std::size_t a = first; a < last; ++a) compute(topology.anchors[a]);
        };
        constexpr std::size_t anchors_per_thread = 1000;
        const std::size_t count = topology.anchors.size();
        const std::size_t parts = std::clamp<std::size_t>(count / anchors_per_thread, 1, threads);
        std::vector<std::jthread> helpers;
        for (std::size_t part = 1; part < parts; ++part)
            helpers.emplace_back(compute_anchors, count * part / parts, count * (part + 1) / parts);
        compute_anchors(0, count / parts);
        helpers.clear();
        spread(topology, values);
        // Where a layer lies nearer than a cell, neighbours see it differently: seen as teeth along folds.
        constexpr int passes = 4;
        even_out(topology, passes, values);
        list.set_ambient(i, values);
    }
    ambients.fill(std::span<const std::uint32_t>(list.ambient));
}

GLuint Rasterizer::Impl::texture_of(const std::shared_ptr<const Image>& image) {
    const auto [entry, fresh] = textures.try_emplace(image, 0);
    if (!fresh) return entry->second;
    gl.GenTextures(1, &entry->second);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, entry->second);
    // OpenGL's rows start at the bottom.
    const std::size_t row = std::size_t{4} * image->width;
    std::vector<std::uint8_t> turned;
    for (std::size_t y = image->height; y-- > 0;)
        turned.insert(turned.end(), image->rgba.begin() + static_cast<std::ptrdiff_t>(row * y),
                      image->rgba.begin() + static_cast<std::ptrdiff_t>(row * (y + 1)));
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_SRGB8_ALPHA8, image->width, image->height, 0, GL_RGBA,
                  GL_UNSIGNED_BYTE, turned.data());
    gl.GenerateMipmap(GL_TEXTURE_2D);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_LINEAR);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    return entry->second;
}

Features Rasterizer::Impl::upload_materials(const Frame& frame) {
    Features features;
    std::vector<std::shared_ptr<const Image>> images;
    std::vector<float> texels;
    for (const Surface& surface : frame.surfaces) {
        const Material& m = surface.material;
        const float roughness = std::clamp(m.roughness, 0.05f, 1.0f);
        const bool patterned = m.pattern != Pattern::plain && m.pattern != Pattern::image;
        float number = 0;
        if (m.pattern == Pattern::image) {
            const auto place = std::find(images.begin(), images.end(), m.image);
            number = static_cast<float>(place - images.begin() + 1);
            if (place == images.end()) images.push_back(m.image);
        }
        features.patterns |= patterned;
        features.weave |= m.weave > 0;
        features.colors |= !surface.colors.empty();
        const auto add = [&](const Float3& rgb, float a) {
            texels.insert(texels.end(), {rgb[0], rgb[1], rgb[2], a});
        };
        add(m.front, roughness * roughness * roughness * roughness);
        add(m.back, 0.5f * roughness * roughness);
        add({m.specular, m.sheen, surface.two_sided ? 1.0f : 0.0f},
            winding_follows_normals(surface) ? 1.0f : -1.0f);
        add({patterned ? static_cast<float>(m.pattern) : 0.0f,
             m.pattern == Pattern::plain ? 0 : 1 / m.pattern_scale, m.weave > 0 ? 1 / m.weave : 0},
            m.weave_depth);
        add(m.pattern_colors[0], m.pattern_on_back ? 1.0f : 0.0f);
        add(m.pattern_colors[1], number);
        add(m.pattern_colors[2], 0);
    }
    features.images = static_cast<int>(images.size());
    if (features.images > most_images)
        throw std::invalid_argument("the surfaces show " + std::to_string(features.images) +
                                    " different images; at most " + std::to_string(most_images) +
                                    " can be drawn");
    for (int i = 0; i < features.images; ++i) {
        const GLuint texture = texture_of(images[static_cast<std::size_t>(i)]);
        bind_texture(image_unit + i, texture, 0);
    }
    materials.fill(std::span<const float>(texels));
    return features;
}

Program& Rasterizer::Impl::surface_program(const Features& features) {
    std::unique_ptr<Program>& program = surface_programs[features];
    if (!program)
        program.reset(new Program(gl, {shaders::depth_vertex},
                                  {features.defines().c_str(), shaders::tone_curve, shaders::shadow,
                                   shaders::pattern, shaders::surface_fragment}));
    return *program;
}

// ---------------------------------------------------------------- passes
void Rasterizer::Impl::draw_shadow_map(const Shot& shot) {
    const int size = shot.shadow ? shot.shadow_view.size : 16;
    shadow_map.bind(size, size);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    if (!shot.shadow) return;
    // The outermost texels stay empty: they are what lies beyond the map.
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(1, 1, size - 2, size - 2);
    depth_program.use();
    depth_program.set("world_to_clip", shot.shadow_view.world_to_clip);
    gl.BindVertexArray(mesh_array);
    gl.DrawElements(GL_TRIANGLES, static_cast<GLsizei>(list.casting_indices), GL_UNSIGNED_INT, nullptr);
    gl.Disable(GL_SCISSOR_TEST);
}

/// The number of the triangle that each sample sees.
void Rasterizer::Impl::draw_samples(const Shot& shot) {
    samples.bind(supersampling * shot.view.width, supersampling * shot.view.height);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_DEPTH_BUFFER_BIT);  // numbers stay; what is farthest shows none
    gl.Enable(GL_CLIP_DISTANCE0);
    Program& p = visibility_program;
    p.use();
    p.set("world_to_clip", shot.camera.world_to_clip);
    // llvmpipe clips by the distance even while it is disabled, so without a floor it lies out of reach.
    p.set("clip_height", shot.ground ? shot.frame.ground->height : -1e30f);
    gl.BindVertexArray(mesh_array);
    for (std::size_t i = 0; i < list.topologies.size(); ++i) {
        p.set("surface", static_cast<int>(i % 8));
        gl.DrawElements(
            GL_TRIANGLES, static_cast<GLsizei>(list.topologies[i].indices.size()), GL_UNSIGNED_INT,
            reinterpret_cast<const void*>(sizeof(std::uint32_t) * std::size_t{list.first_index[i]}));
    }
    gl.Disable(GL_CLIP_DISTANCE0);
}

void Rasterizer::Impl::bind_texture(int unit, GLuint texture, GLuint sampler) {
    gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    gl.BindTexture(GL_TEXTURE_2D, texture);
    gl.BindSampler(static_cast<GLuint>(unit), sampler);
}

void Rasterizer::Impl::set_rays(Program& p, const Shot& shot, int step) {
    const Rays rays = make_rays(shot, step);
    p.set("eye", shot.view.eye);
    p.set("ray_corner", rays.corner);
    p.set("ray_x", rays.x);
    p.set("ray_y", rays.y);
}

void Rasterizer::Impl::set_shadow(Program& p, const Shot& shot, int first_unit) {
    const ShadowView& s = shot.shadow_view;
    bind_texture(first_unit, shadow_map.depth(), comparing);
    bind_texture(first_unit + 1, shadow_map.depth(), 0);
    p.set("shadow_map", first_unit);
    p.set("shadow_depth", first_unit + 1);
    p.set("world_to_shadow", s.world_to_texture);
    p.set("shadow_radius", s.radius / s.width, s.largest_radius / s.width);
    p.set("shadow_spread",
          s.depth / s.width * std::tan(0.5f * shot.view.light.angle * std::numbers::pi_v<float> / 180));
}

/// Lays squares into the depth buffer, those of two layers at depths of their own, for fill_layer.
void Rasterizer::Impl::draw_layers(const TileMask& layer_0, const TileMask& layer_1) {
    std::vector<float> positions;
    for (const float z : layer_depths) positions.insert(positions.end(), {-1, -1, z, 3, -1, z, -1, 3, z});
    layer_0.append_triangles(positions, layer_depths[0]);
    layer_1.append_triangles(positions, layer_depths[1]);
    gl.BindVertexArray(layer_array);
    layers.fill(std::span<const float>(positions));
    gl.Enable(GL_DEPTH_TEST);
    depth_program.use();
    depth_program.set("world_to_clip", unchanged);
    gl.DrawArrays(GL_TRIANGLES, 6, static_cast<GLsizei>(positions.size() / 3 - 6));
    gl.DepthFunc(GL_EQUAL);
}

/// Draws over the squares of a layer, with a program whose `world_to_clip` leaves positions as they are.
/// llvmpipe goes once through a loop's body even where no pixel of a block wants it, but not where all fail
/// the depth test.
void Rasterizer::Impl::fill_layer(int layer) {
    gl.DrawArrays(GL_TRIANGLES, 3 * layer, 3);
}

/// Where shadow can fall on the floor, and where else objects can hide the sky from it.
Rasterizer::Impl::GroundTiles Rasterizer::Impl::ground_tiles(const Shot& shot, const GroundPatch& patch,
                                                             bool shadow) const {
    const View& view = shot.view;
    GroundTiles tiles{{(view.width + 1) / 2, (view.height + 1) / 2, tile},
                      {(view.width + 1) / 2, (view.height + 1) / 2, tile}};
    const ShadowView& s = shot.shadow_view;
    TileMask casters(caster_cells, caster_cells, 1);
    if (shadow)
        for (const Surface& surface : shot.frame.surfaces)
            if (surface.casts_shadow) casters.mark(surface, s.world_to_clip);
    const float reach = (s.largest_radius + 2 * s.texel) / s.width;
    // Where the rays through the tiles' corners meet the floor, and that point in the map
    struct Corner {
        bool on_floor;
        Float3 floor, map;
    };
    const Rays rays = make_rays(shot, 2 * tile);
    const int across = tiles.shadowed.columns() + 1;
    std::vector<Corner> corners_of_tiles;
    for (int row = 0; row <= tiles.shadowed.rows(); ++row)
        for (int column = 0; column < across; ++column) {
            const Float3 ray =
                rays.corner + static_cast<float>(column) * rays.x + static_cast<float>(row) * rays.y;
            const Float3 p = view.eye + ((patch.height - view.eye[1]) / std::min(ray[1], -1e-4f)) * ray;
            corners_of_tiles.push_back({ray[1] < -1e-4f, p, transformed(s.world_to_texture, p)});
        }
    for (int row = 0; row < tiles.shadowed.rows(); ++row)
        for (int column = 0; column < tiles.shadowed.columns(); ++column) {
            Bounds on_floor = nothing, on_map = nothing;
            int below = 0;  // the horizon
            for (const int corner : {0, 1, across, across + 1}) {
                const Corner& c = corners_of_tiles[static_cast<std::size_t>(row * across + column + corner)];
                below += c.on_floor;
                on_floor = merged(on_floor, {c.floor, c.floor});
                on_map = merged(on_map, {c.map, c.map});
            }
            if (below == 0) continue;
            const bool in_patch =
                below < 4 || (on_floor.low[0] < patch.high[0] && on_floor.high[0] > patch.low[0] &&
                              on_floor.low[2] < patch.high[1] && on_floor.high[2] > patch.low[1]);
            const bool in_shadow =
                shadow && (below < 4 || casters.any(on_map.low[0] - reach, on_map.low[1] - reach,
                                                    on_map.high[0] + reach, on_map.high[1] + reach));
            if (in_shadow)
                tiles.shadowed.mark(column, row);
            else if (in_patch)
                tiles.occluded.mark(column, row);
        }
    return tiles;
}

/// Light that reaches the floor near the objects; all of it elsewhere.
void Rasterizer::Impl::draw_ground_light(const Shot& shot) {
    const bool near_objects = shot.ground && (shot.shadow || shot.occlusion);
    if (near_objects)
        ground_light.bind((shot.view.width + 1) / 2, (shot.view.height + 1) / 2);
    else
        ground_light.bind(16, 16);
    gl.ClearColor(1, 1, 1, 1);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (!near_objects) return;

    const GroundPatch patch = ground_patch(shot.bounds, shot.frame.ground->height);
    constexpr int size = ground_occlusion_size;
    std::vector<float> open(std::size_t{size} * size, 1.0f);
    if (shot.occlusion)
        for (int j = 1; j < size - 1; ++j)  // the outermost texels hold 1, which clamping spreads outwards
            for (int i = 1; i < size - 1; ++i) {
                const float u = (static_cast<float>(i) + 0.5f) / size,
                            v = (static_cast<float>(j) + 0.5f) / size;
                const Float3 point{patch.low[0] + u * (patch.high[0] - patch.low[0]), patch.height,
                                   patch.low[1] + v * (patch.high[1] - patch.low[1])};
                const float visible = occlusion.at(point, {0, 1, 0}, /*on_surface=*/false).from_above;
                const float edge = std::min({u, v, 1 - u, 1 - v}) - 1.0f / size;
                const float fade = std::clamp(8 * edge, 0.0f, 1.0f);
                // What hides the sky returns a part of the floor's own light.
                open[std::size_t{size} * j + i] = 1 - 0.55f * (1 - visible) * fade * fade * (3 - 2 * fade);
            }
    bind_texture(0, ground_occlusion, smooth);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, size, size, 0, GL_RED, GL_FLOAT, open.data());

    const bool shadow = shot.shadow && shot.to_light[1] > 1e-3f;
    const auto [shadowed, occluded] = ground_tiles(shot, patch, shadow);
    draw_layers(shadowed, occluded);
    const float scale_x = 1 / (patch.high[0] - patch.low[0]), scale_z = 1 / (patch.high[1] - patch.low[1]);
    for (Program* p : {&ground_shadow_program, &ground_open_program}) {
        p->use();
        p->set("world_to_clip", unchanged);
        set_rays(*p, shot, 2);
        p->set("ground_height", patch.height);
        p->set("ground_occlusion", 0);
        p->set("ground_occlusion_place",
               std::array<float, 4>{scale_x, scale_z, -patch.low[0] * scale_x, -patch.low[1] * scale_z});
    }
    bind_texture(0, ground_occlusion, smooth);
    fill_layer(1);
    Program& p = ground_shadow_program;
    p.use();
    set_shadow(p, shot, 2);
    const ShadowView& s = shot.shadow_view;
    p.set("shadow_place", s.place);
    const float slope = s.width / s.depth / std::max(shot.to_light[1], 0.05f);
    p.set("ground_slope", slope * s.x[1], slope * s.y[1]);
    p.set("search_taps", shot.view.light.angle > 0 ? ground_search_taps : 0);
    p.set("shadow_taps", ground_taps);
    p.set("settled_taps", settled_taps);
    fill_layer(0);
    gl.DepthFunc(GL_LEQUAL);
}

/// Colour of the surfaces and their share of each pixel.
void Rasterizer::Impl::shade(const Shot& shot, const Features& features) {
    const View& view = shot.view;
    shaded.bind(view.width, view.height);
    gl.ClearColor(0, 0, 0, 0);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    if (shot.box.width <= 0 || shot.box.height <= 0) return;
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(shot.box.x, shot.box.y, shot.box.width, shot.box.height);
    bind_texture(0, samples.color(), 0);
    TileMask seen(view.width, view.height, tile);
    for (const Surface& surface : shot.frame.surfaces) seen.mark(surface, shot.camera.world_to_clip);
    draw_layers(seen, TileMask(0, 0, tile));
    Program& p = surface_program(features);
    p.use();
    p.set("world_to_clip", unchanged);
    p.set("numbers", 0);
    p.set("texel", 1 / static_cast<float>(view.width), 1 / static_cast<float>(view.height));
    bind_texture(1, samples.depth(), 0);
    p.set("depths", 1);
    set_shadow(p, shot, 2);
    set_rays(p, shot, 1);
    for (int i = 0; i < features.images; ++i)
        p.set(("images[" + std::to_string(i) + "]").c_str(), image_unit + i);
    int unit = image_unit + most_images;
    for (const auto& [name, buffer] : {std::pair{"vertices", &vertices},
                                       {"corners", &corners},
                                       {"ambients", &ambients},
                                       {"coordinates", &coordinates},
                                       {"materials", &materials},
                                       {"colors", &colors}}) {
        buffer->bind_texture(unit);
        p.set(name, unit++);
    }
    p.set("near", shot.camera.near);
    p.set("light_direction", shot.to_light);
    p.set("light_radiance", shot.key);
    p.set("sky", view.sky);
    p.set("bounce", shot.bounce);
    p.set("exposure", view.exposure);
    const ShadowView& s = shot.shadow_view;
    p.set("shadow_x", (s.width / s.depth) * s.x);
    p.set("shadow_y", (s.width / s.depth) * s.y);
    p.set("search_taps", shot.shadow && view.light.angle > 0 ? search_taps : 0);
    p.set("shadow_taps", shot.shadow ? surface_taps : 0);
    p.set("settled_taps", settled_taps);
    // A comparison is of up to four texels around a tap.
    p.set("normal_offset", 1.5f * s.texel);
    fill_layer(0);
    gl.Disable(GL_SCISSOR_TEST);
    gl.DepthFunc(GL_LEQUAL);
}

void Rasterizer::Impl::read_back(int width, int height, std::vector<std::uint8_t>& into) {
    into.resize(std::size_t{4} * width * height);
    gl.ReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, into.data());
    if (const GLenum error = gl.GetError(); error != GL_NO_ERROR)
        throw std::runtime_error("the OpenGL driver (" + context.renderer + ") failed to draw, error " +
                                 std::to_string(error));
}

Image Rasterizer::Impl::compose(const Shot& shot) {
    const View& view = shot.view;
    Image image{view.width, view.height, {}};
    read_back(view.width, view.height, pixels);
    GroundLight light;
    if (shot.ground && (shot.shadow || shot.occlusion)) {
        light = {(view.width + 1) / 2, (view.height + 1) / 2, {}};
        ground_light.bind(light.width, light.height);
        read_back(light.width, light.height, ground_pixels);
        light.shares = ground_pixels;
    }
    const Float3 color = shot.ground ? view.exposure * shot.frame.ground->color : Float3{};
    const Ground* ground = shot.ground ? &*shot.frame.ground : nullptr;
    const Float3 lit = std::max(shot.to_light[1], 0.0f) * (color * shot.key),
                 ambient_light = color * view.sky;
    const bool fresh = !backdrop || !backdrop->is_of(view, ground, lit, ambient_light);
    if (fresh) backdrop.emplace(view, ground, lit, ambient_light);
    // Each row stands alone.
    const int parts = std::min<int>(static_cast<int>(threads), std::max(1, view.height / 64));
    const auto in_parts = [&](const auto& work) {
        std::vector<std::jthread> helpers;
        for (int part = 1; part < parts; ++part)
            helpers.emplace_back(
                [&, part] { work(view.height * part / parts, view.height * (part + 1) / parts); });
        work(0, view.height / parts);
    };
    if (fresh) in_parts([&](int first, int last) { backdrop->draw_open(first, last); });
    image.rgba = backdrop->open();
    in_parts([&](int first, int last) { backdrop->compose(pixels, light, image, first, last); });
    return image;
}

Image Rasterizer::Impl::draw(const Frame& frame, const View& view) {
    require_view(view);
    Bounds casting = nothing, all = nothing;
    for (std::size_t i = 0; i < frame.surfaces.size(); ++i) {
        const Bounds surface_bounds = checked_bounds(frame.surfaces[i], i);
        all = merged(all, surface_bounds);
        if (frame.surfaces[i].casts_shadow) casting = merged(casting, surface_bounds);
    }
    if (frame.ground) require_ground(*frame.ground);
    const bool occupied = casting.low[0] <= casting.high[0];

    Shot shot{
        .frame = frame, .view = view, .camera = make_camera(view), .bounds = shadow_bounds(view, casting)};
    if (all.low[0] <= all.high[0]) shot.box = pixels_of(all, shot.camera, view);
    shot.to_light = normalized(view.light.direction);
    shot.key = (view.light.intensity / std::numbers::pi_v<float>)*view.light.color;
    // A floor returns what it gets, a part of it shaded by what stands there; without one, the background's
    // glow stands in.
    const std::optional<Float3> floor = frame.ground ? std::optional(frame.ground->color) : frame.floor_color;
    shot.bounce = floor ? *floor * (0.9f * view.sky + (0.75f * std::max(shot.to_light[1], 0.0f)) * shot.key)
                        : 0.5f * view.background;
    shot.ground = frame.ground && view.eye[1] > frame.ground->height;
    shot.shadow = view.light.shadow && occupied;
    shot.occlusion = view.ambient_occlusion && occupied;
    if (shot.shadow) shot.shadow_view = make_shadow_view(view.light, shot.bounds);

    context.make_current();
    upload(frame);
    draw_samples(shot);
    draw_shadow_map(shot);
    gl.Flush();  // the driver's threads draw while this one goes on
    if (shot.occlusion) occlusion.build(frame.surfaces, shot.bounds);
    compute_ambient(shot);
    const Features features = upload_materials(frame);
    draw_ground_light(shot);
    shade(shot, features);
    return compose(shot);
}

// ---------------------------------------------------------------- the public face
Rasterizer::Rasterizer(int threads, GlLibrary library) : impl_(std::make_unique<Impl>(threads, library)) {}
Rasterizer::~Rasterizer() = default;
Rasterizer::Rasterizer(Rasterizer&&) noexcept = default;
Image Rasterizer::draw(const Frame& frame, const View& view) {
    return impl_->draw(frame, view);
}
std::string Rasterizer::description() const {
    return impl_->context.renderer + ", OpenGL " + impl_->context.version;
}

}  // namespace cloth::render
