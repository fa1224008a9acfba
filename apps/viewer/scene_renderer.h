// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Draws snapshots with OpenGL 3.3 into a framebuffer of its host, be that memory or a window.

#include <array>

#include "apps/viewer/gl_objects.h"
#include "apps/viewer/render_snapshot.h"
#include "apps/viewer/shader_program.h"
#include "apps/viewer/view.h"

namespace cholecystectomy {

struct DrawList;

/// Passes: shadow map from the lamp; normals and depth at half size; occlusion and its blur; the
/// scene in linear light with four samples a pixel; glow; scope. Needs a current context from
/// construction to destruction.
class SceneRenderer {
 public:
  /// @throws pbdsurg::BackendUnavailable  if the driver lacks something that a pass needs
  SceneRenderer(int width, int height);

  /// @param framebuffer  what receives the picture, of the size given at construction
  /// @throws pbdsurg::InvalidArgument  as OffscreenRenderer::render()
  void draw(const RenderSnapshot& snapshot, GLuint framebuffer);

 private:
  /// A texture that is drawn into.
  struct Target {
    GlTexture texture;
    GlFramebuffer framebuffer;
    int width;
    int height;
  };

  static Target make_color_target(int width, int height, GLenum internal_format, GLenum filter);
  void make_multisampled();
  void make_shadow_map();
  void upload(const DrawList& list);
  void draw_shadow_map(const DrawList& list, const View& view);
  void draw_occlusion(const DrawList& list, const View& view);
  void draw_lit(const DrawList& list, const View& view, float brightness, Style style);
  void use_lit_program(const ShaderProgram& program, const View& view, float brightness,
                       Style style);
  void draw_scope(GLuint framebuffer, Style style);
  void fill_screen() const;

  int width_;
  int height_;
  ShaderProgram shadow_program_;
  ShaderProgram geometry_program_;
  ShaderProgram occlusion_program_;
  ShaderProgram occlusion_blur_program_;
  ShaderProgram tissue_program_;
  ShaderProgram tool_program_;
  ShaderProgram smoke_program_;
  ShaderProgram glow_program_;
  ShaderProgram scope_program_;

  GlVertexArray scene_array_;
  GlVertexArray screen_array_;  // core profile draws nothing without one
  GlBuffer vertices_;
  GlBuffer indices_;
  GlBuffer material_buffer_;
  GlTexture material_texture_;
  GlTexture gradient_noise_;
  GlTexture cell_noise_;

  GlTexture shadow_map_;
  GlFramebuffer shadow_framebuffer_;
  Target geometry_;
  GlRenderbuffer geometry_depth_;
  std::array<Target, 2> occlusion_;  // raw, blurred with depth
  GlRenderbuffer multisampled_color_;
  GlRenderbuffer multisampled_depth_;
  GlFramebuffer multisampled_;
  Target resolved_;
  std::array<Target, 2> glow_;  // horizontal, both directions
};

}  // namespace cholecystectomy
