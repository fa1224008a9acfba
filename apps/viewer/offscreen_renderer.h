// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Pictures without a display or a window.

#include <cstddef>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "apps/viewer/image.h"
#include "apps/viewer/pass_timer.h"
#include "apps/viewer/render_quality.h"
#include "apps/viewer/render_snapshot.h"

namespace cholecystectomy {

struct OffscreenOptions {
  int width = 960;   ///< pixels, 16..8192
  int height = 720;  ///< pixels, 16..8192
  RenderQuality quality = RenderQuality::full();
};

/// Keeps surfaces and draws them into memory through EGL and OpenGL 3.3, on a GPU or in software.
///
/// The same surfaces and view give the same bytes on one machine. An object is used by one thread
/// at a time; several may exist.
class OffscreenRenderer {
 public:
  /// @throws pbdsurg::InvalidArgument  if the size or the quality is out of range
  /// @throws pbdsurg::BackendUnavailable  if no OpenGL 3.3 context can be had; the message says why
  explicit OffscreenRenderer(const OffscreenOptions& options);
  ~OffscreenRenderer();
  OffscreenRenderer(OffscreenRenderer&&) noexcept;
  OffscreenRenderer& operator=(OffscreenRenderer&&) noexcept;

  /// As SceneRenderer::set_surfaces().
  void set_surfaces(std::span<const Surface> surfaces);

  /// As SceneRenderer::update().
  void update(std::size_t surface, const SurfaceChange& change);

  /// Draws the surfaces as they are and waits until that is done: for who measures.
  /// @throws pbdsurg::InvalidArgument  as render()
  void draw(const SceneView& view);

  /// draw() in two parts: a GPU works between them, while the program does something else.
  void start(const SceneView& view);
  void finish();  ///< waits until the picture is there

  /// draw(), and what the device took for each pass of it.
  /// @throws pbdsurg::InvalidArgument  as render()
  [[nodiscard]] std::vector<PassTime> time_passes(const SceneView& view);

  /// Draws the surfaces as they are. What is not finite is left out.
  /// @throws pbdsurg::InvalidArgument  if an array of a sheet has the wrong length, a triangle
  /// names
  ///         a vertex that is not there, or the camera is not usable
  /// Cost: most goes into pixels; picture_bench measures it.
  [[nodiscard]] Image render(const SceneView& view);

  /// set_surfaces() and render().
  /// @throws pbdsurg::InvalidArgument  as both
  [[nodiscard]] Image render(const RenderSnapshot& snapshot);

  /// The device that draws, as OpenGL names it.
  [[nodiscard]] const std::string& device_name() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace cholecystectomy
