// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/shader_program.h"

#include <array>
#include <utility>

#include "pbdsurg/base/error.h"

namespace cholecystectomy {
namespace {

/// A shader, deleted once its program is linked.
class Shader {
 public:
  Shader(GLenum stage, const std::string& program, const std::string& source)
      : shader_(glCreateShader(stage)) {
    const char* text = source.c_str();
    glShaderSource(shader_, 1, &text, nullptr);
    glCompileShader(shader_);
    GLint compiled = GL_FALSE;
    glGetShaderiv(shader_, GL_COMPILE_STATUS, &compiled);
    if (compiled != GL_TRUE) {
      std::array<char, 2048> log{};
      glGetShaderInfoLog(shader_, static_cast<GLsizei>(log.size()), nullptr, log.data());
      glDeleteShader(shader_);
      throw pbdsurg::BackendUnavailable("the driver refuses the shader '" + program +
                                        "': " + log.data());
    }
  }
  ~Shader() { glDeleteShader(shader_); }
  Shader(const Shader&) = delete;
  Shader& operator=(const Shader&) = delete;

  [[nodiscard]] GLuint name() const { return shader_; }

 private:
  GLuint shader_;
};

}  // namespace

ShaderProgram::ShaderProgram(const std::string& name, const std::string& defines,
                             const std::string& vertex, const std::string& fragment) {
  const std::string head = "#version 330 core\n" + defines;
  const Shader vertex_shader(GL_VERTEX_SHADER, name, head + vertex);
  const Shader fragment_shader(GL_FRAGMENT_SHADER, name, head + fragment);
  program_ = glCreateProgram();
  glAttachShader(program_, vertex_shader.name());
  glAttachShader(program_, fragment_shader.name());
  glLinkProgram(program_);
  glDetachShader(program_, vertex_shader.name());
  glDetachShader(program_, fragment_shader.name());
  GLint linked = GL_FALSE;
  glGetProgramiv(program_, GL_LINK_STATUS, &linked);
  if (linked != GL_TRUE) {
    std::array<char, 2048> log{};
    glGetProgramInfoLog(program_, static_cast<GLsizei>(log.size()), nullptr, log.data());
    glDeleteProgram(program_);
    throw pbdsurg::BackendUnavailable("the driver cannot link the shader '" + name +
                                      "': " + log.data());
  }
}

ShaderProgram::~ShaderProgram() {
  if (program_ != 0) {
    glDeleteProgram(program_);
  }
}

ShaderProgram::ShaderProgram(ShaderProgram&& other) noexcept
    : program_(std::exchange(other.program_, 0)) {}

ShaderProgram& ShaderProgram::operator=(ShaderProgram&& other) noexcept {
  std::swap(program_, other.program_);
  return *this;
}

}  // namespace cholecystectomy
