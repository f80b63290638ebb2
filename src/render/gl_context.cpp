#include "render/gl_context.h"

#include <GL/osmesa.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <stdexcept>

namespace cloth::render {
namespace {

constexpr int required_major = 4, required_minor = 0;

// llvmpipe reads its environment once a process, when the first context is made.
void set_driver_threads(int threads) {
    static std::once_flag once;
    std::call_once(once, [threads] {
        if (threads > 0) {
            // 0 workers: the calling thread rasterizes. One worker would run beside the caller, so use two
            // cores.
            const std::string workers = std::to_string(threads == 1 ? 0 : threads);
            setenv("LP_NUM_THREADS", workers.c_str(), /*overwrite=*/1);
        }
    });
}

}  // namespace

void require_suitable_driver(std::string_view renderer, std::string_view version, int major, int minor) {
    const std::string driver = std::string(renderer) + ", OpenGL " + std::string(version);
    if (major < required_major || (major == required_major && minor < required_minor))
        throw std::runtime_error("the OpenGL driver is too old: " + driver + "; OpenGL " +
                                 std::to_string(required_major) + "." + std::to_string(required_minor) +
                                 " core is needed");
    if (renderer.find("softpipe") != std::string_view::npos)
        throw std::runtime_error(
            "the OpenGL driver is unsuitable: " + driver +
            "; its pictures differ visibly from llvmpipe's. Unset GALLIUM_DRIVER, or install "
            "a Mesa built with LLVM (libosmesa6)");
}

struct GlContext::Platform {
    OSMesaContext context = nullptr;
    // OSMesa wants memory for a default framebuffer. Drawing goes to framebuffer objects, so this stays
    // unused.
    static constexpr int size = 16;
    std::array<std::uint8_t, 4 * size * size> pixels{};

    ~Platform() {
        if (context != nullptr) OSMesaDestroyContext(context);
    }
};

GlContext::GlContext(int threads) : platform_(std::make_unique<Platform>()) {
    if (const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
        width != nullptr && std::string(width) == "512")
        throw std::runtime_error(
            "LP_NATIVE_VECTOR_WIDTH is 512, at which llvmpipe crashes; unset it or make it 128 or 256");
    set_driver_threads(threads);
    const std::array<int, 11> attributes{OSMESA_FORMAT,
                                         OSMESA_RGBA,
                                         OSMESA_PROFILE,
                                         OSMESA_CORE_PROFILE,
                                         OSMESA_CONTEXT_MAJOR_VERSION,
                                         required_major,
                                         OSMESA_CONTEXT_MINOR_VERSION,
                                         required_minor,
                                         OSMESA_DEPTH_BITS,
                                         0,
                                         0};
    platform_->context = OSMesaCreateContextAttribs(attributes.data(), nullptr);
    if (platform_->context == nullptr)
        throw std::runtime_error("OSMesa cannot make an OpenGL " + std::to_string(required_major) + "." +
                                 std::to_string(required_minor) +
                                 " core context; Mesa's llvmpipe driver is needed (libosmesa6)");
    make_current();
    // OSMesaGetProcAddress answers unknown names too, so the version is what tells whether all are there.
#define CLOTH_GL_LOAD(name) gl.name = reinterpret_cast<decltype(gl.name)>(OSMesaGetProcAddress("gl" #name));
    CLOTH_GL_FUNCTIONS(CLOTH_GL_LOAD)
#undef CLOTH_GL_LOAD
    const auto text = [this](GLenum name) {
        const GLubyte* string = gl.GetString(name);
        return std::string(string == nullptr ? "unknown" : reinterpret_cast<const char*>(string));
    };
    renderer = text(GL_RENDERER);
    version = text(GL_VERSION);
    int major = 0, minor = 0;
    gl.GetIntegerv(GL_MAJOR_VERSION, &major);
    gl.GetIntegerv(GL_MINOR_VERSION, &minor);
    require_suitable_driver(renderer, version, major, minor);
}

GlContext::~GlContext() = default;

void GlContext::make_current() {
    if (OSMesaGetCurrentContext() == platform_->context) return;
    if (!OSMesaMakeCurrent(platform_->context, platform_->pixels.data(), GL_UNSIGNED_BYTE, Platform::size,
                           Platform::size))
        throw std::runtime_error("OSMesa cannot make its context current on this thread");
}

}  // namespace cloth::render
