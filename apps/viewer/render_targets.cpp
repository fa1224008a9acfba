// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/render_targets.h"

#include <algorithm>
#include <string>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

constexpr int kGlowScale = 4;

void check_framebuffer(const char* pass) {
  if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw pbdsurg::BackendUnavailable(std::string("the driver offers no framebuffer for the ") +
                                      pass + " pass");
  }
}

void set_sampling(GLenum filter) {
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MIN_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_MAG_FILTER, static_cast<GLint>(filter));
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
}

GLenum lit_format(bool is_exact) {
  return is_exact ? GL_RGBA16F : GL_R11F_G11F_B10F;
}

/// To the framebuffer that is bound.
void attach(GLenum attachment, const GlRenderbuffer& buffer, GLenum format, int samples, int width,
            int height) {
  glBindRenderbuffer(GL_RENDERBUFFER, buffer.name());
  glRenderbufferStorageMultisample(GL_RENDERBUFFER, samples, format, width, height);
  glFramebufferRenderbuffer(GL_FRAMEBUFFER, attachment, GL_RENDERBUFFER, buffer.name());
}

}  // namespace

ColorTarget::ColorTarget(int wanted_width, int wanted_height, GLenum internal_format, GLenum filter)
    : width(std::max(wanted_width, 1)), height(std::max(wanted_height, 1)) {
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, static_cast<GLint>(internal_format), width, height, 0, GL_RGBA,
               GL_FLOAT, nullptr);
  set_sampling(filter);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D, texture.name(), 0);
  check_framebuffer("colour");
}

void ColorTarget::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glViewport(0, 0, width, height);
}

ShadowTarget::ShadowTarget(int wanted_size) : size(wanted_size) {
  glBindTexture(GL_TEXTURE_2D, texture.name());
  glTexImage2D(GL_TEXTURE_2D, 0, GL_DEPTH_COMPONENT32F, size, size, 0, GL_DEPTH_COMPONENT, GL_FLOAT,
               nullptr);
  set_sampling(GL_LINEAR);
  glTexParameteri(GL_TEXTURE_2D, GL_TEXTURE_COMPARE_MODE, GL_COMPARE_REF_TO_TEXTURE);
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glFramebufferTexture2D(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_TEXTURE_2D, texture.name(), 0);
  glDrawBuffer(GL_NONE);
  glReadBuffer(GL_NONE);
  check_framebuffer("shadow");
}

void ShadowTarget::begin() const {
  glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
  glViewport(0, 0, size, size);
}

OcclusionTargets::OcclusionTargets(int width, int height)
    : geometry(width, height, GL_RGBA16F, GL_NEAREST),
      raw(width, height, GL_RG16F, GL_NEAREST),
      blurred(width, height, GL_RG16F, GL_NEAREST) {
  glBindFramebuffer(GL_FRAMEBUFFER, geometry.framebuffer.name());
  attach(GL_DEPTH_ATTACHMENT, depth, GL_DEPTH_COMPONENT32F, 0, width, height);
  check_framebuffer("geometry");
}

RenderTargets::RenderTargets(int wanted_width, int wanted_height, const RenderQuality& quality,
                             bool wanted_exact)
    : width(wanted_width),
      height(wanted_height),
      is_exact(wanted_exact),
      resolved(width, height, lit_format(is_exact), GL_LINEAR) {
  GLint most = 1;
  glGetIntegerv(GL_MAX_SAMPLES, &most);
  const int samples = std::min(quality.samples, static_cast<int>(most));
  if (samples > 1) {
    multisampled_color.emplace();
    multisampled.emplace();
    glBindFramebuffer(GL_FRAMEBUFFER, multisampled->name());
    attach(GL_COLOR_ATTACHMENT0, *multisampled_color, lit_format(is_exact), samples, width, height);
  } else {
    glBindFramebuffer(GL_FRAMEBUFFER, resolved.framebuffer.name());
  }
  attach(GL_DEPTH_ATTACHMENT, depth, GL_DEPTH_COMPONENT24, samples > 1 ? samples : 0, width,
         height);
  check_framebuffer("lit");
  if (quality.shadow_size > 0) {
    shadow.emplace(quality.shadow_size);
  }
  if (quality.occlusion) {
    occlusion.emplace((width + 1) / 2, (height + 1) / 2);
  }
  if (quality.glow) {
    const auto make = [&] {
      return ColorTarget(width / kGlowScale, height / kGlowScale, GL_RGBA16F, GL_LINEAR);
    };
    glow.emplace(std::array<ColorTarget, 2>{make(), make()});
  }
}

void RenderTargets::begin_lit() const {
  glBindFramebuffer(GL_FRAMEBUFFER,
                    multisampled ? multisampled->name() : resolved.framebuffer.name());
  glViewport(0, 0, width, height);
}

void RenderTargets::finish_lit() const {
  if (multisampled) {
    glBindFramebuffer(GL_READ_FRAMEBUFFER, multisampled->name());
    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, resolved.framebuffer.name());
    glBlitFramebuffer(0, 0, width, height, 0, 0, width, height, GL_COLOR_BUFFER_BIT, GL_NEAREST);
  }
}

}  // namespace cholecystectomy
