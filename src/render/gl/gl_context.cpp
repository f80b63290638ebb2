#include "render/gl/gl_context.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>
#include <dlfcn.h>

#include <array>
#include <cstdint>
#include <cstdlib>
#include <mutex>
#include <stdexcept>

namespace cloth::render {
namespace {

constexpr int required_major = 4, required_minor = 0;
const std::string core =
    "OpenGL " + std::to_string(required_major) + "." + std::to_string(required_minor) + " core";

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

/// A shared library, loaded under the first of some names that is there, and never unloaded: drivers leave
/// threads.
class Library {
  public:
    Library(const char* what, std::initializer_list<const char*> names) : what_(what) {
        for (const char* name : names)
            if (handle_ == nullptr) handle_ = dlopen(name, RTLD_NOW | RTLD_LOCAL);
        if (handle_ == nullptr)
            throw std::runtime_error(std::string(what) + " is not installed: " + dlerror());
    }
    template <class Function>
    void find(Function& function, const char* name) const {
        function = reinterpret_cast<Function>(dlsym(handle_, name));
        if (function == nullptr) throw std::runtime_error(std::string(what_) + " lacks " + name);
    }

  private:
    const char* what_;
    void* handle_ = nullptr;
};

using AnyFunction = void (*)();

}  // namespace

void require_suitable_driver(std::string_view renderer, std::string_view version, int major, int minor) {
    const std::string driver = std::string(renderer) + ", OpenGL " + std::string(version);
    if (major < required_major || (major == required_major && minor < required_minor))
        throw std::runtime_error("the OpenGL driver is too old: " + driver + "; " + core + " is needed");
    if (renderer.find("softpipe") != std::string_view::npos)
        throw std::runtime_error(
            "the OpenGL driver is unsuitable: " + driver +
            "; its pictures differ visibly from llvmpipe's. Unset GALLIUM_DRIVER, or install "
            "a Mesa built with LLVM (libosmesa6)");
}

class GlContext::Platform {
  public:
    Platform() = default;
    virtual ~Platform() = default;
    Platform(const Platform&) = delete;
    Platform& operator=(const Platform&) = delete;
    virtual void make_current() = 0;
    /// May answer unknown names too.
    virtual AnyFunction find(const char* name) = 0;
};

// ---------------------------------------------------------------- OSMesa
class GlContext::OsMesa : public GlContext::Platform {
  public:
    OsMesa() {
        library_.find(create_, "OSMesaCreateContextAttribs");
        library_.find(destroy_, "OSMesaDestroyContext");
        library_.find(make_current_, "OSMesaMakeCurrent");
        library_.find(current_, "OSMesaGetCurrentContext");
        library_.find(find_, "OSMesaGetProcAddress");
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
        context_ = create_(attributes.data(), nullptr);
        if (context_ == nullptr)
            throw std::runtime_error("OSMesa cannot make an " + core +
                                     " context; Mesa's llvmpipe driver is needed (libosmesa6)");
    }
    ~OsMesa() override { destroy_(context_); }

    void make_current() override {
        if (current_() == context_) return;
        if (!make_current_(context_, pixels_.data(), GL_UNSIGNED_BYTE, size, size))
            throw std::runtime_error("OSMesa cannot make its context current on this thread");
    }
    AnyFunction find(const char* name) override { return find_(name); }

