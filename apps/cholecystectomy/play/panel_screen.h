// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Panels in a window.

#include "apps/cholecystectomy/play/panels.h"
#include "apps/viewer/window.h"

namespace cholecystectomy {

/// Tells the context of panels what the window hears, and draws what it holds, by OpenGL.
class PanelScreen {
 public:
  /// @param window  kept by reference
  /// @param panels  whose context it uses; outlives this
  PanelScreen(Window& window, const Panels& panels);
  ~PanelScreen();
  PanelScreen(const PanelScreen&) = delete;
  PanelScreen& operator=(const PanelScreen&) = delete;

  /// Before panels are laid out.
  void begin(Panels& panels, double text_scale);
  /// Draws them over the framebuffer that is bound.
  void draw();

 private:
  Window& window_;
};

}  // namespace cholecystectomy
