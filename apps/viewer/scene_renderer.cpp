// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/scene_renderer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <utility>

#include "pbdsurg/base/error.h"

#include "apps/viewer/lattice.h"
#include "apps/viewer/noise_volumes.h"
#include "apps/viewer/shaders.h"

namespace cholecystectomy {
namespace {

constexpr float kGlowThreshold = 1.2f;

/// Radius of the ambient occlusion, relative to the distance from the eye to its target.
constexpr float kOcclusionRadius = 0.13f;

/// What lies behind everything: an unlit cavity, or white paper.
const Eigen::Vector3f kCavity(0.010f, 0.003f, 0.003f);
const Eigen::Vector3f kPaper(1, 1, 1);

/// What smoke in the cavity sends back of the lamp's light: grey-white.
const Eigen::Vector3f kHazeLight(0.50f, 0.49f, 0.475f);

/// Parts of an edge that are shorter on the screen are not worth their cost.
constexpr float kLeastPart = 6;  // pixels

/// A haze that takes everything has no density.
constexpr float kThickestHaze = 0.995f;

// Texture units of a lit program; those of a surface follow.
constexpr int kMaterialUnit = 0, kGradientUnit = 1, kCellUnit = 2, kGeometryUnit = 3,
              kOcclusionUnit = 4, kShadowUnit = 5, kSurfaceUnit = 6;

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
void set(const ShaderProgram& program, const char* name, int value) {
  glUniform1i(program.uniform(name), value);
}

void bind(const ShaderProgram& program, const char* name, int unit, GLenum target,
          const GlTexture& texture) {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(target, texture.name());
  glUniform1i(program.uniform(name), unit);
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

template <class T>
GLsizeiptr byte_count(const std::vector<T>& values) {
  return static_cast<GLsizeiptr>(values.size() * sizeof(T));
}

void check(const char* option, int value, int least, int most) {
  if (value < least || value > most) {
    throw pbdsurg::InvalidArgument("a picture's " + std::string(option) + " is " +
                                   std::to_string(value) + "; it must be in [" +
                                   std::to_string(least) + ", " + std::to_string(most) + ']');
  }
}

const RenderQuality& checked(const RenderQuality& quality) {
  check("number of samples", quality.samples, 1, 64);
  check("subdivision", quality.subdivision, 1, 8);
  check("shadow map", quality.shadow_size, 0, 8192);
  return quality;
}

}  // namespace

SceneRenderer::SkinMesh::SkinMesh(int wanted)
    : subdivision(wanted), indices_per_triangle(3 * wanted * wanted) {
  const Lattice lattice = make_lattice(subdivision);
  triangle_count = lattice.triangle_count;
  glBindVertexArray(array.name());
  glBindBuffer(GL_ARRAY_BUFFER, points.name());
  glBufferData(GL_ARRAY_BUFFER, byte_count(lattice.points), lattice.points.data(), GL_STATIC_DRAW);
  glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, indices.name());
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, byte_count(lattice.indices), lattice.indices.data(),
               GL_STATIC_DRAW);
  glEnableVertexAttribArray(0);
  glVertexAttribIPointer(0, 4, GL_UNSIGNED_SHORT, sizeof lattice.points[0], nullptr);
}

