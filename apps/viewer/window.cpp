// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/window.h"

#include <algorithm>
#include <array>
#include <utility>

#include <epoxy/gl.h>

#define GLFW_INCLUDE_NONE
#include <GLFW/glfw3.h>

namespace cholecystectomy {
namespace {

// What GLFW said last: its functions return no reason.
std::string& last_error() {
  static std::string text;
  return text;
}

void note_error(int /*code*/, const char* text) {
  last_error() = text;
}

Key key_of(int key) {
  if (key >= GLFW_KEY_A && key <= GLFW_KEY_Z) {
    return static_cast<Key>(static_cast<int>(Key::a) + key - GLFW_KEY_A);
  }
  if (key >= GLFW_KEY_F1 && key <= GLFW_KEY_F12) {
    return static_cast<Key>(static_cast<int>(Key::f1) + key - GLFW_KEY_F1);
  }
  constexpr std::array<std::pair<int, Key>, 12> kOthers{
      {{GLFW_KEY_SPACE, Key::space},
       {GLFW_KEY_TAB, Key::tab},
       {GLFW_KEY_ESCAPE, Key::escape},
       {GLFW_KEY_ENTER, Key::enter},
       {GLFW_KEY_LEFT_BRACKET, Key::left_bracket},
       {GLFW_KEY_RIGHT_BRACKET, Key::right_bracket},
       {GLFW_KEY_COMMA, Key::comma},
       {GLFW_KEY_PERIOD, Key::period},
       {GLFW_KEY_LEFT, Key::left},
       {GLFW_KEY_RIGHT, Key::right},
       {GLFW_KEY_UP, Key::up},
       {GLFW_KEY_DOWN, Key::down}}};
  const auto found = std::ranges::find(kOthers, key, &std::pair<int, Key>::first);
  return found == kOthers.end() ? Key::other : found->second;
}

}  // namespace

struct Window::Impl {
  GLFWwindow* window = nullptr;
  std::vector<Input> inputs;
  std::array<int, 4> windowed{};  // place and size before it filled the screen

  static Impl& of(GLFWwindow* window) {
    return *static_cast<Impl*>(glfwGetWindowUserPointer(window));
  }

  void listen() {
    glfwSetWindowUserPointer(window, this);
    glfwSetKeyCallback(window, [](GLFWwindow* from, int key, int, int action, int modifiers) {
      if (action != GLFW_REPEAT) {
        of(from).inputs.push_back(
            KeyInput{key_of(key), action == GLFW_PRESS, (modifiers & GLFW_MOD_SHIFT) != 0});
      }
    });
    glfwSetMouseButtonCallback(window, [](GLFWwindow* from, int button, int action, int) {
      if (button <= GLFW_MOUSE_BUTTON_MIDDLE) {
        of(from).inputs.push_back(
            ButtonInput{static_cast<MouseButton>(button), action == GLFW_PRESS});
      }
    });
    glfwSetCursorPosCallback(window, [](GLFWwindow* from, double x, double y) {
      // screen units, which some systems count coarser than pixels
      int width = 1, pixels = 1;
      glfwGetWindowSize(from, &width, nullptr);
      glfwGetFramebufferSize(from, &pixels, nullptr);
      const double ratio = width > 0 ? static_cast<double>(pixels) / width : 1;
      of(from).inputs.push_back(
          CursorInput{static_cast<float>(ratio * x), static_cast<float>(ratio * y)});
    });
    glfwSetScrollCallback(window, [](GLFWwindow* from, double, double notches) {
      of(from).inputs.push_back(WheelInput{static_cast<float>(notches)});
    });
    glfwSetWindowFocusCallback(window, [](GLFWwindow* from, int focused) {
      of(from).inputs.push_back(FocusInput{focused == GLFW_TRUE});
    });
    glfwSetWindowIconifyCallback(window, [](GLFWwindow* from, int minimised) {
      if (minimised == GLFW_TRUE) {
        of(from).inputs.push_back(FocusInput{false});
      }
    });
  }
};

static_assert(GLFW_MOUSE_BUTTON_LEFT == static_cast<int>(MouseButton::left) &&
              GLFW_MOUSE_BUTTON_RIGHT == static_cast<int>(MouseButton::right) &&
              GLFW_MOUSE_BUTTON_MIDDLE == static_cast<int>(MouseButton::middle));

Window::Window(const WindowOptions& options) : impl_(std::make_unique<Impl>()) {
  glfwSetErrorCallback(note_error);
  last_error().clear();
  if (glfwInit() != GLFW_TRUE) {
    throw pbdsurg::BackendUnavailable(
        "no window can be opened (" + last_error() +
        "); start it on a desktop, or use --headless, which needs no display");
  }
  glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 3);
  glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 3);
  glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
  glfwWindowHint(GLFW_CONTEXT_ROBUSTNESS, GLFW_LOSE_CONTEXT_ON_RESET);
  // pictures have buffers of their own; the window's needs colours alone
  glfwWindowHint(GLFW_DEPTH_BITS, 0);
  glfwWindowHint(GLFW_STENCIL_BITS, 0);
  impl_->window =
      glfwCreateWindow(options.width, options.height, options.title.c_str(), nullptr, nullptr);
  if (impl_->window == nullptr) {
    const std::string reason = last_error();
    throw pbdsurg::BackendUnavailable(
        "this display has no OpenGL 3.3 (" + reason +
        "); update the graphics driver, set LIBGL_ALWAYS_SOFTWARE=1, or use --headless");
  }
  impl_->listen();
  glfwMakeContextCurrent(impl_->window);
  glfwSwapInterval(1);
  const GLubyte* device = glGetString(GL_RENDERER);
  device_name_ = device != nullptr ? reinterpret_cast<const char*>(device) : "unknown";
}

