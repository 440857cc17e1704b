#include "tests/gl/context.h"

#include <array>
#include <cstdlib>
#include <cstring>

#define EGL_NO_X11
#define GL_GLEXT_PROTOTYPES
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/glcorearb.h>
#include <fmt/format.h>

namespace gnomon_gl {
namespace {

bool has_word(const char* list, const char* word) { return list && std::strstr(list, word); }

template <class Function> Function extension(const char* name) {
    return reinterpret_cast<Function>(eglGetProcAddress(name));
}

EGLDisplay surfaceless_display() {
    const auto get = extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    return get ? get(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr) : EGL_NO_DISPLAY;
}

// The first device that is not a software rasterizer.
EGLDisplay hardware_display() {
    const auto get = extension<PFNEGLGETPLATFORMDISPLAYEXTPROC>("eglGetPlatformDisplayEXT");
    const auto query = extension<PFNEGLQUERYDEVICESEXTPROC>("eglQueryDevicesEXT");
    const auto describe = extension<PFNEGLQUERYDEVICESTRINGEXTPROC>("eglQueryDeviceStringEXT");
    if (!get || !query || !describe) return EGL_NO_DISPLAY;
    std::array<EGLDeviceEXT, 16> devices;
    EGLint count = 0;
    if (!query(static_cast<EGLint>(devices.size()), devices.data(), &count)) return EGL_NO_DISPLAY;
    for (size_t i = 0; i < static_cast<size_t>(count); ++i)
        if (!has_word(describe(devices[i], EGL_EXTENSIONS), "EGL_MESA_device_software"))
            return get(EGL_PLATFORM_DEVICE_EXT, devices[i], nullptr);
    return EGL_NO_DISPLAY;
}

void choose_software(int threads) {
    setenv("EGL_PLATFORM", "surfaceless", 1);
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    if (threads > 0) setenv("LP_NUM_THREADS", std::to_string(threads).c_str(), 1);
}

} // namespace

std::unique_ptr<Context> Context::open(const ContextOptions& options, std::string& reason) {
    if (!options.hardware) choose_software(options.threads);
    const EGLDisplay display = options.hardware ? hardware_display() : surfaceless_display();
    EGLint major = 0, minor = 0;
    if (display == EGL_NO_DISPLAY || !eglInitialize(display, &major, &minor)) {
        reason = options.hardware ? "EGL offers no hardware device" : "EGL offers no surfaceless display";
        return nullptr;
    }
    eglBindAPI(EGL_OPENGL_API);
    const std::array<EGLint, 7> attributes = {
        EGL_CONTEXT_MAJOR_VERSION,           4,       EGL_CONTEXT_MINOR_VERSION, 5, EGL_CONTEXT_OPENGL_PROFILE_MASK,
        EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT, EGL_NONE};
    const EGLContext context = eglCreateContext(display, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes.data());
    if (context == EGL_NO_CONTEXT || !eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, context)) {
        reason = fmt::format("EGL {}.{} gives no OpenGL 4.5 core context (error {:#x})", major, minor, eglGetError());
        eglTerminate(display);
        return nullptr;
    }
    return std::unique_ptr<Context>(new Context(display, context));
}

Context::~Context() {
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
    eglTerminate(display_);
}

std::string Context::description() const {
    const auto text = [](GLenum name) { return reinterpret_cast<const char*>(glGetString(name)); };
    GLint bits = 0;
    glGetIntegerv(GL_SUBPIXEL_BITS, &bits);
    return fmt::format("{}, OpenGL {}, {} sub-pixel bits", text(GL_RENDERER), text(GL_VERSION), bits);
}

} // namespace gnomon_gl
