#pragma once
// An offscreen OpenGL 4.0 core context and the entry points drawn with. gl_context.cpp alone knows the
// libraries that make one: OSMesa, and EGL without a surface. Each is looked for when it is wanted, so either
// may be missing.

#define GL_GLEXT_PROTOTYPES
#include <GL/gl.h>
#include <GL/glext.h>

#include <memory>
#include <string>
#include <string_view>

#include "render/gl/gl_library.h"

namespace cloth::render {

// clang-format off
/// The entry points used, by their names without the prefix.
#define CLOTH_GL_FUNCTIONS(X)                                                                               \
    X(ActiveTexture) X(AttachShader) X(BindBuffer) X(BindFramebuffer) X(BindSampler) X(BindTexture)         \
    X(BindVertexArray) X(BufferData) X(CheckFramebufferStatus) X(Clear) X(ClearColor)     \
    X(CompileShader) X(CreateProgram) X(CreateShader) X(DeleteBuffers) X(DeleteFramebuffers)                \
    X(DeleteProgram) X(DeleteSamplers) X(DeleteShader) X(DeleteTextures) X(DeleteVertexArrays)              \
    X(DepthFunc) X(Disable) X(DrawArrays) X(DrawBuffer) X(DrawElements) X(Enable)                           \
    X(EnableVertexAttribArray) X(Flush) X(FramebufferTexture2D) X(GenBuffers) X(GenFramebuffers)            \
    X(GenSamplers) X(GenTextures) X(GenVertexArrays) X(GenerateMipmap) X(GetError) X(GetIntegerv)           \
    X(GetProgramInfoLog) X(GetProgramiv) X(GetShaderInfoLog) X(GetShaderiv) X(GetString)                    \
    X(GetUniformLocation) X(LinkProgram) X(PixelStorei) X(ReadBuffer) X(ReadPixels) X(SamplerParameteri)    \
    X(Scissor) X(ShaderSource) X(TexBuffer) X(TexImage2D) X(TexParameteri) X(Uniform1f) X(Uniform1i)        \
    X(Uniform2f) X(Uniform3f) X(Uniform4f) X(UniformMatrix4fv) X(UseProgram) X(VertexAttribPointer)         \
    X(Viewport)
// clang-format on

struct GlFunctions {
#define CLOTH_GL_DECLARE(name) decltype(&::gl##name) name = nullptr;
    CLOTH_GL_FUNCTIONS(CLOTH_GL_DECLARE)
#undef CLOTH_GL_DECLARE
};

class GlContext {
  public:
    /// `threads`: of the software driver; ≤ 0 for all cores. Only the first context of a process sets it.
    /// Throws std::runtime_error where no suitable context can be made. One process keeps to one library.
    explicit GlContext(int threads, GlLibrary library = GlLibrary::automatic);
    ~GlContext();
    GlContext(const GlContext&) = delete;
    GlContext& operator=(const GlContext&) = delete;

    /// To be called before any entry point of `gl`, on the thread that draws.
    void make_current();

    GlFunctions gl;
    std::string renderer;  ///< name of the driver
    std::string version;   ///< of OpenGL, then of the driver

  private:
    void load_functions();

    class Platform;
    class OsMesa;
    class Egl;
    std::unique_ptr<Platform> platform_;
};

/// Throws std::runtime_error, naming the driver, for one whose pictures would differ too much from the
/// others' (softpipe) or whose OpenGL is older than 4.0.
void require_suitable_driver(std::string_view renderer, std::string_view version, int major, int minor);

}  // namespace cloth::render
