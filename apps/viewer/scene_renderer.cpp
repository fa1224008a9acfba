// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scene_renderer.h"

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"

#include "apps/viewer/draw_list.h"
#include "apps/viewer/noise_volumes.h"
#include "apps/viewer/shaders.h"

namespace cholecystectomy {
namespace {

constexpr int kShadowSize = 1024;
constexpr int kSamples = 4;
constexpr int kGlowScale = 4;
constexpr float kGlowThreshold = 1.2f;

/// Radius of the ambient occlusion, relative to the distance from the eye to its target.
constexpr float kOcclusionRadius = 0.13f;

/// What lies behind everything: an unlit cavity, or white paper.
constexpr std::array<float, 4> kCavity{0.010f, 0.003f, 0.003f, 1};
constexpr std::array<float, 4> kPaper{1, 1, 1, 1};

void set(const ShaderProgram& program, const char* name, const Eigen::Matrix4f& value) {
  glUniformMatrix4fv(program.uniform(name), 1, GL_FALSE, value.data());
}
void set(const ShaderProgram& program, const char* name, const Eigen::Vector3f& value) {
  glUniform3fv(program.uniform(name), 1, value.data());
}
void set(const ShaderProgram& program, const char* name, const Eigen::Vector2f& value) {
  glUniform2fv(program.uniform(name), 1, value.data());
}
void set(const ShaderProgram& program, const char* name, float value) {
  glUniform1f(program.uniform(name), value);
}

void bind(const ShaderProgram& program, const char* name, int unit, GLenum target,
          const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.name());
  glUniform1i(program.uniform(name), unit);
}

void check_framebuffer(const char* pass) {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw pbdsurg::BackendUnavailable(std::string("the driver offers no framebuffer for the ") +
                                      pass + " pass");
  }
}

void upload_volume(const GlTexture& texture, const std::vector<std::uint8_t>& texels) {
  glBindTexture(GL_TEXTURE_3D, texture.name());
  glTexImage3D(GL_TEXTURE_3D, 0, GL_RGBA8, kNoiseSize, kNoiseSize, kNoiseSize, 0, GL_RGBA,
               GL_UNSIGNED_BYTE, texels.data());
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR_MIPMAP_NEAREST);
  glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glGenerateMipmap(GL_TEXTURE_3D);
}

void set_float_attribute(GLuint location, GLint count, std::size_t offset) {
  glEnableVertexAttribArray(location);
  glVertexAttribPointer(location, count, GL_FLOAT, GL_FALSE, sizeof(DrawVertex),
                        reinterpret_cast<const void*>(offset));
}

GLsizeiptr byte_count(std::size_t index_count) {
  return static_cast<GLsizeiptr>(index_count * sizeof(std::uint32_t));
}

void draw_indices(std::size_t first, std::size_t count) {
  glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                 reinterpret_cast<const void*>(byte_count(first)));
}

}  // namespace

SceneRenderer::SceneRenderer(int width, int height)
    : width_(width),
      height_(height),
      shadow_program_("shadow", kSceneVertexShader, kEmptyFragmentShader),
      geometry_program_("geometry", kSceneVertexShader, kGeometryFragmentShader),
      occlusion_program_("occlusion", kScreenVertexShader, kOcclusionFragmentShader),
      occlusion_blur_program_("occlusion blur", kScreenVertexShader, kOcclusionBlurFragmentShader),
      tissue_program_("tissue", kSceneVertexShader,
                      std::string(kLightingFunctions) + kTissueFragmentShader),
      tool_program_("tool", kSceneVertexShader,
                    std::string(kLightingFunctions) + kToolFragmentShader),
      smoke_program_("smoke", kSceneVertexShader,
                     std::string(kLightingFunctions) + kSmokeFragmentShader),
      glow_program_("glow", kScreenVertexShader, kGlowFragmentShader),
      scope_program_("scope", kScreenVertexShader, kScopeFragmentShader),
      geometry_(make_color_target((width + 1) / 2, (height + 1) / 2, GL_RGBA32F, GL_NEAREST)),
      occlusion_{make_color_target((width + 1) / 2, (height + 1) / 2, GL_R8, GL_NEAREST),
                 make_color_target((width + 1) / 2, (height + 1) / 2, GL_RG32F, GL_NEAREST)},
      resolved_(make_color_target(width, height, GL_RGBA16F, GL_LINEAR)),
      glow_{make_color_target(width / kGlowScale, height / kGlowScale, GL_RGBA16F, GL_LINEAR),
            make_color_target(width / kGlowScale, height / kGlowScale, GL_RGBA16F, GL_LINEAR)} {
  glBindFramebuffer(GL_FRAMEBUFFER, geometry_.framebuffer.name());
  glBindRenderbuffer(GL_RENDERBUFFER, geometry_depth_.name());
  glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT32F, geometry_.width, geometry_.height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                            geometry_depth_.name());
  check_framebuffer("geometry");
  make_multisampled();
  make_shadow_map();

  upload_volume(gradient_noise_, make_gradient_noise());
  upload_volume(cell_noise_, make_cell_noise());

  glBindVertexArray(scene_array_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices_.name());
  set_float_attribute(0, 3, offsetof(DrawVertex, position));
  set_float_attribute(1, 3, offsetof(DrawVertex, normal));
  set_float_attribute(2, 3, offsetof(DrawVertex, rest));
  set_float_attribute(3, 4, offsetof(DrawVertex, color));
  set_float_attribute(4, 4, offsetof(DrawVertex, burn));
  set_float_attribute(5, 1, offsetof(DrawVertex, wetness));
  glEnableVertexAttribArray(6);
  glVertexAttribIPointer(6, 1, GL_INT, sizeof(DrawVertex),
                         reinterpret_cast<const void*>(offsetof(DrawVertex, material)));
}

