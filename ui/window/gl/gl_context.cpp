#include "ui/window/gl/gl_context.h"

#include <dlfcn.h>
#include <epoxy/egl.h>
#include <epoxy/gl.h>
#include <fmt/format.h>
#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

#include <array>
#include <cstdlib>
#include <string_view>

namespace kerf {
namespace {

constexpr const char* kPackages = "apt install libegl1 libgl1 libgl1-mesa-dri, or run under xvfb-run";

class EglContext final : public OffscreenContext {
 public:
  EGLDisplay display = EGL_NO_DISPLAY;
  EGLSurface surface = EGL_NO_SURFACE;
  EGLContext context = EGL_NO_CONTEXT;

  ~EglContext() override {
    if (display == EGL_NO_DISPLAY) return;
    eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    if (context != EGL_NO_CONTEXT) eglDestroyContext(display, context);
    if (surface != EGL_NO_SURFACE) eglDestroySurface(display, surface);
    eglTerminate(display);
  }
};

class HiddenWindow final : public OffscreenContext {
 public:
  GLFWwindow* window = nullptr;
  ~HiddenWindow() override {
    if (window) glfwDestroyWindow(window);
    glfwTerminate();
  }
};

/// Check first: libepoxy ends the program if a library is missing.
bool canLoad(std::initializer_list<const char*> any_of) {
  for (const char* name : any_of)
    if (dlopen(name, RTLD_LAZY | RTLD_GLOBAL)) return true;  // kept open: epoxy needs it next
  return false;
}

std::string eglError(const char* what) { return fmt::format("{} failed (EGL error 0x{:x})", what, eglGetError()); }

std::string describe(std::string_view how) {
  return fmt::format("{}: {}, OpenGL {}", how, reinterpret_cast<const char*>(glGetString(GL_RENDERER)),
                     reinterpret_cast<const char*>(glGetString(GL_VERSION)));
}

/// Makes a context current on `display`, or returns null with the reason in `why`. Uses a 1 x 1 pbuffer if the display
/// needs a surface; pictures are drawn into framebuffer objects either way.
std::unique_ptr<EglContext> contextOn(EGLDisplay display, std::string& why) {
  if (display == EGL_NO_DISPLAY) {
    why = eglError("opening the display");
    return nullptr;
  }
  EGLint major = 0, minor = 0;
  if (!eglInitialize(display, &major, &minor)) {
    why = eglError("eglInitialize");
    return nullptr;
  }

  auto egl = std::make_unique<EglContext>();
  egl->display = display;
  if (!eglBindAPI(EGL_OPENGL_API)) {
    why = eglError("binding the OpenGL API");
    return nullptr;
  }

  const std::array<EGLint, 5> wanted = {EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE, EGL_OPENGL_BIT,
                                        EGL_NONE};
  EGLConfig config = nullptr;
  EGLint count = 0;
  if (!eglChooseConfig(display, wanted.data(), &config, 1, &count) || count == 0) {
    why = eglError("choosing a configuration");
    return nullptr;
  }

  const std::array<EGLint, 7> version = {EGL_CONTEXT_MAJOR_VERSION_KHR,
                                         3,
                                         EGL_CONTEXT_MINOR_VERSION_KHR,
                                         3,
                                         EGL_CONTEXT_OPENGL_PROFILE_MASK_KHR,
                                         EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT_KHR,
                                         EGL_NONE};
  egl->context = eglCreateContext(display, config, EGL_NO_CONTEXT, version.data());
  if (egl->context == EGL_NO_CONTEXT) {
    why = eglError("creating an OpenGL 3.3 core context");
    return nullptr;
  }

  if (eglMakeCurrent(display, EGL_NO_SURFACE, EGL_NO_SURFACE, egl->context)) return egl;
  const std::array<EGLint, 5> size = {EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
  egl->surface = eglCreatePbufferSurface(display, config, size.data());
  if (egl->surface == EGL_NO_SURFACE || !eglMakeCurrent(display, egl->surface, egl->surface, egl->context)) {
    why = eglError("making the context current");
    return nullptr;
  }
  return egl;
}

std::unique_ptr<OffscreenContext> throughEgl(std::string& attempts) {
  const char* raw = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
  const std::string extensions = raw ? std::string(" ") + raw + " " : "";
  const auto has = [&](std::string_view name) {
    return extensions.find(fmt::format(" {} ", name)) != std::string::npos;
  };

  std::string why;
  const auto attempt = [&](const char* how, EGLDisplay display) -> std::unique_ptr<OffscreenContext> {
    auto egl = contextOn(display, why);
    if (egl) egl->description = describe(how);
    if (!egl) attempts += fmt::format("{}: {}; ", how, why);
    return egl;
  };

  if (has("EGL_EXT_platform_base") && has("EGL_MESA_platform_surfaceless")) {
    if (auto c = attempt("EGL without a surface",
                         eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr)))
      return c;
  } else {
    attempts += "EGL without a surface: not offered by this EGL; ";
  }

  if (has("EGL_EXT_platform_base") && has("EGL_EXT_platform_device") && has("EGL_EXT_device_enumeration")) {
    std::array<EGLDeviceEXT, 16> devices{};
    EGLint count = 0;
    eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count);
    for (EGLint i = 0; i < count; ++i)
      if (auto c = attempt("EGL device", eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                                                  devices[static_cast<std::size_t>(i)], nullptr)))
        return c;
  }
  return attempt("EGL default display", eglGetDisplay(EGL_DEFAULT_DISPLAY));
}

std::unique_ptr<OffscreenContext> throughHiddenWindow(std::string& attempts) {
  if (!std::getenv("DISPLAY") && !std::getenv("WAYLAND_DISPLAY")) {
    attempts += "hidden window: no display";
    return nullptr;
  }
  if (!glfwInit()) {
    attempts += "hidden window: cannot open the display";
    return nullptr;
  }

  auto hidden = std::make_unique<HiddenWindow>();
  glfwWindowHint(GLFW_VISIBLE, GLFW_FALSE);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  hidden->window = glfwCreateWindow(16, 16, "kerf", nullptr, nullptr);
  if (!hidden->window) {
    attempts += "hidden window: no OpenGL 3.3 on this display";
    return nullptr;
  }

  glfwMakeContextCurrent(hidden->window);
  hidden->description = describe("hidden GLFW window");
  return hidden;
}

}  // namespace

Expected<std::unique_ptr<OffscreenContext>> OffscreenContext::create(bool software) {
  if (software) setenv("LIBGL_ALWAYS_SOFTWARE", "1", 0);
  std::string attempts;
  if (!canLoad({"libOpenGL.so.0", "libGL.so.1"}))
    attempts = "cannot load libOpenGL.so.0 or libGL.so.1";
  else {
    if (!canLoad({"libEGL.so.1"}))
      attempts = "cannot load libEGL.so.1; ";
    else if (auto context = throughEgl(attempts))
      return context;
    if (auto context = throughHiddenWindow(attempts)) return context;
  }
  return fail({.code = Error::Code::kUnsupported,
               .file = {},
               .place = "picture",
               .found = "no way to draw without a window: " + attempts,
               .expected = "OpenGL 3.3 through EGL or a display",
               .hint = kPackages});
}

}  // namespace kerf
