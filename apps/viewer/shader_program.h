// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A linked pair of vertex and fragment shaders.

#include <string>

#include <epoxy/gl.h>

namespace cholecystectomy {

/// Owns one program; moves, never copies.
class ShaderProgram {
 public:
  /// @param defines  lines of GLSL before both sources
  /// @throws pbdsurg::BackendUnavailable  with the driver's log if it does not compile or link
  ShaderProgram(const std::string& name, const std::string& defines, const std::string& vertex,
                const std::string& fragment);
  ~ShaderProgram();
  ShaderProgram(ShaderProgram&& other) noexcept;
  ShaderProgram& operator=(ShaderProgram&& other) noexcept;

  void use() const { glUseProgram(program_); }
  [[nodiscard]] GLuint name() const { return program_; }

  /// Location of a uniform, -1 (which OpenGL ignores) where the compiler removed it.
  [[nodiscard]] GLint uniform(const char* uniform_name) const {
    return glGetUniformLocation(program_, uniform_name);
  }

 private:
  GLuint program_ = 0;
};

}  // namespace cholecystectomy
