// SPDX-License-Identifier: Apache-2.0
#include "apps/viewer/surface_buffers.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "pbdsurg/base/random.h"

namespace cholecystectomy {
namespace {

// A number for a directed edge; its reverse has the negative one, so that their sum is zero.
std::uint64_t edge_hash(int from, int to) {
  const auto key = [](int low, int high) {
    return pbdsurg::random_bits(1, static_cast<std::uint64_t>(low),
                                static_cast<std::uint64_t>(high));
  };
  return from == to ? 0 : from < to ? key(from, to) : ~key(to, from) + 1;
}

std::uint64_t triangle_hash(const Eigen::Vector4i& slot) {
  return slot.w() == 0 ? 0
                       : edge_hash(slot[0], slot[1]) + edge_hash(slot[1], slot[2]) +
                             edge_hash(slot[2], slot[0]);
}

Eigen::Vector4f padded(const Eigen::Vector3f& point) {
  return point.allFinite() ? Eigen::Vector4f(point.x(), point.y(), point.z(), 1)
                           : Eigen::Vector4f(Eigen::Vector4f::Zero());
}

}  // namespace

void TexelBuffer::reserve(std::size_t count) {
  if (count > capacity_) {
    capacity_ = std::max(count, 2 * capacity_);
    glBindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(capacity_ * bytes_), nullptr,
                 GL_DYNAMIC_DRAW);
    glBindTexture(GL_TEXTURE_BUFFER, texture_.name());
    glTexBuffer(GL_TEXTURE_BUFFER, format_, buffer_.name());
  }
}

void TexelBuffer::replace(const void* texels, std::size_t count) {
  count_ = count;
  if (count == 0) {
    return;
  }
  if (count > capacity_) {
    reserve(count);
  } else {
    glBindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    glBufferData(GL_TEXTURE_BUFFER, static_cast<GLsizeiptr>(capacity_ * bytes_), nullptr,
                 GL_DYNAMIC_DRAW);
  }
  glBufferSubData(GL_TEXTURE_BUFFER, 0, static_cast<GLsizeiptr>(count * bytes_), texels);
}

void TexelBuffer::write(const void* all, std::size_t count, std::size_t first, std::size_t run) {
  if (count > capacity_ || count_ == 0) {
    replace(all, count);
    return;
  }
  count_ = count;
  if (run > 0) {
    glBindBuffer(GL_TEXTURE_BUFFER, buffer_.name());
    glBufferSubData(GL_TEXTURE_BUFFER, static_cast<GLintptr>(first * bytes_),
                    static_cast<GLsizeiptr>(run * bytes_),
                    static_cast<const char*>(all) + first * bytes_);
  }
}

void TexelBuffer::bind(const ShaderProgram& program, const char* name, int unit) const {
  glActiveTexture(GL_TEXTURE0 + static_cast<GLenum>(unit));
  glBindTexture(GL_TEXTURE_BUFFER, texture_.name());
  glUniform1i(program.uniform(name), unit);
}

SurfaceBuffers::SurfaceBuffers(const Surface& surface)
    : surface_(surface),
      skin_look_(material_of(surface.look)),
      inner_look_(material_of(surface.inner_look)) {
  check(surface_);
  is_translucent_ = cholecystectomy::is_translucent(surface_);
  const std::size_t count = surface_.positions.size();
  send_positions();
  send_slots(0, surface_.triangles.size());
  send_rest(0, count);
  send_burns(0, count);
  send_colors(0, count);
}

void SurfaceBuffers::update(const SurfaceChange& change) {
  const std::size_t before = surface_.positions.size();
  const std::size_t burns_before = surface_.burn.size();
  apply(change, surface_);
  const std::size_t count = surface_.positions.size();
  if (!change.positions.empty()) {
    send_positions();
    has_stale_normals_ = true;
    has_stale_shape_ |= surface_.rest_positions.empty();
  }
  for (const SurfaceChange::Triangles& run : change.triangles) {
    send_slots(static_cast<std::size_t>(run.first), run.values.size());
    has_stale_normals_ = has_stale_shape_ = true;
  }
  if (count > before) {
    has_stale_shape_ = true;
    send_rest(before, count - before);
    send_colors(before, count - before);
  }
  if (surface_.burn.size() > burns_before) {
    send_burns(burns_before, surface_.burn.size() - burns_before);
  }
  for (const SurfaceChange::Burns& run : change.burns) {
    send_burns(static_cast<std::size_t>(run.first), run.values.size());
  }
  if (!change.triangles.empty() || count > before) {
    is_translucent_ = cholecystectomy::is_translucent(surface_);
  }
}

