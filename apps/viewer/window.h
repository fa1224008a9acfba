// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A window with an OpenGL context.

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/viewer/input.h"

struct GLFWwindow;

namespace cholecystectomy {

struct WindowOptions {
  std::string title;
  int width = 1280;
  int height = 720;
};

/// OpenGL 3.3 core. One at a time; all of it belongs to the program's first thread.
class Window {
 public:
  /// Opens it and makes its context current.
  /// @throws pbdsurg::BackendUnavailable  in one sentence, where there is no display or no such
  ///                                      OpenGL
  explicit Window(const WindowOptions& options);
  ~Window();
  Window(const Window&) = delete;
  Window& operator=(const Window&) = delete;

  /// Takes in what happened since the last call, waiting for it at most so long.
  /// @param patience  s; 0: not at all
  void poll(double patience = 0);

  /// What happened since the last call.
  [[nodiscard]] std::vector<Input> take_inputs();

  [[nodiscard]] bool is_closing() const;  ///< someone wants it closed
  [[nodiscard]] int width() const;        ///< pixels; 0 while it is minimised
  [[nodiscard]] int height() const;       ///< likewise

  /// Of the window, as it was before it filled the screen, in the units of WindowOptions, which
  /// some systems count coarser than pixels.
  [[nodiscard]] std::array<int, 2> windowed_size() const;
  /// How large a screen wants texts, in those units.
  [[nodiscard]] float scale() const;

  void show();  ///< the picture that was drawn last
  void toggle_fullscreen();

  /// Whether the driver has lost the context, as after a reset of the GPU: what lives in it is
  /// gone.
  [[nodiscard]] bool is_lost() const;

  [[nodiscard]] const std::string& device_name() const { return device_name_; }
  /// Whether a processor draws in place of a GPU.
  [[nodiscard]] bool is_software() const;

  [[nodiscard]] GLFWwindow* handle() const;  ///< for who adds panels

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
  std::string device_name_;
};

}  // namespace cholecystectomy
