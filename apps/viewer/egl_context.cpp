// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/egl_context.h"

#include <array>
#include <cstdio>
#include <string>
#include <vector>

#include <epoxy/egl.h>
#include <epoxy/gl.h>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

std::string egl_error() {
  std::array<char, 16> code{};
  std::snprintf(code.data(), code.size(), "0x%04x", static_cast<unsigned>(eglGetError()));
  return std::string("EGL error ") + code.data();
}

struct Candidate {
  std::string name;
  EGLDisplay display;
};

std::vector<Candidate> candidates() {
  std::vector<Candidate> found;
  if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_base")) {
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_MESA_platform_surfaceless")) {
      found.push_back({"surfaceless", eglGetPlatformDisplayEXT(EGL_PLATFORM_SURFACELESS_MESA,
                                                               EGL_DEFAULT_DISPLAY, nullptr)});
    }
    if (epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_platform_device") &&
        epoxy_has_egl_extension(EGL_NO_DISPLAY, "EGL_EXT_device_enumeration")) {
      std::array<EGLDeviceEXT, 16> devices{};
      EGLint count = 0;
      if (eglQueryDevicesEXT(static_cast<EGLint>(devices.size()), devices.data(), &count) ==
          EGL_TRUE) {
        for (EGLint i = 0; i < count; ++i) {
          found.push_back(
              {"device " + std::to_string(i),
               eglGetPlatformDisplayEXT(EGL_PLATFORM_DEVICE_EXT,
                                        devices[static_cast<std::size_t>(i)], nullptr)});
        }
      }
    }
  }
  found.push_back({"default display", eglGetDisplay(EGL_DEFAULT_DISPLAY)});
  return found;
}

/// A configuration that can draw with OpenGL. The default of EGL_SURFACE_TYPE asks for a window,
/// which displays without windows never offer.
bool choose_config(EGLDisplay display, EGLConfig& config) {
  const std::array<EGLint, 5> wanted{EGL_SURFACE_TYPE, EGL_PBUFFER_BIT, EGL_RENDERABLE_TYPE,
                                     EGL_OPENGL_BIT, EGL_NONE};
  EGLint count = 0;
  return eglChooseConfig(display, wanted.data(), &config, 1, &count) == EGL_TRUE && count > 0;
}

EGLContext create_context(EGLDisplay display, EGLConfig config) {
  const std::array<EGLint, 7> wanted{EGL_CONTEXT_MAJOR_VERSION,
                                     3,
                                     EGL_CONTEXT_MINOR_VERSION,
                                     3,
                                     EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                     EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                     EGL_NONE};
  return eglCreateContext(display, config, EGL_NO_CONTEXT, wanted.data());
}

}  // namespace

/// An initialised display. EGL hands out one display per platform and process, and one terminate
/// ends it for all, so contexts share it. It is never terminated: Mesa would unload its driver, and
/// lose allocations that the driver still holds.
class EglContext::Display {
 public:
  static const Display& get() {
    static const Display* const display = new Display;  // a failed attempt is tried again
    return *display;
  }

  Display() {
    if (!epoxy_has_egl()) {
      throw pbdsurg::BackendUnavailable("no OpenGL context: libEGL.so.1 could not be loaded");
    }
    std::string reasons;
    for (const Candidate& candidate : candidates()) {
      const std::string reason = try_open(candidate.display);
      if (reason.empty()) {
        return;
      }
      reasons += "; " + candidate.name + ": " + reason;
    }
    throw pbdsurg::BackendUnavailable("no OpenGL 3.3 context without a display" + reasons);
  }

  Display(const Display&) = delete;
  Display& operator=(const Display&) = delete;

  [[nodiscard]] EGLDisplay handle() const { return handle_; }
  [[nodiscard]] EGLConfig config() const { return config_; }

 private:
  /// @return  why the display is of no use, empty if it is open
  std::string try_open(EGLDisplay display) {
    if (display == EGL_NO_DISPLAY || eglInitialize(display, nullptr, nullptr) != EGL_TRUE) {
      return egl_error();
    }
    std::string reason;
    if (eglBindAPI(EGL_OPENGL_API) != EGL_TRUE) {
      reason = "no OpenGL, " + egl_error();
    } else if (!choose_config(display, config_)) {
      reason = "no configuration for OpenGL, " + egl_error();
    } else if (const EGLContext probe = create_context(display, config_); probe == EGL_NO_CONTEXT) {
      reason = "no OpenGL 3.3 core context, " + egl_error();
    } else {
      eglDestroyContext(display, probe);
      handle_ = display;
      return {};
    }
    eglTerminate(display);
    return reason;
  }

  EGLDisplay handle_ = EGL_NO_DISPLAY;
  EGLConfig config_ = nullptr;
};

EglContext::EglContext()
    : display_(&Display::get()), context_(EGL_NO_CONTEXT), surface_(EGL_NO_SURFACE) {
  eglBindAPI(EGL_OPENGL_API);  // per thread
  context_ = create_context(display_->handle(), display_->config());
  if (context_ == EGL_NO_CONTEXT) {
    throw pbdsurg::BackendUnavailable("no OpenGL 3.3 context: " + egl_error());
  }
  if (!epoxy_has_egl_extension(display_->handle(), "EGL_KHR_surfaceless_context")) {
    const std::array<EGLint, 5> size{EGL_WIDTH, 1, EGL_HEIGHT, 1, EGL_NONE};
    surface_ = eglCreatePbufferSurface(display_->handle(), display_->config(), size.data());
  }
  if (eglMakeCurrent(display_->handle(), surface_, surface_, context_) != EGL_TRUE) {
    const std::string reason = egl_error();
    if (surface_ != EGL_NO_SURFACE) {
      eglDestroySurface(display_->handle(), surface_);
    }
    eglDestroyContext(display_->handle(), context_);
    throw pbdsurg::BackendUnavailable("the OpenGL context cannot be made current: " + reason);
  }
}

EglContext::~EglContext() {
  if (eglGetCurrentContext() == context_) {
    eglMakeCurrent(display_->handle(), EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  if (surface_ != EGL_NO_SURFACE) {
    eglDestroySurface(display_->handle(), surface_);
  }
  eglDestroyContext(display_->handle(), context_);
}

void EglContext::make_current() {
  if (eglGetCurrentContext() != context_ &&
      eglMakeCurrent(display_->handle(), surface_, surface_, context_) != EGL_TRUE) {
    throw pbdsurg::BackendUnavailable("the OpenGL context cannot be made current: " + egl_error());
  }
}

}  // namespace cholecystectomy
