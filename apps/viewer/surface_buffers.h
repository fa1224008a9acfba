// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A surface that stays on the GPU.

#include <Eigen/Geometry>
#include <cstdint>
#include <vector>

#include "apps/viewer/gl_objects.h"
#include "apps/viewer/shader_program.h"
#include "apps/viewer/surface_data.h"

namespace cholecystectomy {

/// A buffer of texels that a vertex shader fetches; grows by doubling.
class TexelBuffer {
 public:
  /// @param format       of a texel, as glTexBuffer() takes it
  /// @param texel_bytes  of one
  TexelBuffer(GLenum format, std::size_t texel_bytes) : format_(format), bytes_(texel_bytes) {}

  /// Replaces everything. The driver need not wait for pictures that still use what was there.
  void replace(const void* texels, std::size_t count);
  /// Replaces a run; what is beyond the end is new.
  /// @param all  all texels as they will be, for when the buffer has to grow
  void write(const void* all, std::size_t count, std::size_t first, std::size_t run);
  void bind(const ShaderProgram& program, const char* name, int unit) const;
  [[nodiscard]] bool is_empty() const { return count_ == 0; }

 private:
  void reserve(std::size_t count);

  GLenum format_;
  std::size_t bytes_;
  std::size_t count_ = 0;     // texels
  std::size_t capacity_ = 0;  // texels
  GlBuffer buffer_;
  GlTexture texture_;
};

/// What the shaders of the skin read of one surface, and the surface itself. A change sends what
/// changed; nothing is sent or made for a picture.
class SurfaceBuffers {
 public:
  /// @throws pbdsurg::InvalidArgument  as check(Surface)
  explicit SurfaceBuffers(const Surface& surface);

  /// @param change  that check() lets pass
  void update(const SurfaceChange& change);

  [[nodiscard]] const Surface& surface() const { return surface_; }

  /// Whether anything of it has to be blended, in an order that only the CPU knows.
  [[nodiscard]] bool is_translucent() const { return is_translucent_; }

  /// Of the vertices that are finite.
  [[nodiscard]] const Eigen::AlignedBox3f& box() const { return box_; }

  /// Positive where triangles close around a volume with their fronts outside, negative with their
  /// backs, zero where they do not close. From outside of the box then only one side is seen.
  [[nodiscard]] int closed_side() const;

  /// Mean length at rest of its triangles' edges, the more of a triangle the larger it is. m, after
  /// prepare()
  [[nodiscard]] float edge_length() const { return edge_length_; }

  /// Computes normals where something changed since the last call.
  void prepare();

  /// Binds texel buffers to units from `unit` on, and sets what goes with them.
  void bind(const ShaderProgram& program, int unit) const;

 private:
  void send_positions();
  void send_slots(std::size_t first, std::size_t count);
  void send_burns(std::size_t first, std::size_t count);
  void send_rest(std::size_t first, std::size_t count);
  void send_colors(std::size_t first, std::size_t count);
  void measure_shape();  // what changes with triangles alone
  void compute_normals();

  Surface surface_;
  DrawMaterial skin_look_, inner_look_;
  bool is_translucent_;
  bool has_stale_normals_ = true, has_stale_shape_ = true;
  bool has_broken_vertices_ = false;
  std::uint64_t open_edges_ = 0;  // zero where each edge has its reverse
  double volume_ = 0;             // m^3, where closed
  float edge_length_ = 0;
  Eigen::AlignedBox3f box_;

  TexelBuffer positions_{GL_RGBA32F, 16};  // xyz, 1 where finite
  TexelBuffer normals_{GL_RGBA32F, 16};    // xyz, zero where unknown; share of triangles inside
  TexelBuffer rest_{GL_RGBA32F, 16};       // as positions
  TexelBuffer burns_{GL_RGBA32F, 16};
  TexelBuffer colors_{GL_RGBA32F, 16};
  TexelBuffer wetness_{GL_R32F, 4};
  TexelBuffer slots_{GL_RGBA32I, 16};  // corners; 1 for skin, 2 for inner, 0 for not drawn

  // as on the GPU; kept so that nothing is allocated for a change of the same size
  std::vector<Eigen::Vector4f> sent_positions_, sent_normals_, sent_rest_, sent_burns_,
      sent_colors_;
  std::vector<Eigen::Vector4i> sent_slots_;
  std::vector<float> inner_share_;
};

}  // namespace cholecystectomy
