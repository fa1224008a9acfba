// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An OpenGL context that needs no window.

namespace cholecystectomy {

/// An OpenGL 3.3 core context without a default framebuffer. Tries Mesa's surfaceless platform,
/// then every EGL device, then the default display.
class EglContext {
 public:
  /// Leaves the new context current.
  /// @throws pbdsurg::BackendUnavailable  with what EGL said about each way that was tried
  EglContext();
  ~EglContext();
  EglContext(const EglContext&) = delete;
  EglContext& operator=(const EglContext&) = delete;

  /// Binds the context to the calling thread.
  void make_current();

 private:
  class Display;
  const Display* display_;
  void* context_;
  void* surface_;  ///< a 1 x 1 pixel buffer where contexts need a surface, else null
};

}  // namespace cholecystectomy