void SurfaceBuffers::send_positions() {
  const std::size_t count = surface_.positions.size();
  sent_positions_.resize(count);
  box_.setEmpty();
  has_broken_vertices_ = false;
  for (std::size_t v = 0; v < count; ++v) {
    sent_positions_[v] = padded(surface_.positions[v]);
    if (sent_positions_[v].w() != 0) {
      box_.extend(surface_.positions[v]);
    } else {
      has_broken_vertices_ = true;
    }
  }
  positions_.replace(sent_positions_.data(), count);
}

void SurfaceBuffers::send_slots(std::size_t first, std::size_t count) {
  sent_slots_.resize(surface_.triangles.size(), Eigen::Vector4i::Zero());
  for (std::size_t t = first; t < first + count; ++t) {
    const auto& [a, b, c] = surface_.triangles[t];
    const bool is_inner = !surface_.is_inner.empty() && surface_.is_inner[t] != 0;
    const int kind = a == b || b == c || c == a ? 0 : is_inner ? 2 : 1;
    open_edges_ -= triangle_hash(sent_slots_[t]);
    sent_slots_[t] = {a, b, c, kind};
    open_edges_ += triangle_hash(sent_slots_[t]);
  }
  slots_.write(sent_slots_.data(), sent_slots_.size(), first, count);
}

void SurfaceBuffers::send_rest(std::size_t first, std::size_t count) {
  if (surface_.rest_positions.empty()) {
    return;  // the shader reads positions instead
  }
  sent_rest_.resize(surface_.rest_positions.size());
  for (std::size_t v = first; v < first + count; ++v) {
    sent_rest_[v] = padded(surface_.rest_positions[v]);
  }
  rest_.write(sent_rest_.data(), sent_rest_.size(), first, count);
}

void SurfaceBuffers::send_burns(std::size_t first, std::size_t count) {
  if (surface_.burn.empty()) {
    return;
  }
  sent_burns_.resize(surface_.burn.size());
  for (std::size_t v = first; v < first + count; ++v) {
    sent_burns_[v] = burn_at(surface_, v);
  }
  burns_.write(sent_burns_.data(), sent_burns_.size(), first, count);
}

void SurfaceBuffers::send_colors(std::size_t first, std::size_t count) {
  if (!surface_.colors.empty()) {
    sent_colors_.resize(surface_.colors.size());
    for (std::size_t v = first; v < first + count; ++v) {
      sent_colors_[v] = color_at(surface_, v);
    }
    colors_.write(sent_colors_.data(), sent_colors_.size(), first, count);
  }
  if (!surface_.wetness.empty()) {
    for (std::size_t v = first; v < first + count; ++v) {
      surface_.wetness[v] = wetness_at(surface_, v);
    }
    wetness_.write(surface_.wetness.data(), surface_.wetness.size(), first, count);
  }
}

int SurfaceBuffers::closed_side() const {
  if (open_edges_ != 0 || has_broken_vertices_ || !surface_.normals.empty()) {
    return 0;
  }
  return volume_ > 0 ? 1 : volume_ < 0 ? -1 : 0;
}

void SurfaceBuffers::prepare() {
  if (has_stale_shape_) {
    measure_shape();
    has_stale_shape_ = false;
  }
  if (has_stale_normals_) {
    compute_normals();
    normals_.replace(sent_normals_.data(), sent_normals_.size());
    has_stale_normals_ = false;
  }
}

