// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/offscreen_renderer.h"

#include <algorithm>
#include <cstddef>

#include <epoxy/gl.h>

#include "pbdsurg/base/error.h"

#include "apps/viewer/egl_context.h"
#include "apps/viewer/gl_objects.h"
#include "apps/viewer/scene_renderer.h"

namespace cholecystectomy {
namespace {

const OffscreenOptions& checked(const OffscreenOptions& options) {
  for (const int side : {options.width, options.height}) {
    if (side < 16 || side > 8192) {
      throw pbdsurg::InvalidArgument("a picture of " + std::to_string(options.width) + " x " +
                                     std::to_string(options.height) +
                                     " pixels was asked for; each side must be in [16, 8192]");
    }
  }
  return options;
}

}  // namespace

struct OffscreenRenderer::Impl {
  explicit Impl(const OffscreenOptions& wanted)
      : options(checked(wanted)), scene(wanted.width, wanted.height, wanted.quality) {
    const GLubyte* device = glGetString(GL_RENDERER);
    device_name = device != nullptr ? reinterpret_cast<const char*>(device) : "unknown";
    glBindRenderbuffer(GL_RENDERBUFFER, pixels.name());
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, options.width, options.height);
    glBindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, pixels.name());
  }

  OffscreenOptions options;
  EglContext context;  // before all that lives in it
  SceneRenderer scene;
  GlRenderbuffer pixels;
  GlFramebuffer framebuffer;
  std::string device_name;
};

OffscreenRenderer::OffscreenRenderer(const OffscreenOptions& options)
    : impl_(std::make_unique<Impl>(options)) {}

OffscreenRenderer::~OffscreenRenderer() {
  if (impl_ != nullptr) {
    impl_->context.make_current();  // OpenGL objects are deleted in the current context
  }
}

OffscreenRenderer::OffscreenRenderer(OffscreenRenderer&&) noexcept = default;

OffscreenRenderer& OffscreenRenderer::operator=(OffscreenRenderer&& other) noexcept {
  std::swap(impl_, other.impl_);
  return *this;
}

void OffscreenRenderer::set_surfaces(std::span<const Surface> surfaces) {
  impl_->context.make_current();
  impl_->scene.set_surfaces(surfaces);
}

void OffscreenRenderer::update(std::size_t surface, const SurfaceChange& change) {
  impl_->context.make_current();
  impl_->scene.update(surface, change);
}

void OffscreenRenderer::draw(const SceneView& view) {
  start(view);
  finish();
}

void OffscreenRenderer::start(const SceneView& view) {
  impl_->context.make_current();
  impl_->scene.draw(view, impl_->framebuffer.name());
  glFlush();
}

void OffscreenRenderer::finish() {
  impl_->context.make_current();
  glFinish();
}

std::vector<PassTime> OffscreenRenderer::time_passes(const SceneView& view) {
  impl_->context.make_current();
  PassTimer timer;
  impl_->scene.draw(view, impl_->framebuffer.name(), &timer);
  return timer.take();
}

Image OffscreenRenderer::render(const RenderSnapshot& snapshot) {
  set_surfaces(snapshot.surfaces);
  return render(static_cast<const SceneView&>(snapshot));
}

Image OffscreenRenderer::render(const SceneView& view) {
  impl_->context.make_current();
  impl_->scene.draw(view, impl_->framebuffer.name());

  Image image;
  image.width = impl_->options.width;
  image.height = impl_->options.height;
  const std::size_t row = 3 * static_cast<std::size_t>(image.width);
  image.rgb.resize(row * static_cast<std::size_t>(image.height));
  glBindFramebuffer(GL_READ_FRAMEBUFFER, impl_->framebuffer.name());
  glPixelStorei(GL_PACK_ALIGNMENT, 1);
  glReadPixels(0, 0, image.width, image.height, GL_RGB, GL_UNSIGNED_BYTE, image.rgb.data());
  if (glGetError() != GL_NO_ERROR) {
    throw pbdsurg::BackendUnavailable("the OpenGL driver reported an error while drawing on " +
                                      impl_->device_name);
  }
  // OpenGL counts rows from below
  const auto line = [&](int y) { return image.rgb.begin() + static_cast<std::ptrdiff_t>(row) * y; };
  for (int y = 0; y < image.height / 2; ++y) {
    std::swap_ranges(line(y), line(y + 1), line(image.height - 1 - y));
  }
  return image;
}

const std::string& OffscreenRenderer::device_name() const {
  return impl_->device_name;
}

}  // namespace cholecystectomy