SceneRenderer::Target SceneRenderer::make_color_target(int width, int height,
                                                       GLenum internal_format, GLenum filter) {
  Target target{GlTexture(), GlFramebuffer(), std::max(width, 1), std::max(height, 1)};
  glBindTexture(GL_TEXTURE_2D, target.texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), target.width, target.height,
               0, GL_RGBA, GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glBindFramebuffer(GL_FRAMEBUFFER, target.framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, target.texture.name(),
                         0);
  check_framebuffer("colour");
  return target;
}

void SceneRenderer::make_multisampled() {
  GLint most = 1;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  const GLsizei samples = std::min(kSamples, static_cast<int>(most));
  glBindFramebuffer(GL_FRAMEBUFFER, multisampled_.name());
  glBindRenderbuffer(GL_RENDERBUFFER, multisampled_color_.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_RGBA16F, width_, height_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER,
                            multisampled_color_.name());
  glBindRenderbuffer(GL_RENDERBUFFER, multisampled_depth_.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, GL_DEPTH_COMPONENT32F, width_,
                                   height_);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER,
                            multisampled_depth_.name());
  check_framebuffer("multisampled");
}

void SceneRenderer::make_shadow_map() {
  glBindTexture(GL_TEXTURE_2D, shadow_map_.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, kShadowSize, kShadowSize, 0,
               GL_DEPTH_COMPONENT, GL_FLOAT, nullptr);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer_.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, shadow_map_.name(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  check_framebuffer("shadow");
}

void SceneRenderer::draw(const RenderSnapshot& snapshot, GLuint framebuffer) {
  const DrawList list = make_draw_list(snapshot);
  const View view = make_view(
      snapshot.camera, static_cast<float>(width_) / static_cast<float>(height_), list.farthest);
  upload(list);
  draw_shadow_map(list, view);
  draw_occlusion(list, view);
  draw_lit(list, view, snapshot.camera.brightness, snapshot.style);
  draw_scope(framebuffer, snapshot.style);
}

void SceneRenderer::upload(const DrawList& list) {
  glBindVertexArray(scene_array_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  glBufferData(GL_ARRAY_BUFFER, static_cast<GLsizeiptr>(list.vertices.size() * sizeof(DrawVertex)),
               list.vertices.data(), GL_STREAM_DRAW);
  std::size_t count = 0;
  for (const auto* indices : {&list.tissue, &list.tools, &list.blended, &list.smoke}) {
    count += indices->size();
  }
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, byte_count(count), nullptr, GL_STREAM_DRAW);
  count = 0;
  for (const auto* indices : {&list.tissue, &list.tools, &list.blended, &list.smoke}) {
    glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, byte_count(count), byte_count(indices->size()),
                    indices->data());
    count += indices->size();
  }
  glBindBuffer(GL_TEXTURE_BUFFER, material_buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER,
               static_cast<GLsizeiptr>(list.materials.size() * sizeof(DrawMaterial)),
               list.materials.data(), GL_STREAM_DRAW);
  glBindTexture(GL_TEXTURE_BUFFER, material_texture_.name());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, material_buffer_.name());
}

void SceneRenderer::draw_shadow_map(const DrawList& list, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, shadow_framebuffer_.name());
  glViewport(0, 0, kShadowSize, kShadowSize);
  glEnable(GL_DEPTH_TEST);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  glClear(GL_DEPTH_BUFFER_BIT);
  shadow_program_.use();
  set(shadow_program_, "view_of_world", Eigen::Matrix4f(Eigen::Matrix4f::Identity()));
  set(shadow_program_, "clip_of_view", view.clip_of_world_from_light);
  draw_indices(0, list.tissue.size() + list.tools.size());
}

