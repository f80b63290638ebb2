#include "render/rasterizer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <thread>
#include <unordered_map>

#include "render/ambient_occlusion.h"
#include "render/gl_context.h"
#include "render/shaders.h"

namespace cloth::render {
namespace {

constexpr int smallest_side = 16, largest_side = 8192;
constexpr int supersampling = 2;  // along each axis; the shaders are written for 2
// A shadow's soft edge is this many texels of the map to each side, within these sizes of map: more could not
// be filled by the taps, fewer would show steps.
constexpr float softness_texels = 7;
constexpr int smallest_shadow_map = 256, largest_shadow_map = 2048;
constexpr int surface_taps = 8, ground_taps = 24, settled_ground_taps = 8;
constexpr int ground_occlusion_size = 64;
// Radius over which the floor fades, in distances from eye to target.
constexpr float ground_radius = 1.4f;

// ---------------------------------------------------------------- small vectors
Float3 operator+(const Float3& a, const Float3& b) {
    return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}
Float3 operator-(const Float3& a, const Float3& b) {
    return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}
Float3 operator*(float s, const Float3& a) {
    return {s * a[0], s * a[1], s * a[2]};
}
Float3 operator*(const Float3& a, const Float3& b) {
    return {a[0] * b[0], a[1] * b[1], a[2] * b[2]};
}
float dot(const Float3& a, const Float3& b) {
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}
Float3 cross(const Float3& a, const Float3& b) {
    return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
float length(const Float3& a) {
    return std::sqrt(dot(a, a));
}
Float3 normalized(const Float3& a) {
    return (1 / length(a)) * a;
}
bool finite(const Float3& a) {
    return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}
std::string text(const Float3& a) {
    return std::to_string(a[0]).insert(0, 1, '(') + ", " + std::to_string(a[1]) + ", " +
           std::to_string(a[2]) + ")";
}

using Matrix = std::array<float, 16>;  // by columns, as OpenGL takes it

/// Rows: three axes and their offsets, then w = 1.
Matrix affine(const Float3& x, float ox, const Float3& y, float oy, const Float3& z, float oz) {
    return {x[0], y[0], z[0], 0, x[1], y[1], z[1], 0, x[2], y[2], z[2], 0, ox, oy, oz, 1};
}

constexpr float infinity = std::numeric_limits<float>::infinity();
constexpr Bounds nothing{{infinity, infinity, infinity}, {-infinity, -infinity, -infinity}};

Bounds merged(const Bounds& a, const Bounds& b) {
    Bounds r;
    for (int i = 0; i < 3; ++i) {
        r.low[i] = std::min(a.low[i], b.low[i]);
        r.high[i] = std::max(a.high[i], b.high[i]);
    }
    return r;
}
/// Outwards to multiples of a sixteenth of the longest side, itself rounded up to a power of two. The grids
/// laid over the bounds then stay in place from frame to frame, and so do the last bits of soft edges.
Bounds widened(Bounds b) {
    float longest = 1e-3f;
    for (int i = 0; i < 3; ++i) longest = std::max(longest, b.high[i] - b.low[i]);
    const float step = std::exp2(std::ceil(std::log2(longest))) / 16;
    for (int i = 0; i < 3; ++i) {
        b.low[i] = step * std::floor(b.low[i] / step);
        b.high[i] = step * std::ceil(b.high[i] / step);
    }
    return b;
}
std::array<Float3, 8> corners(const Bounds& b) {
    std::array<Float3, 8> c{};
    for (int i = 0; i < 8; ++i)
        c[i] = {i & 1 ? b.high[0] : b.low[0], i & 2 ? b.high[1] : b.low[1], i & 4 ? b.high[2] : b.low[2]};
    return c;
}

// As in the shader.
Float3 tone_curve(const Float3& radiance) {
    constexpr float knee = 0.6f;
    Float3 c = radiance;
    for (float& x : c)
        if (x > knee) x = knee + (1 - knee) * (1 - std::exp(-(x - knee) / (1 - knee)));
    return c;
}

// ---------------------------------------------------------------- checks
[[noreturn]] void refuse(const std::string& message) {
    throw std::invalid_argument(message);
}

void require_view(const View& view) {
    for (const int side : {view.width, view.height})
        if (side < smallest_side || side > largest_side)
            refuse("view: a size of " + std::to_string(view.width) + " x " + std::to_string(view.height) +
                   " pixels; each side must be " + std::to_string(smallest_side) + " to " +
                   std::to_string(largest_side));
    for (const auto& [name, value] : {std::pair{"eye", view.eye},
                                      {"target", view.target},
                                      {"up", view.up},
                                      {"light.direction", view.light.direction}})
        if (!finite(value)) refuse("view: " + std::string(name) + " " + text(value) + " is not finite");
    const Float3 forward = view.target - view.eye;
    if (!(length(forward) > 1e-6f))
        refuse("view: eye and target are both at " + text(view.eye) +
               "; they must be apart to look anywhere");
    if (!(length(cross(normalized(forward), view.up)) > 1e-4f * length(view.up)) || !(length(view.up) > 0))
        refuse("view: up " + text(view.up) + " is parallel to the line of sight " + text(forward));
    if (!(view.field_of_view >= 1 && view.field_of_view <= 160))
        refuse("view: a field of view of " + std::to_string(view.field_of_view) +
               " degrees; it must be 1 to 160");
    if (!(length(view.light.direction) > 0)) refuse("view: the light's direction is zero");
    if (!(view.light.softness >= 0) || !std::isfinite(view.light.softness))
        refuse("view: a shadow softness of " + std::to_string(view.light.softness) +
               " m; it must be 0 or more");
    if (!(view.exposure >= 0) || !std::isfinite(view.exposure))
        refuse("view: an exposure of " + std::to_string(view.exposure) + "; it must be 0 or more");
}

/// Checks a surface and returns its bounds.
Bounds checked_bounds(const Surface& surface, std::size_t number) {
    const std::string name = "surface " + std::to_string(number) + ": ";
    if (surface.positions.size() % 3 != 0 || surface.normals.size() != surface.positions.size())
        refuse(name + std::to_string(surface.positions.size()) + " position and " +
               std::to_string(surface.normals.size()) + " normal components; both must be 3 per vertex");
    if (surface.triangles.size() % 3 != 0)
        refuse(name + std::to_string(surface.triangles.size()) +
               " triangle indices; there must be 3 per triangle");
    const std::size_t vertices = surface.positions.size() / 3;
    for (std::size_t i = 0; i < surface.triangles.size(); ++i)
        if (surface.triangles[i] >= vertices)
            refuse(name + "triangle " + std::to_string(i / 3) + " names vertex " +
                   std::to_string(surface.triangles[i]) + " of " + std::to_string(vertices));
    Bounds b = nothing;
    for (std::size_t v = 0; v < vertices; ++v) {
        const Float3 p{surface.positions[3 * v], surface.positions[3 * v + 1], surface.positions[3 * v + 2]};
        if (!finite(p)) refuse(name + "the position of vertex " + std::to_string(v) + " is not finite");
        b = merged(b, {p, p});
    }
    return b;
}

/// Whether counter-clockwise triangles show the side that the normals point to.
bool winding_follows_normals(const Surface& s) {
    double sum = 0;
    const auto vector = [](std::span<const float> a, std::uint32_t i) {
        return Float3{a[3 * std::size_t{i}], a[3 * std::size_t{i} + 1], a[3 * std::size_t{i} + 2]};
    };
    for (std::size_t t = 0; t + 2 < s.triangles.size(); t += 3) {
        const Float3 a = vector(s.positions, s.triangles[t]);
        const Float3 area =
            cross(vector(s.positions, s.triangles[t + 1]) - a, vector(s.positions, s.triangles[t + 2]) - a);
        sum += dot(area, vector(s.normals, s.triangles[t]));
    }
    return sum >= 0;
}

// ---------------------------------------------------------------- geometry of a draw
struct Camera {
    Float3 right, up, forward;
    float half_width, half_height;  // of the picture, at distance 1
    Matrix world_to_clip;
};

Camera make_camera(const View& view) {
    Camera c;
    const Float3 sight = view.target - view.eye;
    c.forward = normalized(sight);
    c.right = normalized(cross(c.forward, view.up));
    c.up = cross(c.right, c.forward);
    c.half_height = std::tan(0.5f * view.field_of_view * std::numbers::pi_v<float> / 180);
    c.half_width = c.half_height * static_cast<float>(view.width) / static_cast<float>(view.height);
    // The far plane is at infinity: clip depth is distance - 2 near, over distance.
    const float near = 0.01f * length(sight);
    const Float3 x = (1 / c.half_width) * c.right, y = (1 / c.half_height) * c.up;
    c.world_to_clip =
        affine(x, -dot(x, view.eye), y, -dot(y, view.eye), c.forward, -dot(c.forward, view.eye) - 2 * near);
    for (int i = 0; i < 3; ++i) c.world_to_clip[4 * i + 3] = c.forward[i];
    c.world_to_clip[15] = -dot(c.forward, view.eye);
    return c;
}

/// An orthographic view from the light that holds `bounds`.
struct ShadowView {
    Matrix world_to_clip, world_to_texture;
    int size = 0;                  // of the map [texel]
    float texel = 0;               // [m]
    float radius = 0;              // of the filter's disc [m]
    std::array<float, 4> place{};  // of the bounds in the texture: low x, low y, high x, high y
};

ShadowView make_shadow_view(const Float3& to_light, const Bounds& bounds, float softness) {
    // Of the turns about the light's direction, take the one with a horizontal side: boxes fit well.
    const Float3 z = -1.0f * to_light;
    const Float3 x = normalized(std::abs(z[1]) < 0.999f ? cross({0, 1, 0}, z) : cross({0, 0, 1}, z));
    const Float3 y = cross(z, x);
    Bounds b = nothing;
    for (const Float3& corner : corners(bounds)) {
        const Float3 p{dot(x, corner), dot(y, corner), dot(z, corner)};
        b = merged(b, {p, p});
    }
    const float widest = std::max({b.high[0] - b.low[0], b.high[1] - b.low[1], 1e-5f});
    const float deep = std::max(b.high[2] - b.low[2], 1e-5f);
    // The border holds the filter's disc.
    const float half = 0.5f * widest * (1 + 8.0f / smallest_shadow_map) + 1.5f * softness;
    const Float3 center = 0.5f * (b.low + b.high);
    ShadowView s;
    const float wanted = 2 * half * softness_texels / std::max(softness, 1e-6f);
    s.size = std::clamp(64 * static_cast<int>(std::min(wanted / 64, 1e6f)), smallest_shadow_map,
                        largest_shadow_map);
    s.texel = 2 * half / static_cast<float>(s.size);
    s.radius = std::max(softness, s.texel);
    const float depth_scale = 0.98f / deep, depth_offset = 0.01f - depth_scale * b.low[2];
    s.world_to_clip = affine((1 / half) * x, -center[0] / half, (1 / half) * y, -center[1] / half,
                             (2 * depth_scale) * z, 2 * depth_offset - 1);
    s.world_to_texture = affine((0.5f / half) * x, 0.5f - 0.5f * center[0] / half, (0.5f / half) * y,
                                0.5f - 0.5f * center[1] / half, depth_scale * z, depth_offset);
    for (int i = 0; i < 2; ++i) {
        const float reach = 0.5f * (b.high[i] - b.low[i]) + 1.5f * softness + 2 * s.texel;
        s.place[i] = 0.5f - 0.5f * reach / half;
        s.place[i + 2] = 0.5f + 0.5f * reach / half;
    }
    return s;
}

/// Counter-clockwise convex hull of points (x, z); Andrew's monotone chain.
std::vector<std::array<float, 2>> convex_hull(std::vector<std::array<float, 2>> points) {
    std::sort(points.begin(), points.end());
    std::vector<std::array<float, 2>> hull;
    for (int pass = 0; pass < 2; ++pass) {
        const std::size_t start = hull.size();
        for (const auto& p : points) {
            while (hull.size() >= start + 2) {
                const auto &a = hull[hull.size() - 2], &b = hull.back();
                if ((b[0] - a[0]) * (p[1] - a[1]) - (b[1] - a[1]) * (p[0] - a[0]) > 0) break;
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

// ---------------------------------------------------------------- OpenGL objects

/// A linked program and the places of its uniforms.
class Program {
  public:
    Program(GlFunctions& gl, std::initializer_list<const char*> vertex,
            std::initializer_list<const char*> fragment)
        : gl_(&gl), name_(gl.CreateProgram()) {
        const GLuint shaders[] = {compile(GL_VERTEX_SHADER, vertex), compile(GL_FRAGMENT_SHADER, fragment)};
        for (const GLuint shader : shaders) gl.AttachShader(name_, shader);
        gl.LinkProgram(name_);
        for (const GLuint shader : shaders) gl.DeleteShader(shader);
        GLint linked = 0;
        gl.GetProgramiv(name_, GL_LINK_STATUS, &linked);
        if (!linked) {
            std::array<char, 2048> log{};
            gl.GetProgramInfoLog(name_, log.size(), nullptr, log.data());
            throw std::runtime_error(std::string("the OpenGL driver refused a program: ") + log.data());
        }
    }
    ~Program() { gl_->DeleteProgram(name_); }
    Program(const Program&) = delete;
    Program& operator=(const Program&) = delete;

    void use() { gl_->UseProgram(name_); }
    void set(const char* name, float x) { gl_->Uniform1f(place(name), x); }
    void set(const char* name, int x) { gl_->Uniform1i(place(name), x); }
    void set(const char* name, bool x) { gl_->Uniform1i(place(name), x); }
    void set(const char* name, float x, float y) { gl_->Uniform2f(place(name), x, y); }
    void set(const char* name, const Float3& v) { gl_->Uniform3f(place(name), v[0], v[1], v[2]); }
    void set(const char* name, const std::array<float, 4>& v) {
        gl_->Uniform4f(place(name), v[0], v[1], v[2], v[3]);
    }
    void set(const char* name, const Matrix& m) { gl_->UniformMatrix4fv(place(name), 1, GL_FALSE, m.data()); }

  private:
    GLuint compile(GLenum stage, std::initializer_list<const char*> pieces) {
        std::vector<const char*> source{shaders::version};
        source.insert(source.end(), pieces);
        const GLuint shader = gl_->CreateShader(stage);
        gl_->ShaderSource(shader, static_cast<GLsizei>(source.size()), source.data(), nullptr);
        gl_->CompileShader(shader);
        GLint compiled = 0;
        gl_->GetShaderiv(shader, GL_COMPILE_STATUS, &compiled);
        if (!compiled) {
            std::array<char, 2048> log{};
            gl_->GetShaderInfoLog(shader, log.size(), nullptr, log.data());
            throw std::runtime_error(std::string("the OpenGL driver refused a shader: ") + log.data());
        }
        return shader;
    }
    GLint place(const char* name) {
        const auto [entry, fresh] = places_.try_emplace(name, -1);
        if (fresh) entry->second = gl_->GetUniformLocation(name_, name);
        return entry->second;
    }

    GlFunctions* gl_;
    GLuint name_;
    std::unordered_map<std::string, GLint> places_;
};

/// A texture that can be drawn to.
struct Target {
    GLuint texture = 0, depth = 0, framebuffer = 0;
    int width = 0, height = 0;
};

/// Vertex data of one surface. Kept from draw to draw: reallocating costs more than refilling.
struct Buffers {
    GLuint array = 0, positions = 0, normals = 0, ambient = 0, triangles = 0;
    GLsizei indices = 0;
    bool winding = true;
};

/// What all passes of one draw share.
struct Shot {
    const Frame& frame;
    const View& view;
    Camera camera;
    Bounds bounds;      // of what casts shadows and occludes
    Float3 to_light{};  // unit length
    Float3 key{};       // radiance of a white plane that faces the light
    Float3 bounce{};    // light from below
    ShadowView shadow_view{};
    bool shadow = false, occlusion = false, ground = false;
};

}  // namespace

struct Rasterizer::Impl {
    explicit Impl(int thread_count)
        : context(thread_count),
          gl(context.gl),
          threads(thread_count > 0 ? static_cast<std::size_t>(thread_count)
                                   : std::max<std::size_t>(1, std::thread::hardware_concurrency())) {}
    ~Impl();

    GlContext context;
    GlFunctions& gl;
    std::size_t threads;
    Program depth_program{gl, {shaders::depth_vertex}, {shaders::depth_fragment}};
    Program surface_program{
        gl, {shaders::surface_vertex}, {shaders::tone_curve, shaders::shadow, shaders::surface_fragment}};
    Program far_program{gl, {shaders::screen_vertex}, {shaders::tone_curve, shaders::resolve_fragment}};
    Program near_program{
        gl,
        {shaders::depth_vertex},
        {"#define NEAR_OBJECTS\n", shaders::tone_curve, shaders::shadow, shaders::resolve_fragment}};
    Target shadow_map, samples, picture;
    GLuint ground_occlusion = 0;
    Buffers floor;
    std::vector<Buffers> meshes;  // those of the last draw, and more where an earlier one had more
    AmbientOcclusion occlusion;
    std::vector<float> ambient;
    std::vector<std::uint8_t> pixels;

    Image draw(const Frame& frame, const View& view);

    void make_buffers(Buffers& buffers);
    void fill(GLuint buffer, GLenum kind, const void* data, std::size_t bytes);
    void upload(Buffers& buffers, const Surface& surface);
    void upload_ambient(Buffers& buffers, const Surface& surface, bool occluded);
    void set_sampling(GLint filter);
    void resize(Target& target, int width, int height, GLint color, GLint depth);
    void draw_mesh(const Buffers& buffers);

    void draw_shadow_map(const Shot& shot);
    void draw_surfaces(const Shot& shot);
    void resolve(const Shot& shot);
    void set_resolve_uniforms(Program& program, const Shot& shot);
    void draw_ground_near_objects(const Shot& shot);
};

// ---------------------------------------------------------------- buffers and textures
Rasterizer::Impl::~Impl() {
    context.make_current();
    for (Target* t : {&shadow_map, &samples, &picture}) {
        gl.DeleteFramebuffers(1, &t->framebuffer);
        gl.DeleteTextures(1, &t->texture);
        gl.DeleteTextures(1, &t->depth);
    }
    gl.DeleteTextures(1, &ground_occlusion);
    meshes.push_back(floor);
    for (const Buffers& b : meshes) {
        for (const GLuint buffer : {b.positions, b.normals, b.ambient, b.triangles})
            gl.DeleteBuffers(1, &buffer);
        gl.DeleteVertexArrays(1, &b.array);
    }
}

void Rasterizer::Impl::make_buffers(Buffers& b) {
    gl.GenVertexArrays(1, &b.array);
    gl.BindVertexArray(b.array);
    GLuint location = 0;
    for (GLuint* buffer : {&b.positions, &b.normals, &b.ambient}) {
        gl.GenBuffers(1, buffer);
        gl.BindBuffer(GL_ARRAY_BUFFER, *buffer);
        gl.EnableVertexAttribArray(location);
        gl.VertexAttribPointer(location, location < 2 ? 3 : 4, GL_FLOAT, GL_FALSE, 0, nullptr);
        ++location;
    }
    gl.GenBuffers(1, &b.triangles);
    gl.BindBuffer(GL_ELEMENT_ARRAY_BUFFER, b.triangles);
}

void Rasterizer::Impl::fill(GLuint buffer, GLenum kind, const void* data, std::size_t bytes) {
    gl.BindBuffer(kind, buffer);
    gl.BufferData(kind, static_cast<GLsizeiptr>(bytes), data, GL_STREAM_DRAW);
}

void Rasterizer::Impl::upload(Buffers& b, const Surface& surface) {
    gl.BindVertexArray(b.array);
    fill(b.positions, GL_ARRAY_BUFFER, surface.positions.data(), surface.positions.size_bytes());
    fill(b.normals, GL_ARRAY_BUFFER, surface.normals.data(), surface.normals.size_bytes());
    fill(b.triangles, GL_ELEMENT_ARRAY_BUFFER, surface.triangles.data(), surface.triangles.size_bytes());
    b.indices = static_cast<GLsizei>(surface.triangles.size());
    b.winding = winding_follows_normals(surface);
}

void Rasterizer::Impl::upload_ambient(Buffers& b, const Surface& surface, bool occluded) {
    const std::size_t vertices = surface.positions.size() / 3;
    ambient.resize(4 * vertices);
    const auto compute = [&](std::size_t first, std::size_t last) {
        for (std::size_t v = first; v < last; ++v) {
            const Float3 p{surface.positions[3 * v], surface.positions[3 * v + 1],
                           surface.positions[3 * v + 2]};
            const Float3 n{surface.normals[3 * v], surface.normals[3 * v + 1], surface.normals[3 * v + 2]};
            AmbientLight front{0.5f * (1 + n[1]), 0.5f * (1 - n[1])};
            AmbientLight back{front.from_below, front.from_above};
            if (occluded) {
                front = occlusion.at(p, n);
                if (surface.two_sided) back = occlusion.at(p, -1.0f * n);
            }
            float* a = ambient.data() + 4 * v;
            a[0] = front.from_above;
            a[1] = front.from_below;
            a[2] = back.from_above;
            a[3] = back.from_below;
        }
    };
    // Each vertex stands alone, so how they are shared out changes nothing.
    constexpr std::size_t vertices_per_thread = 1000;
    const std::size_t parts = std::clamp<std::size_t>(vertices / vertices_per_thread, 1, threads);
    std::vector<std::jthread> helpers;
    for (std::size_t i = 1; i < parts; ++i)
        helpers.emplace_back(compute, vertices * i / parts, vertices * (i + 1) / parts);
    compute(0, vertices / parts);
    helpers.clear();
    gl.BindVertexArray(b.array);
    fill(b.ambient, GL_ARRAY_BUFFER, ambient.data(), ambient.size() * sizeof(float));
}

void Rasterizer::Impl::set_sampling(GLint filter) {
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, filter);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, filter);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

void Rasterizer::Impl::resize(Target& target, int width, int height, GLint color, GLint depth) {
    if (target.width == width && target.height == height) return;
    if (target.framebuffer == 0) {
        gl.GenFramebuffers(1, &target.framebuffer);
        if (color) gl.GenTextures(1, &target.texture);
        if (depth) gl.GenTextures(1, &target.depth);
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, target.framebuffer);
    if (color) {
        gl.BindTexture(GL_TEXTURE_2D, target.texture);
        gl.TexImage2D(GL_TEXTURE_2D, 0, color, width, height, 0, GL_RGBA, GL_UNSIGNED_BYTE, nullptr);
        set_sampling(GL_NEAREST);
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.texture, 0);
    } else {
        gl.DrawBuffer(GL_NONE);
        gl.ReadBuffer(GL_NONE);
    }
    if (depth) {
        gl.BindTexture(GL_TEXTURE_2D, target.depth);
        gl.TexImage2D(GL_TEXTURE_2D, 0, depth, width, height, 0, GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
        set_sampling(color ? GL_NEAREST : GL_LINEAR);
        if (!color) {
            gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
            gl.TexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_FUNC, GL_LEQUAL);
        }
        gl.FramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, target.depth, 0);
    }
    target.width = target.height = 0;
    if (gl.GetError() != GL_NO_ERROR || gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw std::runtime_error("the OpenGL driver (" + context.renderer + ") cannot draw to " +
                                 std::to_string(width) + " x " + std::to_string(height) +
                                 " pixels, the size needed inside; ask for a smaller picture");
    target.width = width;
    target.height = height;
}

void Rasterizer::Impl::draw_mesh(const Buffers& b) {
    gl.BindVertexArray(b.array);
    gl.DrawElements(GL_TRIANGLES, b.indices, GL_UNSIGNED_INT, nullptr);
}

// ---------------------------------------------------------------- passes
void Rasterizer::Impl::draw_shadow_map(const Shot& shot) {
    const int size = shot.shadow ? shot.shadow_view.size : smallest_shadow_map;
    resize(shadow_map, size, size, 0, GL_DEPTH_COMPONENT32F);
    gl.BindFramebuffer(GL_FRAMEBUFFER, shadow_map.framebuffer);
    gl.Viewport(0, 0, size, size);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    if (!shot.shadow) return;
    // The outermost texels stay empty: they are what lies beyond the map.
    gl.Enable(GL_SCISSOR_TEST);
    gl.Scissor(1, 1, size - 2, size - 2);
    depth_program.use();
    depth_program.set("world_to_clip", shot.shadow_view.world_to_clip);
    for (std::size_t i = 0; i < shot.frame.surfaces.size(); ++i)
        if (shot.frame.surfaces[i].casts_shadow) draw_mesh(meshes[i]);
    gl.Disable(GL_SCISSOR_TEST);
    gl.Flush();  // the driver's threads rasterize while this one computes occlusion
}

void Rasterizer::Impl::draw_surfaces(const Shot& shot) {
    const View& view = shot.view;
    const int width = supersampling * view.width, height = supersampling * view.height;
    resize(samples, width, height, GL_RGB10_A2, GL_DEPTH_COMPONENT32F);
    gl.BindFramebuffer(GL_FRAMEBUFFER, samples.framebuffer);
    gl.Viewport(0, 0, width, height);
    gl.Enable(GL_DEPTH_TEST);
    gl.Clear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    gl.Enable(GL_CLIP_DISTANCE0);

    Program& p = surface_program;
    p.use();
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, shadow_map.depth);
    p.set("shadow_map", 0);
    p.set("world_to_clip", shot.camera.world_to_clip);
    // llvmpipe clips by the distance even while it is disabled, so without a floor it lies out of reach.
    p.set("clip_height", shot.ground ? shot.frame.ground->height : -1e30f);
    p.set("eye", view.eye);
    p.set("light_direction", shot.to_light);
    p.set("light_radiance", shot.key);
    p.set("sky", view.sky);
    p.set("bounce", shot.bounce);
    p.set("exposure", view.exposure);
    p.set("shadow_taps", shot.shadow ? surface_taps : 0);
    p.set("world_to_shadow", shot.shadow_view.world_to_texture);
    p.set("shadow_radius",
          shot.shadow_view.radius / (shot.shadow_view.texel * static_cast<float>(shot.shadow_view.size)));
    // Half a texel's diagonal, for the bilinear comparison, beyond the disc
    p.set("normal_offset", shot.shadow_view.radius + 1.5f * shot.shadow_view.texel);
    for (std::size_t i = 0; i < shot.frame.surfaces.size(); ++i) {
        const Surface& surface = shot.frame.surfaces[i];
        const Material& m = surface.material;
        const float roughness = std::clamp(m.roughness, 0.05f, 1.0f);
        p.set("front_color", m.front);
        p.set("back_color", m.back);
        p.set("lobe", Float3{roughness * roughness * roughness * roughness, 0.5f * roughness * roughness,
                             m.specular});
        p.set("sheen", m.sheen);
        p.set("two_sided", surface.two_sided);
        p.set("winding", meshes[i].winding ? 1.0f : -1.0f);
        draw_mesh(meshes[i]);
    }
    gl.Disable(GL_CLIP_DISTANCE0);
}

void Rasterizer::Impl::set_resolve_uniforms(Program& p, const Shot& shot) {
    const View& view = shot.view;
    const Camera& c = shot.camera;
    p.use();
    p.set("samples", 0);
    p.set("background", view.background);
    p.set("has_ground", shot.ground);
    if (!shot.ground) return;
    const Ground& ground = *shot.frame.ground;
    p.set("eye", view.eye);
    const Float3 ray_x = (2 * c.half_width / static_cast<float>(view.width)) * c.right;
    const Float3 ray_y = (2 * c.half_height / static_cast<float>(view.height)) * c.up;
    p.set("ray_corner", c.forward - c.half_width * c.right - c.half_height * c.up);
    p.set("ray_x", ray_x);
    p.set("ray_y", ray_y);
    p.set("ground_height", ground.height);
    p.set("ground_center", view.target[0], view.target[2]);
    const float radius = ground_radius * length(view.target - view.eye);
    p.set("ground_fade", 1 / (radius * radius));
    const Float3 color = view.exposure * ground.color;
    const Float3 lit = std::max(shot.to_light[1], 0.0f) * (color * shot.key), ambient_part = color * view.sky;
    p.set("ground_lit", lit);
    p.set("ground_ambient", ambient_part);
    p.set("ground_open", tone_curve(lit + ambient_part));
}

void Rasterizer::Impl::resolve(const Shot& shot) {
    const int width = shot.view.width, height = shot.view.height;
    resize(picture, width, height, GL_RGBA8, GL_DEPTH_COMPONENT16);
    gl.BindFramebuffer(GL_FRAMEBUFFER, picture.framebuffer);
    gl.Viewport(0, 0, width, height);
    gl.Clear(GL_DEPTH_BUFFER_BIT);
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_2D, samples.texture);
    // The costlier floor first; depth keeps the rest of the picture from being drawn over it.
    if (shot.ground && (shot.shadow || shot.occlusion)) draw_ground_near_objects(shot);
    set_resolve_uniforms(far_program, shot);
    gl.BindVertexArray(floor.array);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
}

void Rasterizer::Impl::draw_ground_near_objects(const Shot& shot) {
    const Bounds& b = shot.bounds;
    const float height = shot.frame.ground->height;
    // Occlusion ends about as far out as the objects reach up.
    const float margin = std::max({b.high[1] - height, b.high[1] - b.low[1],
                                   0.25f * std::max(b.high[0] - b.low[0], b.high[2] - b.low[2])});
    const Float3 low{b.low[0] - margin, height, b.low[2] - margin};
    const Float3 high{b.high[0] + margin, height, b.high[2] + margin};
    constexpr int size = ground_occlusion_size;
    std::vector<float> open(std::size_t{size} * size, 1.0f);
    if (shot.occlusion)
        for (int j = 1; j < size - 1; ++j)  // the outermost texels hold 1, which clamping spreads outwards
            for (int i = 1; i < size - 1; ++i) {
                const float u = (static_cast<float>(i) + 0.5f) / size,
                            v = (static_cast<float>(j) + 0.5f) / size;
                const Float3 point{low[0] + u * (high[0] - low[0]), height, low[2] + v * (high[2] - low[2])};
                const float visible = occlusion.at(point, {0, 1, 0}, /*on_surface=*/false).from_above;
                const float edge = std::min({u, v, 1 - u, 1 - v}) - 1.0f / size;
                const float fade = std::clamp(8 * edge, 0.0f, 1.0f);
                // What hides the sky returns a part of the floor's own light.
                open[std::size_t{size} * j + i] = 1 - 0.7f * (1 - visible) * fade * fade * (3 - 2 * fade);
            }
    gl.ActiveTexture(GL_TEXTURE1);
    gl.BindTexture(GL_TEXTURE_2D, ground_occlusion);
    gl.TexImage2D(GL_TEXTURE_2D, 0, GL_R32F, size, size, 0, GL_RED, GL_FLOAT, open.data());
    gl.ActiveTexture(GL_TEXTURE2);
    gl.BindTexture(GL_TEXTURE_2D, shadow_map.depth);

    // The part of the floor that objects can darken: their surroundings, and their bounds cast along the
    // light.
    std::vector<std::array<float, 2>> reach{
        {low[0], low[2]}, {low[0], high[2]}, {high[0], low[2]}, {high[0], high[2]}};
    const bool shadow = shot.shadow && shot.to_light[1] > 1e-3f;
    if (shadow) {
        const float pad = 2 * shot.shadow_view.radius;
        for (const Float3& corner : corners(b)) {
            const float rise = std::max(corner[1] - height, 0.0f) / shot.to_light[1];
            const float x = corner[0] - rise * shot.to_light[0], z = corner[2] - rise * shot.to_light[2];
            const float around = pad / shot.to_light[1];
            for (const float dx : {-around, around})
                for (const float dz : {-around, around}) reach.push_back({x + dx, z + dz});
        }
    }
    std::vector<float> polygon;
    const auto hull = convex_hull(std::move(reach));
    for (const auto& [x, z] : hull) polygon.insert(polygon.end(), {x, height, z});
    gl.BindVertexArray(floor.array);
    fill(floor.positions, GL_ARRAY_BUFFER, polygon.data(), polygon.size() * sizeof(float));

    Program& p = near_program;
    set_resolve_uniforms(p, shot);
    p.set("world_to_clip", shot.camera.world_to_clip);
    p.set("ground_occlusion", 1);
    const float scale_x = 1 / (high[0] - low[0]), scale_z = 1 / (high[2] - low[2]);
    p.set("ground_occlusion_place",
          std::array<float, 4>{scale_x, scale_z, -low[0] * scale_x, -low[2] * scale_z});
    p.set("shadow_map", 2);
    p.set("world_to_shadow", shot.shadow_view.world_to_texture);
    p.set("shadow_radius",
          shot.shadow_view.radius / (shot.shadow_view.texel * static_cast<float>(shot.shadow_view.size)));
    p.set("shadow_place", shot.shadow_view.place);
    p.set("shadow_taps", shadow ? ground_taps : 0);
    p.set("settled_taps", settled_ground_taps);
    gl.DrawArrays(GL_TRIANGLE_FAN, 0, static_cast<GLsizei>(hull.size()));
}

Image Rasterizer::Impl::draw(const Frame& frame, const View& view) {
    require_view(view);
    Bounds bounds = nothing;
    for (std::size_t i = 0; i < frame.surfaces.size(); ++i) {
        const Bounds surface_bounds = checked_bounds(frame.surfaces[i], i);
        if (frame.surfaces[i].casts_shadow) bounds = merged(bounds, surface_bounds);
    }
    const bool occupied = bounds.low[0] <= bounds.high[0];
    if (view.shadow_bounds) {
        const auto& [a, b] = *view.shadow_bounds;
        if (!finite(a) || !finite(b))
            refuse("view: shadow bounds " + text(a) + ", " + text(b) + " are not finite");
        bounds = merged({a, a}, {b, b});
    } else if (occupied) {
        bounds = widened(bounds);
    }
    if (frame.ground && !std::isfinite(frame.ground->height)) refuse("the ground's height is not finite");

    Shot shot{.frame = frame, .view = view, .camera = make_camera(view), .bounds = bounds};
    shot.to_light = normalized(view.light.direction);
    shot.key = (view.light.intensity / std::numbers::pi_v<float>)*view.light.color;
    // A floor returns what it gets, about half of it shaded by what stands there; without one, the
    // background's glow stands in.
    shot.bounce = frame.ground ? frame.ground->color *
                                     (0.5f * view.sky + (0.5f * std::max(shot.to_light[1], 0.0f)) * shot.key)
                               : 0.5f * view.background;
    shot.ground = frame.ground && view.eye[1] > frame.ground->height;
    shot.shadow = view.light.shadow && occupied;
    shot.occlusion = view.ambient_occlusion && occupied;
    if (shot.shadow) shot.shadow_view = make_shadow_view(shot.to_light, bounds, view.light.softness);

    context.make_current();
    if (floor.array == 0) {
        make_buffers(floor);
        gl.GenTextures(1, &ground_occlusion);
        gl.BindTexture(GL_TEXTURE_2D, ground_occlusion);
        set_sampling(GL_LINEAR);
        gl.ClearColor(0, 0, 0, 0);
        gl.DepthFunc(GL_LEQUAL);
        gl.PixelStorei(GL_PACK_ALIGNMENT, 1);
    }
    while (meshes.size() < frame.surfaces.size()) make_buffers(meshes.emplace_back());
    for (std::size_t i = 0; i < frame.surfaces.size(); ++i) upload(meshes[i], frame.surfaces[i]);
    draw_shadow_map(shot);
    if (shot.occlusion) occlusion.build(frame.surfaces, bounds);
    for (std::size_t i = 0; i < frame.surfaces.size(); ++i)
        upload_ambient(meshes[i], frame.surfaces[i], shot.occlusion);
    draw_surfaces(shot);
    resolve(shot);

    Image image{view.width, view.height, {}};
    pixels.resize(std::size_t{4} * view.width * view.height);
    gl.ReadPixels(0, 0, view.width, view.height, GL_RGBA, GL_UNSIGNED_BYTE, pixels.data());
    if (const GLenum error = gl.GetError(); error != GL_NO_ERROR)
        throw std::runtime_error("the OpenGL driver (" + context.renderer + ") failed to draw, error " +
                                 std::to_string(error));
    image.rgba.resize(pixels.size());
    const std::size_t row = std::size_t{4} * view.width;
    for (std::size_t y = 0; y < static_cast<std::size_t>(view.height);
         ++y)  // OpenGL's rows start at the bottom
        std::copy_n(pixels.data() + row * y, row, image.rgba.data() + row * (view.height - 1 - y));
    return image;
}

// ---------------------------------------------------------------- the public face
Rasterizer::Rasterizer(int threads) : impl_(std::make_unique<Impl>(threads)) {}
Rasterizer::~Rasterizer() = default;
Rasterizer::Rasterizer(Rasterizer&&) noexcept = default;
Image Rasterizer::draw(const Frame& frame, const View& view) {
    return impl_->draw(frame, view);
}
std::string Rasterizer::description() const {
    return impl_->context.renderer + ", OpenGL " + impl_->context.version;
}

}  // namespace cloth::render
