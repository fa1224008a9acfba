// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Keeps surfaces on the GPU and draws them with OpenGL 3.3 into a framebuffer of its host, be that
/// memory or a window.

#include <cstddef>
#include <map>
#include <optional>
#include <span>
#include <vector>

#include "apps/viewer/draw_list.h"
#include "apps/viewer/gl_objects.h"
#include "apps/viewer/pass_timer.h"
#include "apps/viewer/render_quality.h"
#include "apps/viewer/render_snapshot.h"
#include "apps/viewer/render_targets.h"
#include "apps/viewer/shader_program.h"
#include "apps/viewer/surface_buffers.h"
#include "apps/viewer/view.h"

namespace cholecystectomy {

/// Passes: shadow map from the lamp; normals and depth at half size; occlusion and its blur; the
/// scene in linear light; glow; scope. Needs a current context from construction to destruction.
///
/// A surface is drawn as a smooth skin: its triangles are bent to its normals and split. Neighbours
/// agree on their common edge, so that a closed surface shows no hole. In a figure triangles are
/// flat. Surfaces that have to be blended, and the view's sheets, are flat, too, and cost a picture
/// more: they are sorted.
class SceneRenderer {
 public:
  /// @throws pbdsurg::BackendUnavailable  if the driver lacks something that a pass needs
  /// @throws pbdsurg::InvalidArgument  as set_quality()
  SceneRenderer(int width, int height, const RenderQuality& quality = RenderQuality::full());

  /// Of the pictures to come. Surfaces stay.
  void resize(int width, int height);

  /// Surfaces stay.
  /// @throws pbdsurg::InvalidArgument  if samples or subdivision are out of 1..64 and 1..8, or the
  ///         size of the shadow map is out of 0..8192
  void set_quality(const RenderQuality& quality);

  /// Replaces all that it keeps.
  /// @throws pbdsurg::InvalidArgument  if an array of one has the wrong length or a triangle names
  /// a
  ///         vertex that is not there; then it keeps what it had
  void set_surfaces(std::span<const Surface> surfaces);

  /// Changes one. Only runs that are named go to the GPU, and all positions where there are any.
  /// Normals that were given with a surface are replaced by its own once it moves.
  /// @param surface  its place in set_surfaces()
  /// @throws pbdsurg::InvalidArgument  naming surface and element, if there is no such surface, a
  /// run
  ///         leaves a gap, an array has the wrong length or a triangle names a vertex that is not
  ///         there; then nothing has changed
  void update(std::size_t surface, const SurfaceChange& change);

  /// Draws the surfaces as they are.
  /// @param framebuffer  what receives the picture
  /// @param timer  where there is one, gets the passes
  /// @throws pbdsurg::InvalidArgument  if a sheet contradicts itself or the camera is not usable
  void draw(const SceneView& view, GLuint framebuffer, PassTimer* timer = nullptr);

  /// set_surfaces() and draw().
  void draw(const RenderSnapshot& snapshot, GLuint framebuffer);

 private:
  /// The subdivided triangle as the vertex shader reads it.
  struct SkinMesh {
    explicit SkinMesh(int subdivision);
    int subdivision;
    int triangle_count;  ///< in one call
    int indices_per_triangle;
    GlVertexArray array;
    GlBuffer points;
    GlBuffer indices;
  };

  /// What the passes of one picture share.
  struct Frame {
    const SceneView& scene;
    DrawList list;
    View view;
    float haze_density;  ///< 1 / m
    PassTimer* timer;

    void begin(const char* pass) const {
      if (timer != nullptr) {
        timer->begin(pass);
      }
    }
  };

  const SkinMesh& skin_mesh(int subdivision);
  void make_programs();
  void upload(const DrawList& list);
  void draw_list(std::size_t first, std::size_t count) const;
  // @param height  pixels of what is drawn into; 0 for flat triangles
  [[nodiscard]] int subdivision_of(const SurfaceBuffers& surface, const Frame& frame,
                                   int height) const;
  void draw_skin(const ShaderProgram& program, const Frame& frame, int height);
  void draw_mask(const Frame& frame) const;
  void draw_shadow_map(const Frame& frame);
  void draw_occlusion(const Frame& frame);
  void draw_lit(const Frame& frame);
  void use_lit_program(const ShaderProgram& program, const Frame& frame) const;
  void draw_scope(const Frame& frame, GLuint framebuffer);
  void fill_screen() const;

  RenderQuality quality_;
  RenderTargets targets_;
  ShaderProgram shadow_program_, shadow_skin_program_;
  ShaderProgram mask_program_;
  // of the quality
  std::optional<ShaderProgram> geometry_program_, geometry_skin_program_;
  std::optional<ShaderProgram> occlusion_program_, occlusion_blur_program_;
  std::optional<ShaderProgram> skin_program_, tissue_program_, tool_program_, smoke_program_;
  std::optional<ShaderProgram> glow_program_, scope_program_;

  std::vector<SurfaceBuffers> surfaces_;
  // of the picture that is being drawn; kept so that nothing is allocated for each
  std::vector<const SurfaceBuffers*> opaque_;  // nearest first
  std::vector<const Surface*> translucent_;
  std::map<int, SkinMesh> skin_meshes_;  // by subdivision
  GlVertexArray scene_array_;
  GlVertexArray screen_array_;  // core profile draws nothing without one
  GlBuffer vertices_;
  GlBuffer indices_;
  GlBuffer material_buffer_;
  GlTexture material_texture_;
  GlTexture gradient_noise_;
  GlTexture cell_noise_;
};

}  // namespace cholecystectomy
