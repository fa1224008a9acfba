// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// OpenGL names that delete themselves. The context that made them must be current.

#include <utility>

#include <epoxy/gl.h>

namespace cholecystectomy {

/// Owns one OpenGL name; moves, never copies.
template <class Kind>
class GlObject {
 public:
  GlObject() { Kind::create(&name_); }
  ~GlObject() {
    if (name_ != 0) {
      Kind::destroy(&name_);
    }
  }
  GlObject(GlObject&& other) noexcept : name_(std::exchange(other.name_, 0)) {}
  GlObject& operator=(GlObject&& other) noexcept {
    std::swap(name_, other.name_);
    return *this;
  }

  [[nodiscard]] GLuint name() const { return name_; }

 private:
  GLuint name_ = 0;
};

// The functions of libepoxy are macros over pointers, so they cannot be template arguments.
struct GlTextureKind {
  static void create(GLuint* name) { glGenTextures(1, name); }
  static void destroy(const GLuint* name) { glDeleteTextures(1, name); }
};
struct GlBufferKind {
  static void create(GLuint* name) { glGenBuffers(1, name); }
  static void destroy(const GLuint* name) { glDeleteBuffers(1, name); }
};
struct GlVertexArrayKind {
  static void create(GLuint* name) { glGenVertexArrays(1, name); }
  static void destroy(const GLuint* name) { glDeleteVertexArrays(1, name); }
};
struct GlFramebufferKind {
  static void create(GLuint* name) { glGenFramebuffers(1, name); }
  static void destroy(const GLuint* name) { glDeleteFramebuffers(1, name); }
};
struct GlRenderbufferKind {
  static void create(GLuint* name) { glGenRenderbuffers(1, name); }
  static void destroy(const GLuint* name) { glDeleteRenderbuffers(1, name); }
};
struct GlQueryKind {
  static void create(GLuint* name) { glGenQueries(1, name); }
  static void destroy(const GLuint* name) { glDeleteQueries(1, name); }
};

using GlTexture = GlObject<GlTextureKind>;
using GlBuffer = GlObject<GlBufferKind>;
using GlVertexArray = GlObject<GlVertexArrayKind>;
using GlFramebuffer = GlObject<GlFramebufferKind>;
using GlRenderbuffer = GlObject<GlRenderbufferKind>;
using GlQuery = GlObject<GlQueryKind>;

}  // namespace cholecystectomy
