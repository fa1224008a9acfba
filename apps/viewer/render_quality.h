// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How much a renderer spends on a picture.

namespace cholecystectomy {

struct RenderQuality {
  int samples = 4;         ///< of a pixel; 1: no multisampling
  int subdivision = 3;     ///< an edge of a surface's triangle becomes so many, 1..8; fewer where
                           ///< the parts would be shorter than some pixels
  int shadow_size = 1024;  ///< texels along a side of the shadow map; 0: no shadows
  bool occlusion = true;   ///< less light in hollows
  bool glow = true;        ///< light around highlights
  bool detail = true;      ///< all layers of the tissue's texture, and soft shadows

  friend bool operator==(const RenderQuality&, const RenderQuality&) = default;

  /// For a GPU.
  static RenderQuality full() { return {}; }
  /// For OpenGL in software.
  static RenderQuality quick() {
    return {.samples = 1,
            .subdivision = 2,
            .shadow_size = 512,
            .occlusion = false,
            .glow = false,
            .detail = false};
  }
};

}  // namespace cholecystectomy