void SurfaceBuffers::measure_shape() {
  const std::size_t count = surface_.positions.size();
  const std::vector<Eigen::Vector3f>& places =
      surface_.rest_positions.empty() ? surface_.positions : surface_.rest_positions;
  const auto place = [&](int v) { return places[static_cast<std::size_t>(v)]; };
  inner_share_.assign(count, 0);
  std::vector<float> triangle_counts(count, 0);
  double area = 0, edges = 0;
  for (const Eigen::Vector4i& slot : sent_slots_) {
    if (slot.w() == 0) {
      continue;
    }
    for (int i = 0; i < 3; ++i) {
      const auto v = static_cast<std::size_t>(slot[i]);
      triangle_counts[v] += 1;
      inner_share_[v] += slot.w() == 2 ? 1.0f : 0.0f;
    }
    const float doubled =
        (place(slot[1]) - place(slot[0])).cross(place(slot[2]) - place(slot[0])).norm();
    if (std::isfinite(doubled)) {
      area += doubled;
      edges += doubled * std::sqrt(doubled);
    }
  }
  for (std::size_t v = 0; v < count; ++v) {
    inner_share_[v] /= std::max(triangle_counts[v], 1.0f);
  }
  // twice the area of a triangle with equal edges is 0.866 of an edge's square
  edge_length_ = area > 0 ? static_cast<float>(edges / area / std::sqrt(0.866)) : 0;
}

// This is most of what a picture of moving tissue costs on the CPU: one product a triangle.
void SurfaceBuffers::compute_normals() {
  const std::size_t count = surface_.positions.size();
  sent_normals_.assign(count, Eigen::Vector4f::Zero());
  const Eigen::Vector4f middle =
      box_.isEmpty() ? Eigen::Vector4f(Eigen::Vector4f::Zero()) : padded(box_.center());
  Eigen::Vector4d volume = Eigen::Vector4d::Zero();  // in parts
  for (const Eigen::Vector4i& slot : sent_slots_) {
    if (slot.w() == 0) {
      continue;
    }
    const Eigen::Vector4f& a = sent_positions_[static_cast<std::size_t>(slot[0])];
    const Eigen::Vector4f& b = sent_positions_[static_cast<std::size_t>(slot[1])];
    const Eigen::Vector4f& c = sent_positions_[static_cast<std::size_t>(slot[2])];
    if (has_broken_vertices_ && a.w() * b.w() * c.w() == 0) {
      continue;
    }
    const Eigen::Vector4f normal = (b - a).cross3(c - a);  // twice its area long
    volume += (a - middle).cwiseProduct(normal).cast<double>();
    for (int i = 0; i < 3; ++i) {
      sent_normals_[static_cast<std::size_t>(slot[i])] += normal;
    }
  }
  volume_ = volume.head<3>().sum();
  for (std::size_t v = 0; v < count; ++v) {
    Eigen::Vector4f& sent = sent_normals_[v];
    if (!surface_.normals.empty()) {
      sent.head<3>() = surface_.normals[v];
    }
    const float squared = sent.head<3>().squaredNorm();
    if (squared > 1e-36f && std::isfinite(squared)) {
      sent /= std::sqrt(squared);
    } else {  // not finite, or too small for its direction to be known
      sent.setZero();
    }
    sent.w() = inner_share_[v];
  }
}

void SurfaceBuffers::bind(const ShaderProgram& program, int unit) const {
  const auto set_flag = [&](const char* name, bool value) {
    glUniform1i(program.uniform(name), value ? 1 : 0);
  };
  positions_.bind(program, "positions", unit);
  normals_.bind(program, "normals", unit + 1);
  slots_.bind(program, "slots", unit + 2);
  (rest_.is_empty() ? positions_ : rest_).bind(program, "rest_positions", unit + 3);
  burns_.bind(program, "burns", unit + 4);
  colors_.bind(program, "colors", unit + 5);
  wetness_.bind(program, "wetnesses", unit + 6);
  set_flag("has_burns", !burns_.is_empty());
  set_flag("has_colors", !colors_.is_empty());
  set_flag("has_wetness", !wetness_.is_empty());
  glUniform4fv(program.uniform("skin_look"), 4, skin_look_.color.data());
  glUniform4fv(program.uniform("inner_look"), 4, inner_look_.color.data());
}

}  // namespace cholecystectomy