  private:
    Library library_{"OSMesa", {"libOSMesa.so.8", "libOSMesa.so.6", "libOSMesa.so"}};
    decltype(&OSMesaCreateContextAttribs) create_ = nullptr;
    decltype(&OSMesaDestroyContext) destroy_ = nullptr;
    decltype(&OSMesaMakeCurrent) make_current_ = nullptr;
    decltype(&OSMesaGetCurrentContext) current_ = nullptr;
    decltype(&OSMesaGetProcAddress) find_ = nullptr;
    OSMesaContext context_ = nullptr;
    // OSMesa wants memory for a default framebuffer. Drawing goes to framebuffer objects, so this stays
    // unused.
    static constexpr int size = 16;
    std::array<std::uint8_t, 4 * size * size> pixels_{};
};

// ---------------------------------------------------------------- EGL
class GlContext::Egl : public GlContext::Platform {
  public:
    Egl() {
        library_.find(find_, "eglGetProcAddress");
        library_.find(initialize_, "eglInitialize");
        library_.find(bind_, "eglBindAPI");
        library_.find(choose_, "eglChooseConfig");
        library_.find(create_, "eglCreateContext");
        library_.find(destroy_, "eglDestroyContext");
        library_.find(make_current_, "eglMakeCurrent");
        library_.find(current_, "eglGetCurrentContext");
        library_.find(query_, "eglQueryString");
        const char* extensions = query_(EGL_NO_DISPLAY, EGL_EXTENSIONS);
        const auto get_display =
            reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(find_("eglGetPlatformDisplayEXT"));
        if (extensions == nullptr || get_display == nullptr ||
            std::string_view(extensions).find("EGL_MESA_platform_surfaceless") == std::string_view::npos)
            throw std::runtime_error(
                "EGL cannot draw without a display server: it lacks EGL_MESA_platform_surfaceless");
        // A graphics card's driver would draw other pixels.
        setenv("LIBGL_ALWAYS_SOFTWARE", "1", /*overwrite=*/0);
        display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        EGLint major = 0, minor = 0;
        if (display_ == EGL_NO_DISPLAY || !initialize_(display_, &major, &minor))
            throw std::runtime_error(
                "EGL cannot start its surfaceless display; Mesa's driver may be missing "
                "(libegl-mesa0, libgl1-mesa-dri)");
        const std::string driver = "EGL " + std::to_string(major) + "." + std::to_string(minor) + " of " +
                                   std::string(query_(display_, EGL_VENDOR));
        if (!bind_(EGL_OPENGL_API)) throw std::runtime_error(driver + " has no OpenGL, only OpenGL ES");
        const std::array<EGLint, 5> wanted{EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT, EGL_SURFACE_TYPE,
                                           EGL_PBUFFER_BIT, EGL_NONE};
        EGLConfig config = nullptr;
        EGLint count = 0;
        if (!choose_(display_, wanted.data(), &config, 1, &count) || count < 1)
            throw std::runtime_error(driver + " has no configuration for OpenGL without a surface");
        const std::array<EGLint, 7> attributes{EGL_CONTEXT_MAJOR_VERSION,
                                               required_major,
                                               EGL_CONTEXT_MINOR_VERSION,
                                               required_minor,
                                               EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                               EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                               EGL_NONE};
        context_ = create_(display_, config, EGL_NO_CONTEXT, attributes.data());
        if (context_ == EGL_NO_CONTEXT)
            throw std::runtime_error(driver + " cannot make an " + core + " context");
    }
    ~Egl() override {
        if (current_() == context_) make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        destroy_(display_, context_);
    }

    void make_current() override {
        if (current_() == context_) return;
        if (!bind_(EGL_OPENGL_API) || !make_current_(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_))
            throw std::runtime_error("EGL cannot make its context current on this thread without a surface");
    }
    AnyFunction find(const char* name) override { return find_(name); }

  private:
    Library library_{"EGL", {"libEGL.so.1", "libEGL.so"}};
    decltype(&eglGetProcAddress) find_ = nullptr;
    decltype(&eglInitialize) initialize_ = nullptr;
    decltype(&eglBindAPI) bind_ = nullptr;
    decltype(&eglChooseConfig) choose_ = nullptr;
    decltype(&eglCreateContext) create_ = nullptr;
    decltype(&eglDestroyContext) destroy_ = nullptr;
    decltype(&eglMakeCurrent) make_current_ = nullptr;
    decltype(&eglGetCurrentContext) current_ = nullptr;
    decltype(&eglQueryString) query_ = nullptr;
    EGLDisplay display_ = EGL_NO_DISPLAY;  // one a process, shared by its contexts; never closed
    EGLContext context_ = EGL_NO_CONTEXT;
};

// ---------------------------------------------------------------- either
void GlContext::load_functions() {
    make_current();
    // Unknown names are answered too, so the version is what tells whether all are there.
#define CLOTH_GL_LOAD(name) gl.name = reinterpret_cast<decltype(gl.name)>(platform_->find("gl" #name));
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

GlContext::GlContext(int threads, GlLibrary library) {
    if (const char* width = std::getenv("LP_NATIVE_VECTOR_WIDTH");
        width != nullptr && std::string(width) == "512")
        throw std::runtime_error(
            "LP_NATIVE_VECTOR_WIDTH is 512, at which llvmpipe crashes; unset it or make it 128 or 256");
    set_driver_threads(threads);
    std::string failure;
    if (library != GlLibrary::egl) try {
            platform_ = std::make_unique<OsMesa>();
            load_functions();
            return;
        } catch (const std::runtime_error& error) {
            if (library == GlLibrary::osmesa) throw;
            failure = error.what();
        }
    try {
        platform_ = std::make_unique<Egl>();
        load_functions();
    } catch (const std::runtime_error& error) {
        if (library == GlLibrary::egl) throw;
        throw std::runtime_error(failure + "; and " + error.what());
    }
}

GlContext::~GlContext() = default;

void GlContext::make_current() {
    platform_->make_current();
}

}  // namespace cloth::render