Window::~Window() {
  // GLFW is never ended: the driver would be unloaded, and lose allocations that it still holds
  glfwDestroyWindow(impl_->window);
}

void Window::poll(double patience) {
  if (patience > 0) {
    glfwWaitEventsTimeout(patience);
  } else {
    glfwPollEvents();
  }
}

std::vector<Input> Window::take_inputs() {
  return std::exchange(impl_->inputs, {});
}

bool Window::is_closing() const {
  return glfwWindowShouldClose(impl_->window) == GLFW_TRUE;
}

int Window::width() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(impl_->window, &width, &height);
  return glfwGetWindowAttrib(impl_->window, GLFW_ICONIFIED) == GLFW_TRUE ? 0 : width;
}

int Window::height() const {
  int width = 0, height = 0;
  glfwGetFramebufferSize(impl_->window, &width, &height);
  return glfwGetWindowAttrib(impl_->window, GLFW_ICONIFIED) == GLFW_TRUE ? 0 : height;
}

std::array<int, 2> Window::windowed_size() const {
  if (glfwGetWindowMonitor(impl_->window) != nullptr) {
    return {impl_->windowed[2], impl_->windowed[3]};
  }
  std::array<int, 2> size{};
  glfwGetWindowSize(impl_->window, &size[0], &size[1]);
  return size;
}

float Window::scale() const {
  float wanted = 1;
  glfwGetWindowContentScale(impl_->window, &wanted, nullptr);
  int units = 1, pixels = 1;
  glfwGetWindowSize(impl_->window, &units, nullptr);
  glfwGetFramebufferSize(impl_->window, &pixels, nullptr);
  return units > 0 && pixels > 0 ? wanted * static_cast<float>(units) / static_cast<float>(pixels)
                                 : wanted;
}

void Window::show() {
  glfwSwapBuffers(impl_->window);
}

void Window::toggle_fullscreen() {
  auto& [x, y, width, height] = impl_->windowed;
  if (glfwGetWindowMonitor(impl_->window) != nullptr) {
    glfwSetWindowMonitor(impl_->window, nullptr, x, y, width, height, 0);
    return;
  }
  GLFWmonitor* const monitor = glfwGetPrimaryMonitor();
  if (monitor == nullptr) {
    return;
  }
  glfwGetWindowPos(impl_->window, &x, &y);
  glfwGetWindowSize(impl_->window, &width, &height);
  const GLFWvidmode* const mode = glfwGetVideoMode(monitor);
  glfwSetWindowMonitor(impl_->window, monitor, 0, 0, mode->width, mode->height, mode->refreshRate);
}

bool Window::is_lost() const {
  return epoxy_has_gl_extension("GL_ARB_robustness") &&
         glGetGraphicsResetStatusARB() != GL_NO_ERROR;
}

bool Window::is_software() const {
  return device_name_.find("llvmpipe") != std::string::npos ||
         device_name_.find("softpipe") != std::string::npos ||
         device_name_.find("SWR") != std::string::npos;
}

GLFWwindow* Window::handle() const {
  return impl_->window;
}

}  // namespace cholecystectomy