void SceneRenderer::draw_occlusion(const DrawList& list, const View& view) {
  glBindFramebuffer(GL_FRAMEBUFFER, geometry_.framebuffer.name());
  glViewport(0, 0, geometry_.width, geometry_.height);
  glClearColor(0, 0, 0, 0);  // depth 0: nothing there
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  geometry_program_.use();
  set(geometry_program_, "view_of_world", view.view_of_world);
  set(geometry_program_, "clip_of_view", view.clip_of_view);
  draw_indices(0, list.tissue.size() + list.tools.size());

  glDisable(GL_DEPTH_TEST);
  glBindFramebuffer(GL_FRAMEBUFFER, occlusion_[0].framebuffer.name());
  occlusion_program_.use();
  bind(occlusion_program_, "geometry", 0, GL_TEXTURE_2D, geometry_.texture);
  set(occlusion_program_, "tangent", view.tangent);
  set(occlusion_program_, "radius", kOcclusionRadius * view.reference_distance);
  fill_screen();

  glBindFramebuffer(GL_FRAMEBUFFER, occlusion_[1].framebuffer.name());
  occlusion_blur_program_.use();
  bind(occlusion_blur_program_, "geometry", 0, GL_TEXTURE_2D, geometry_.texture);
  bind(occlusion_blur_program_, "occlusion", 1, GL_TEXTURE_2D, occlusion_[0].texture);
  fill_screen();
}

void SceneRenderer::use_lit_program(const ShaderProgram& program, const View& view,
                                    float brightness, Style style) {
  program.use();
  set(program, "view_of_world", view.view_of_world);
  set(program, "clip_of_view", view.clip_of_view);
  set(program, "clip_of_world_from_light", view.clip_of_world_from_light);
  set(program, "eye", view.eye);
  set(program, "light", view.light);
  set(program, "forward", Eigen::Vector3f(-view.view_of_world.block<1, 3>(2, 0).transpose()));
  set(program, "reference_distance", view.reference_distance);
  set(program, "brightness", brightness);
  set(program, "figure", style == Style::figure ? 1.0f : 0.0f);
  set(program, "picture_size",
      Eigen::Vector2f(static_cast<float>(width_), static_cast<float>(height_)));
  bind(program, "materials", 0, GL_TEXTURE_BUFFER, material_texture_);
  bind(program, "gradient_noise", 1, GL_TEXTURE_3D, gradient_noise_);
  bind(program, "cell_noise", 2, GL_TEXTURE_3D, cell_noise_);
  bind(program, "geometry", 3, GL_TEXTURE_2D, geometry_.texture);
  bind(program, "occlusion", 4, GL_TEXTURE_2D, occlusion_[1].texture);
  bind(program, "shadow_map", 5, GL_TEXTURE_2D, shadow_map_);
}

void SceneRenderer::draw_lit(const DrawList& list, const View& view, float brightness,
                             Style style) {
  glBindFramebuffer(GL_FRAMEBUFFER, multisampled_.name());
  glViewport(0, 0, width_, height_);
  glEnable(GL_DEPTH_TEST);
  const auto& background = style == Style::figure ? kPaper : kCavity;
  glClearColor(background[0], background[1], background[2], background[3]);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  glBindVertexArray(scene_array_.name());
  const std::size_t tools = list.tissue.size();
  const std::size_t blended = tools + list.tools.size();
  const std::size_t smoke = blended + list.blended.size();
  use_lit_program(tool_program_, view, brightness, style);
  draw_indices(tools, list.tools.size());
  use_lit_program(tissue_program_, view, brightness, style);
  draw_indices(0, list.tissue.size());

  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  draw_indices(blended, list.blended.size());
  use_lit_program(smoke_program_, view, brightness, style);
  draw_indices(smoke, list.smoke.size());
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);

  glBindFramebuffer(GL_READ_FRAMEBUFFER, multisampled_.name());
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved_.framebuffer.name());
  glBlitFramebuffer(0, 0, width_, height_, 0, 0, width_, height_, GL_COLOR_BUFFER_BIT, GL_NEAREST);
}

void SceneRenderer::draw_scope(GLuint framebuffer, Style style) {
  glDisable(GL_DEPTH_TEST);
  glow_program_.use();
  glViewport(0, 0, glow_[0].width, glow_[0].height);
  const Eigen::Vector2f step(1.0f / static_cast<float>(glow_[0].width),
                             1.0f / static_cast<float>(glow_[0].height));
  glBindFramebuffer(GL_FRAMEBUFFER, glow_[0].framebuffer.name());
  bind(glow_program_, "source", 0, GL_TEXTURE_2D, resolved_.texture);
  set(glow_program_, "stride", Eigen::Vector2f(step.x(), 0));
  set(glow_program_, "threshold", kGlowThreshold);
  fill_screen();
  glBindFramebuffer(GL_FRAMEBUFFER, glow_[1].framebuffer.name());
  bind(glow_program_, "source", 0, GL_TEXTURE_2D, glow_[0].texture);
  set(glow_program_, "stride", Eigen::Vector2f(0, step.y()));
  set(glow_program_, "threshold", 0.0f);
  fill_screen();

  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, width_, height_);
  scope_program_.use();
  bind(scope_program_, "scene", 0, GL_TEXTURE_2D, resolved_.texture);
  bind(scope_program_, "glow", 1, GL_TEXTURE_2D, glow_[1].texture);
  set(scope_program_, "aspect", static_cast<float>(width_) / static_cast<float>(height_));
  set(scope_program_, "figure", style == Style::figure ? 1.0f : 0.0f);
  fill_screen();
}

void SceneRenderer::fill_screen() const {
  glBindVertexArray(screen_array_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace cholecystectomy
