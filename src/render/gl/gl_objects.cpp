#include "render/gl/gl_objects.h"

#include <stdexcept>
#include <vector>

namespace cloth::render {

// ---------------------------------------------------------------- programs
Program::Program(GlFunctions& gl, Pieces vertex, Pieces fragment) : gl_(&gl), name_(gl.CreateProgram()) {
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

Program::~Program() {
    gl_->DeleteProgram(name_);
}

GLuint Program::compile(GLenum stage, Pieces pieces) {
    std::vector<const char*> source{"#version 400 core\n"};
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

GLint Program::place(const char* name) {
    const auto [entry, fresh] = places_.try_emplace(name, -1);
    if (fresh) entry->second = gl_->GetUniformLocation(name_, name);
    return entry->second;
}

// ---------------------------------------------------------------- targets
Target::~Target() {
    GlFunctions& gl = context_->gl;
    gl.DeleteFramebuffers(1, &framebuffer_);
    gl.DeleteTextures(1, &color_texture_);
    gl.DeleteTextures(1, &depth_texture_);
}

void Target::attach(GLuint texture, GLenum internal, GLenum point, int width, int height) {
    GlFunctions& gl = context_->gl;
    gl.BindTexture(GL_TEXTURE_2D, texture);
    GLenum format = GL_RGBA, type = GL_UNSIGNED_BYTE;
    if (point == GL_DEPTH_ATTACHMENT) format = GL_DEPTH_COMPONENT, type = GL_FLOAT;
    if (internal == GL_R32UI) format = GL_RED_INTEGER, type = GL_UNSIGNED_INT;
    gl.TexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal), width, height, 0, format, type, nullptr);
    for (const GLenum filter : {GL_TEXTURE_MIN_FILTER, GL_TEXTURE_MAG_FILTER})
        gl.TexParameteri(GL_TEXTURE_2D, filter, GL_NEAREST);
    for (const GLenum wrap : {GL_TEXTURE_WRAP_S, GL_TEXTURE_WRAP_T})
        gl.TexParameteri(GL_TEXTURE_2D, wrap, GL_CLAMP_TO_EDGE);
    gl.FramebufferTexture2D(GL_FRAMEBUFFER, point, GL_TEXTURE_2D, texture, 0);
}

void Target::bind(int width, int height) {
    GlFunctions& gl = context_->gl;
    if (framebuffer_ == 0) {
        gl.GenFramebuffers(1, &framebuffer_);
        if (color_) gl.GenTextures(1, &color_texture_);
        if (depth_) gl.GenTextures(1, &depth_texture_);
    }
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer_);
    gl.Viewport(0, 0, width, height);
    if (width == width_ && height == height_) return;
    width_ = height_ = 0;
    gl.ActiveTexture(GL_TEXTURE0);
    if (color_) {
        attach(color_texture_, color_, GL_COLOR_ATTACHMENT0, width, height);
    } else {
        gl.DrawBuffer(GL_NONE);
        gl.ReadBuffer(GL_NONE);
    }
    if (depth_) attach(depth_texture_, depth_, GL_DEPTH_ATTACHMENT, width, height);
    if (gl.GetError() != GL_NO_ERROR || gl.CheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        throw std::runtime_error("the OpenGL driver (" + context_->renderer + ") cannot draw to " +
                                 std::to_string(width) + " x " + std::to_string(height) +
                                 " pixels, the size needed inside; ask for a smaller picture");
    width_ = width;
    height_ = height;
}

// ---------------------------------------------------------------- lists
ListBuffer::ListBuffer(GlContext& context, GLenum format) : context_(&context), format_(format) {
    context.gl.GenBuffers(1, &buffer_);
    if (format_) context.gl.GenTextures(1, &texture_);
}

ListBuffer::~ListBuffer() {
    context_->gl.DeleteTextures(1, &texture_);
    context_->gl.DeleteBuffers(1, &buffer_);
}

void ListBuffer::fill(const void* data, std::size_t bytes) {
    GlFunctions& gl = context_->gl;
    gl.BindBuffer(GL_ARRAY_BUFFER, buffer_);
    gl.BufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(bytes), data, GL_STREAM_DRAW);
    if (!format_) return;
    gl.ActiveTexture(GL_TEXTURE0);
    gl.BindTexture(GL_TEXTURE_BUFFER, texture_);
    gl.TexBuffer(GL_TEXTURE_BUFFER, format_, buffer_);
}

void ListBuffer::bind_texture(int unit) const {
    context_->gl.ActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
    context_->gl.BindTexture(GL_TEXTURE_BUFFER, texture_);
}

}  // namespace cloth::render