SceneRenderer::SceneRenderer(int width, int height, const RenderQuality& quality)
    : quality_(checked(quality)),
      targets_(width, height, quality, false),
      shadow_program_("shadow", "", kSceneVertexShader, kEmptyFragmentShader),
      shadow_skin_program_("shadow of a surface", "#define DEPTH_ONLY\n", kSkinVertexShader,
                           kEmptyFragmentShader),
      mask_program_("mask", "", kMaskVertexShader, kEmptyFragmentShader) {
  make_programs();
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

void SceneRenderer::make_programs() {
  const auto when = [](bool is_on, const char* name) {
    return is_on ? "#define " + std::string(name) + '\n' : std::string();
  };
  const std::string defines = when(quality_.detail, "DETAIL") +
                              when(quality_.occlusion, "OCCLUSION") +
                              when(quality_.shadow_size > 0, "SHADOWS");
  const std::string functions = kLightingFunctions;
  skin_program_.emplace("skin", defines + "#define SKIN\n", kSkinVertexShader,
                        functions + kTissueFragmentShader);
  tissue_program_.emplace("tissue", defines, kSceneVertexShader, functions + kTissueFragmentShader);
  tool_program_.emplace("tool", defines, kSceneVertexShader, functions + kToolFragmentShader);
  smoke_program_.emplace("smoke", defines, kSceneVertexShader, functions + kSmokeFragmentShader);
  scope_program_.emplace("scope", when(quality_.detail, "DETAIL") + when(quality_.glow, "GLOW"),
                         kScreenVertexShader, kScopeFragmentShader);
  if (quality_.occlusion) {
    geometry_program_.emplace("geometry", "", kSceneVertexShader, kGeometryFragmentShader);
    geometry_skin_program_.emplace("geometry of a surface", "", kSkinVertexShader,
                                   kGeometryFragmentShader);
    occlusion_program_.emplace("occlusion", "", kScreenVertexShader, kOcclusionFragmentShader);
    occlusion_blur_program_.emplace("occlusion blur", "", kScreenVertexShader,
                                    kOcclusionBlurFragmentShader);
  }
  if (quality_.glow) {
    glow_program_.emplace("glow", "", kScreenVertexShader, kGlowFragmentShader);
  }
}

void SceneRenderer::resize(int width, int height) {
  if (width != targets_.width || height != targets_.height) {
    targets_ = RenderTargets(width, height, quality_, targets_.is_exact);
  }
}

void SceneRenderer::set_quality(const RenderQuality& quality) {
  if (quality == quality_) {
    return;
  }
  RenderTargets targets(targets_.width, targets_.height, checked(quality), targets_.is_exact);
  targets_ = std::move(targets);
  quality_ = quality;
  make_programs();
}

void SceneRenderer::set_surfaces(std::span<const Surface> surfaces) {
  std::vector<SurfaceBuffers> kept;
  kept.reserve(surfaces.size());
  for (const Surface& surface : surfaces) {
    kept.emplace_back(surface);
  }
  surfaces_ = std::move(kept);
}

void SceneRenderer::update(std::size_t surface, const SurfaceChange& change) {
  if (surface >= surfaces_.size()) {
    throw pbdsurg::InvalidArgument("there is no surface " + std::to_string(surface) +
                                   "; the renderer keeps " + std::to_string(surfaces_.size()));
  }
  cholecystectomy::check(surfaces_[surface].surface(), change);
  surfaces_[surface].update(change);
}

void SceneRenderer::draw(const RenderSnapshot& snapshot, GLuint framebuffer) {
  set_surfaces(snapshot.surfaces);
  draw(static_cast<const SceneView&>(snapshot), framebuffer);
}

void SceneRenderer::draw(const SceneView& view, GLuint framebuffer, PassTimer* timer) {
  const bool is_exact = view.style == Style::figure;
  if (is_exact != targets_.is_exact) {
    targets_ = RenderTargets(targets_.width, targets_.height, quality_, is_exact);
  }
  const Eigen::Vector3f& eye = view.camera.eye;
  opaque_.clear();
  translucent_.clear();
  float farthest = 0;
  for (SurfaceBuffers& surface : surfaces_) {
    if (surface.is_translucent()) {
      translucent_.push_back(&surface.surface());
    } else if (!surface.box().isEmpty()) {
      surface.prepare();
      opaque_.push_back(&surface);
      const Eigen::AlignedBox3f& box = surface.box();
      const Eigen::Vector3f reach =
          (box.max() - eye).cwiseAbs().cwiseMax((box.min() - eye).cwiseAbs());
      farthest = std::max(farthest, reach.norm());
    }
  }
  // Nearest first, so that hidden tissue fails the depth test before it is shaded. What is all
  // around the eye is behind the rest.
  const auto distance = [&](const SurfaceBuffers* surface) {
    return surface->box().contains(eye) ? std::numeric_limits<float>::infinity()
                                        : surface->box().squaredExteriorDistance(eye);
  };
  std::stable_sort(opaque_.begin(), opaque_.end(),
                   [&](const auto* a, const auto* b) { return distance(a) < distance(b); });
  DrawList list = make_draw_list(view, translucent_);
  const View resolved = make_view(
      view.camera, static_cast<float>(targets_.width) / static_cast<float>(targets_.height),
      std::max(farthest, list.farthest));
  const float haze = view.haze > 0 ? std::min(view.haze, kThickestHaze) : 0;
  const Frame frame{view, std::move(list), resolved,
                    -std::log(1 - haze) / resolved.reference_distance, timer};
  upload(frame.list);
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  if (targets_.shadow) {
    draw_shadow_map(frame);
  }
  if (targets_.occlusion) {
    draw_occlusion(frame);
  }
  draw_lit(frame);
  draw_scope(frame, framebuffer);
  if (timer != nullptr) {
    timer->end();
  }
}

void SceneRenderer::upload(const DrawList& list) {
  glBindVertexArray(scene_array_.name());
  glBindBuffer(GL_ARRAY_BUFFER, vertices_.name());
  glBufferData(GL_ARRAY_BUFFER, byte_count(list.vertices), list.vertices.data(), GL_STREAM_DRAW);
  const std::array all{&list.tissue, &list.tools, &list.blended, &list.smoke};
  GLsizeiptr end = 0;
  for (const auto* indices : all) {
    end += byte_count(*indices);
  }
  glBufferData(GL_ELEMENT_ARRAY_BUFFER, end, nullptr, GL_STREAM_DRAW);
  end = 0;
  for (const auto* indices : all) {
    glBufferSubData(GL_ELEMENT_ARRAY_BUFFER, end, byte_count(*indices), indices->data());
    end += byte_count(*indices);
  }
  glBindBuffer(GL_TEXTURE_BUFFER, material_buffer_.name());
  glBufferData(GL_TEXTURE_BUFFER, byte_count(list.materials), list.materials.data(),
               GL_STREAM_DRAW);
  glBindTexture(GL_TEXTURE_BUFFER, material_texture_.name());
  glTexBuffer(GL_TEXTURE_BUFFER, GL_RGBA32F, material_buffer_.name());
}

void SceneRenderer::draw_list(std::size_t first, std::size_t count) const {
  if (count > 0) {
    glBindVertexArray(scene_array_.name());
    glDrawElements(GL_TRIANGLES, static_cast<GLsizei>(count), GL_UNSIGNED_INT,
                   reinterpret_cast<const void*>(first * sizeof(std::uint32_t)));
  }
}

const SceneRenderer::SkinMesh& SceneRenderer::skin_mesh(int subdivision) {
  return skin_meshes_.try_emplace(subdivision, subdivision).first->second;
}

int SceneRenderer::subdivision_of(const SurfaceBuffers& surface, const Frame& frame,
                                  int height) const {
  if (frame.scene.style == Style::figure) {
    return 1;
  }
  const View& view = frame.view;
  const float away = surface.box().contains(view.eye) ? view.reference_distance
                                                      : surface.box().exteriorDistance(view.eye);
  const float picture = 2 * view.tangent.y() * std::max(away, 0.1f * view.reference_distance);
  const float parts = static_cast<float>(height) * surface.edge_length() / picture / kLeastPart;
  return std::clamp(static_cast<int>(std::min(parts, 8.0f)), 1, quality_.subdivision);
}

void SceneRenderer::draw_skin(const ShaderProgram& program, const Frame& frame, int height) {
  set(program, "figure", frame.scene.style == Style::figure ? 1.0f : 0.0f);
  for (const SurfaceBuffers* surface : opaque_) {
    if (&program == &shadow_skin_program_ && !surface->surface().casts_shadow) {
      continue;
    }
    const SkinMesh& mesh = skin_mesh(subdivision_of(*surface, frame, height));
    set(program, "subdivision", mesh.subdivision);
    surface->bind(program, kSurfaceUnit);
    // The far side of what is closed is hidden by the near one.
    const int side = surface->box().contains(frame.view.eye) ? 0 : surface->closed_side();
    if (side != 0) {
      glEnable(GL_CULL_FACE);
      glCullFace(side > 0 ? GL_BACK : GL_FRONT);
    }
    glBindVertexArray(mesh.array.name());
    const int slot_count = static_cast<int>(surface->surface().triangles.size());
    for (int first = 0; first < slot_count; first += mesh.triangle_count) {
      set(program, "first_slot", first);
      const int count = std::min(mesh.triangle_count, slot_count - first);
      glDrawElements(GL_TRIANGLES, mesh.indices_per_triangle * count, GL_UNSIGNED_SHORT, nullptr);
    }
    glDisable(GL_CULL_FACE);
  }
}

void SceneRenderer::draw_shadow_map(const Frame& frame) {
  frame.begin("shadow");
  targets_.shadow->begin();
  glEnable(GL_DEPTH_TEST);
  glClear(GL_DEPTH_BUFFER_BIT);
  const Eigen::Matrix4f identity = Eigen::Matrix4f::Identity();
  shadow_program_.use();
  set(shadow_program_, "view_of_world", identity);
  set(shadow_program_, "clip_of_view", frame.view.clip_of_world_from_light);
  draw_list(0, frame.list.tissue.size() + frame.list.tools.size());
  shadow_skin_program_.use();
  set(shadow_skin_program_, "view_of_world", identity);
  set(shadow_skin_program_, "clip_of_view", frame.view.clip_of_world_from_light);
  draw_skin(shadow_skin_program_, frame, 0);  // the skin leaves it by less than a shadow's bias
}

void SceneRenderer::draw_occlusion(const Frame& frame) {
  const OcclusionTargets& targets = *targets_.occlusion;
  frame.begin("geometry");
  targets.geometry.begin();
  glEnable(GL_DEPTH_TEST);
  glClearColor(0, 0, 0, 0);  // depth 0: nothing there
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (frame.scene.style != Style::figure) {
    draw_mask(frame);
  }
  for (const ShaderProgram* program : {&*geometry_program_, &*geometry_skin_program_}) {
    program->use();
    set(*program, "view_of_world", frame.view.view_of_world);
    set(*program, "clip_of_view", frame.view.clip_of_view);
    if (program == &*geometry_program_) {
      draw_list(0, frame.list.tissue.size() + frame.list.tools.size());
    } else {
      draw_skin(*program, frame, targets.geometry.height);
    }
  }

  glDisable(GL_DEPTH_TEST);
  frame.begin("occlusion");
  targets.raw.begin();
  occlusion_program_->use();
  bind(*occlusion_program_, "geometry", 0, GL_TEXTURE_2D, targets.geometry.texture);
  set(*occlusion_program_, "tangent", frame.view.tangent);
  set(*occlusion_program_, "radius", kOcclusionRadius * frame.view.reference_distance);
  fill_screen();

  frame.begin("occlusion_blur");
  targets.blurred.begin();
  occlusion_blur_program_->use();
  bind(*occlusion_blur_program_, "occlusion", 0, GL_TEXTURE_2D, targets.raw.texture);
  fill_screen();
}

void SceneRenderer::use_lit_program(const ShaderProgram& program, const Frame& frame) const {
  const View& view = frame.view;
  program.use();
  set(program, "view_of_world", view.view_of_world);
  set(program, "clip_of_view", view.clip_of_view);
  set(program, "clip_of_world_from_light", view.clip_of_world_from_light);
  set(program, "eye", view.eye);
  set(program, "light", view.light);
  set(program, "forward", Eigen::Vector3f(-view.view_of_world.block<1, 3>(2, 0).transpose()));
  set(program, "reference_distance", view.reference_distance);
  set(program, "brightness", frame.scene.camera.brightness);
  set(program, "haze_density", frame.haze_density);
  set(program, "haze_light", Eigen::Vector3f(frame.scene.camera.brightness * kHazeLight));
  set(program, "figure", frame.scene.style == Style::figure ? 1.0f : 0.0f);
  set(program, "picture_size",
      Eigen::Vector2f(static_cast<float>(targets_.width), static_cast<float>(targets_.height)));
  bind(program, "materials", kMaterialUnit, GL_TEXTURE_BUFFER, material_texture_);
  bind(program, "gradient_noise", kGradientUnit, GL_TEXTURE_3D, gradient_noise_);
  bind(program, "cell_noise", kCellUnit, GL_TEXTURE_3D, cell_noise_);
  if (targets_.occlusion) {
    bind(program, "geometry", kGeometryUnit, GL_TEXTURE_2D, targets_.occlusion->geometry.texture);
    bind(program, "occlusion", kOcclusionUnit, GL_TEXTURE_2D, targets_.occlusion->blurred.texture);
  }
  if (targets_.shadow) {
    bind(program, "shadow_map", kShadowUnit, GL_TEXTURE_2D, targets_.shadow->texture);
  }
}

void SceneRenderer::draw_mask(const Frame& frame) const {
  glColorMask(GL_FALSE, GL_FALSE, GL_FALSE, GL_FALSE);
  mask_program_.use();
  set(mask_program_, "aspect", frame.view.tangent.x() / frame.view.tangent.y());
  glBindVertexArray(screen_array_.name());
  glDrawArrays(GL_TRIANGLE_STRIP, 0, kMaskPoints);
  glColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
}

void SceneRenderer::draw_lit(const Frame& frame) {
  frame.begin("lit");
  targets_.begin_lit();
  glEnable(GL_DEPTH_TEST);
  const bool is_figure = frame.scene.style == Style::figure;
  // behind everything the haze is as deep as four times the way to the target
  const float clear = std::exp(-frame.haze_density * 4 * frame.view.reference_distance);
  const Eigen::Vector3f background =
      is_figure ? kPaper
                : Eigen::Vector3f(clear * kCavity +
                                  (1 - clear) * frame.scene.camera.brightness * kHazeLight);
  glClearColor(background.x(), background.y(), background.z(), 1);
  glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
  if (!is_figure) {
    draw_mask(frame);
  }
  const DrawList& list = frame.list;
  const std::size_t tools = list.tissue.size();
  const std::size_t blended = tools + list.tools.size();
  const std::size_t smoke = blended + list.blended.size();
  use_lit_program(*tool_program_, frame);
  draw_list(tools, list.tools.size());
  use_lit_program(*skin_program_, frame);
  draw_skin(*skin_program_, frame, targets_.height);
  use_lit_program(*tissue_program_, frame);
  draw_list(0, list.tissue.size());

  glEnable(GL_BLEND);
  glBlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  glDepthMask(GL_FALSE);
  draw_list(blended, list.blended.size());
  use_lit_program(*smoke_program_, frame);
  draw_list(smoke, list.smoke.size());
  glDepthMask(GL_TRUE);
  glDisable(GL_BLEND);
  frame.begin("resolve");
  targets_.finish_lit();
}

void SceneRenderer::draw_scope(const Frame& frame, GLuint framebuffer) {
  glDisable(GL_DEPTH_TEST);
  const bool is_figure = frame.scene.style == Style::figure;
  if (targets_.glow && !is_figure) {
    frame.begin("glow");
    const auto& [across, both] = *targets_.glow;
    glow_program_->use();
    across.begin();
    bind(*glow_program_, "source", 0, GL_TEXTURE_2D, targets_.resolved.texture);
    set(*glow_program_, "stride", Eigen::Vector2f(1.0f / static_cast<float>(across.width), 0));
    set(*glow_program_, "threshold", kGlowThreshold);
    fill_screen();
    both.begin();
    bind(*glow_program_, "source", 0, GL_TEXTURE_2D, across.texture);
    set(*glow_program_, "stride", Eigen::Vector2f(0, 1.0f / static_cast<float>(across.height)));
    set(*glow_program_, "threshold", 0.0f);
    fill_screen();
  }

  frame.begin("scope");
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer);
  glViewport(0, 0, targets_.width, targets_.height);
  scope_program_->use();
  bind(*scope_program_, "scene", 0, GL_TEXTURE_2D, targets_.resolved.texture);
  if (targets_.glow) {
    bind(*scope_program_, "glow", 1, GL_TEXTURE_2D, (*targets_.glow)[1].texture);
  }
  set(*scope_program_, "aspect", frame.view.tangent.x() / frame.view.tangent.y());
  set(*scope_program_, "tangent", frame.view.tangent.y());
  set(*scope_program_, "figure", is_figure ? 1.0f : 0.0f);
  fill_screen();
}

void SceneRenderer::fill_screen() const {
  glBindVertexArray(screen_array_.name());
  glDrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace cholecystectomy
