#include "render/raster/rasterizer.h"

#include <map>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <thread>

#include "render/gl/gl_objects.h"
#include "render/gl/shaders.h"
#include "render/raster/ambient_occlusion.h"
#include "render/raster/backdrop.h"
#include "render/raster/checks.h"
#include "render/raster/ground.h"
#include "render/raster/materials.h"
#include "render/raster/mesh_list.h"
#include "render/raster/projection.h"
#include "render/raster/shot.h"
#include "render/raster/tile_mask.h"
#include "render/raster/vertex_light.h"

namespace cloth::render {
namespace {

constexpr int supersampling = 2;  // along each axis; the shaders are written for 2
constexpr int search_taps = 8, surface_taps = 14, ground_search_taps = 8, ground_taps = 20, settled_taps = 8;
constexpr int ground_occlusion_size = 40;
constexpr int tile = 8;  // pixels that are shaded or left out together
// What is shaded, and by which program, is told by the depth of its squares.
constexpr std::array<float, 2> layer_depths{-0.5f, 0.0f};
constexpr Matrix unchanged{1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr int most_images = 4, image_unit = 5;
constexpr std::size_t most_vertices =
    (std::size_t{1} << 28) - 2;  // the bits that a sample has for its number

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
    std::vector<std::uint8_t> pixels, ground_pixels;
    std::optional<Backdrop> backdrop;

    Image draw(const Frame& frame, const View& view);

    void point_at(const ListBuffer& list_buffer, int components);
    void upload(const Frame& frame);
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
    const MaterialTexels all = material_texels(frame.surfaces, most_images);
    for (std::size_t i = 0; i < all.images.size(); ++i)
        bind_texture(image_unit + static_cast<int>(i), texture_of(all.images[i]), 0);
    materials.fill(std::span<const float>(all.texels));
    return all.features;
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
    const std::vector<float> open = ground_openness(shot, patch, occlusion, size);
    bind_texture(0, ground_occlusion, smooth);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, size, size, 0, GL_RED, GL_FLOAT, open.data());

    const bool shadow = shot.shadow && shot.to_light[1] > 1e-3f;
    const auto [shadowed, occluded] = ground_tiles(shot, patch, shadow, tile);
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
    light_vertices(shot, occlusion, threads, list);
    ambients.fill(std::span<const std::uint32_t>(list.ambient));
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
