#pragma once
// OpenGL objects of the rasterizer: programs, targets, buffers that shaders read.

#include <initializer_list>
#include <span>
#include <string>
#include <unordered_map>

#include "render/gl/gl_context.h"
#include "render/vector_math.h"

namespace cloth::render {

/// A linked program and the places of its uniforms. Throws std::runtime_error with the driver's words.
class Program {
  public:
    using Pieces = std::initializer_list<const char*>;  ///< of GLSL, behind the version line
    Program(GlFunctions& gl, Pieces vertex, Pieces fragment);
    ~Program();
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
    GLuint compile(GLenum stage, Pieces pieces);
    GLint place(const char* name);

    GlFunctions* gl_;
    GLuint name_;
    std::unordered_map<std::string, GLint> places_;
};

/// A colour and a depth texture, or one of them, that can be drawn to.
class Target {
  public:
    /// Formats; 0: none.
    Target(GlContext& context, GLenum color, GLenum depth)
        : context_(&context), color_(color), depth_(depth) {}
    ~Target();
    Target(const Target&) = delete;
    Target& operator=(const Target&) = delete;

    /// Makes it the target of what is drawn next. Throws std::runtime_error where memory is short.
    void bind(int width, int height);
    GLuint color() const { return color_texture_; }
    GLuint depth() const { return depth_texture_; }

  private:
    void attach(GLuint texture, GLenum internal, GLenum point, int width, int height);

    GlContext* context_;
    GLenum color_, depth_;
    GLuint color_texture_ = 0, depth_texture_ = 0, framebuffer_ = 0;
    int width_ = 0, height_ = 0;
};

/// A list that vertex or fragment shaders read.
class ListBuffer {
  public:
    /// `format`: of a texel, as the shader fetches it; 0: the shader does not.
    ListBuffer(GlContext& context, GLenum format);
    ~ListBuffer();
    ListBuffer(const ListBuffer&) = delete;
    ListBuffer& operator=(const ListBuffer&) = delete;

    template <class T>
    void fill(std::span<const T> list) {
        fill(list.data(), list.size_bytes());
    }
    void bind_texture(int unit) const;
    GLuint buffer() const { return buffer_; }

  private:
    void fill(const void* data, std::size_t bytes);

    GlContext* context_;
    GLenum format_;
    GLuint buffer_ = 0, texture_ = 0;
};

}  // namespace cloth::render
