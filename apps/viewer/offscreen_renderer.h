// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Pictures without a display or a window.

#include <memory>
#include <string>

#include "apps/viewer/image.h"
#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

struct OffscreenOptions {
  int width = 960;   ///< pixels, 16..8192
  int height = 720;  ///< pixels, 16..8192
};

/// Draws snapshots into memory through EGL and OpenGL 3.3, on a GPU or in software.
///
/// The same snapshot gives the same bytes on one machine. An object is used by one thread at a
/// time; several may exist.
class OffscreenRenderer {
 public:
  /// @throws pbdsurg::InvalidArgument  if the size is out of range
  /// @throws pbdsurg::BackendUnavailable  if no OpenGL 3.3 context can be had; the message says why
  explicit OffscreenRenderer(const OffscreenOptions& options);
  ~OffscreenRenderer();
  OffscreenRenderer(OffscreenRenderer&&) noexcept;
  OffscreenRenderer& operator=(OffscreenRenderer&&) noexcept;

  /// Draws one snapshot as seen through the scope. What is not finite is left out.
  /// @throws pbdsurg::InvalidArgument  if an array has the wrong length, a triangle names a vertex
  ///         that is not there, or the camera is not usable
  /// Cost: most goes into pixels; in software on two cores, 960 x 720 takes about half a second.
  [[nodiscard]] Image render(const RenderSnapshot& snapshot);

  /// The device that draws, as OpenGL names it.
  [[nodiscard]] const std::string& device_name() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cholecystectomy
