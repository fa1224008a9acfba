// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the passes of a picture draw into.

#include <array>
#include <optional>

#include "apps/viewer/gl_objects.h"
#include "apps/viewer/render_quality.h"

namespace cholecystectomy {

/// A texture that is drawn into.
struct ColorTarget {
  /// @param filter  GL_NEAREST or GL_LINEAR
  ColorTarget(int width, int height, GLenum internal_format, GLenum filter);

  /// Makes it what is drawn into, over its whole size.
  void begin() const;

  int width;
  int height;
  GlTexture texture;
  GlFramebuffer framebuffer;
};

/// The shadow map: depth alone, compared when it is read.
struct ShadowTarget {
  explicit ShadowTarget(int size);
  void begin() const;

  int size;
  GlTexture texture;
  GlFramebuffer framebuffer;
};

/// Normals and depth at half size, and what is made of them. Half-precision floats: a depth is
/// right within 0.05 %, a tenth of what the occlusion takes for nothing, and is read in half the
/// time.
struct OcclusionTargets {
  OcclusionTargets(int width, int height);

  ColorTarget geometry;
  GlRenderbuffer depth;
  ColorTarget raw;      ///< visibility and depth
  ColorTarget blurred;  ///< the same
};

/// All of a renderer. What its quality leaves out does not exist.
struct RenderTargets {
  /// @param is_exact  for colours that are read as given. Else light has 6 bits behind its
  /// exponent,
  ///                  blue 5, in half the memory: what a scope shows is off by less than a level of
  ///                  255, blue by little more
  /// @throws pbdsurg::BackendUnavailable  if the driver offers no such framebuffer
  RenderTargets(int width, int height, const RenderQuality& quality, bool is_exact);

  /// Makes the lit picture what is drawn into.
  void begin_lit() const;
  /// From then on `resolved` has the lit picture.
  void finish_lit() const;

  int width;
  int height;
  bool is_exact;
  ColorTarget resolved;  ///< linear light
  GlRenderbuffer depth;
  std::optional<GlRenderbuffer> multisampled_color;
  std::optional<GlFramebuffer> multisampled;
  std::optional<ShadowTarget> shadow;
  std::optional<OcclusionTargets> occlusion;
  std::optional<std::array<ColorTarget, 2>> glow;  ///< horizontal, both directions
};

}  // namespace cholecystectomy
