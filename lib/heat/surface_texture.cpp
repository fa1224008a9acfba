// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/heat/surface_texture.h"

#include <algorithm>
#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {
namespace {

// Linear between the corners of a triangle.
struct Plane {
  float a, along_b, along_c;

  Plane(float at_a, float at_b, float at_c) : a(at_a), along_b(at_b - at_a), along_c(at_c - at_a) {}
  [[nodiscard]] float at(float u, float v) const { return a + u * along_b + v * along_c; }
  [[nodiscard]] std::uint8_t byte_at(float u, float v) const {
    return static_cast<std::uint8_t>(std::clamp(at(u, v), 0.0F, 255.0F) + 0.5F);
  }
};

}  // namespace

SurfaceTexture::SurfaceTexture(Index texels) : texels_(texels) {
  if (texels < 2 || texels > 64) {
    throw InvalidArgument("a tile has " + std::to_string(texels) +
                          " texels along an edge; it must be in [2, 64]");
  }
}

void SurfaceTexture::update(const LiveSurface& surface, const SurfaceMap& map) {
  if (triangles_.empty()) {  // as at first, or moved from
    seen_surface_ = seen_map_ = 0;
  }
  surface.collect_changes(seen_surface_, ranges_);
  for (const auto [first, end] : ranges_) {
    for (Index slot = first; slot < end; ++slot) {
      for (const Index v : surface.triangles()[slot]) {
        if (static_cast<std::size_t>(v) >= map.temperatures().size()) {
          throw InvalidArgument("vertex " + std::to_string(v) + " of slot " + std::to_string(slot) +
                                " is not in the map; update it first");
        }
      }
    }
  }
  first_corners_.resize(std::max(first_corners_.size(), map.temperatures().size()), kInvalidIndex);
  follow(surface);
  map.collect_changes(seen_map_, ranges_, 1);
  seen_map_ = map.version();
  for (const auto [first, end] : ranges_) {
    for (Index v = first; v < end; ++v) {
      for (Index corner = first_corners_[v]; corner != kInvalidIndex;
           corner = next_corners_[corner]) {
        mark(corner / 3);
      }
    }
  }
  for (const Index slot : stale_) {
    is_stale_[slot] = 0;
    draw(slot, map);
    changes_.note(slot);
  }
  stale_.clear();
}

// Follows the slots in ranges_, and their number.
void SurfaceTexture::follow(const LiveSurface& surface) {
  const Index slot_count = surface.slot_count();
  for (auto slot = static_cast<Index>(triangles_.size()) - 1; slot >= slot_count; --slot) {
    unlink(slot);
  }
  const auto slots = static_cast<std::size_t>(slot_count);
  const std::size_t texel_count = slots * static_cast<std::size_t>(texels_ * texels_);
  triangles_.resize(slots, LiveSurface::kEmptyTriangle);
  next_corners_.resize(3 * slots, kInvalidIndex);
  is_stale_.resize(slots);
  temperatures_.resize(texel_count);
  marks_.resize(texel_count);
  changes_.reserve(slot_count);
  for (const auto [first, end] : ranges_) {
    for (Index slot = first; slot < end; ++slot) {
      const Triangle& triangle = surface.triangles()[slot];
      if (triangle != triangles_[slot]) {
        unlink(slot);
        link(slot, triangle);
      }
    }
  }
  seen_surface_ = surface.version();
}

void SurfaceTexture::unlink(Index slot) {
  if (triangles_[slot] == LiveSurface::kEmptyTriangle) {
    return;
  }
  for (Index k = 0; k < 3; ++k) {
    Index* place = &first_corners_[triangles_[slot][k]];
    while (*place != 3 * slot + k) {
      place = &next_corners_[*place];
    }
    *place = next_corners_[3 * slot + k];
  }
  triangles_[slot] = LiveSurface::kEmptyTriangle;
}

void SurfaceTexture::link(Index slot, const Triangle& triangle) {
  triangles_[slot] = triangle;
  if (triangle == LiveSurface::kEmptyTriangle) {
    return;
  }
  for (Index k = 0; k < 3; ++k) {
    next_corners_[3 * slot + k] = first_corners_[triangle[k]];
    first_corners_[triangle[k]] = 3 * slot + k;
  }
  mark(slot);
}

void SurfaceTexture::mark(Index slot) {
  if (is_stale_[slot] == 0) {
    is_stale_[slot] = 1;
    stale_.push_back(slot);
  }
}

void SurfaceTexture::draw(Index slot, const SurfaceMap& map) {
  const Triangle& corners = triangles_[slot];
  const auto plane = [&](const auto& value_at) {
    return Plane(value_at(corners[0]), value_at(corners[1]), value_at(corners[2]));
  };
  const auto mark_plane = [&](std::uint8_t BurnBytes::*mark) {
    return plane([&](Index v) { return map.marks()[v].*mark; });
  };
  const Plane temperature = plane([&](Index v) { return map.temperatures()[v]; });
  const Plane white = mark_plane(&BurnBytes::white);
  const Plane brown = mark_plane(&BurnBytes::brown);
  const Plane charred = mark_plane(&BurnBytes::charred);
  const float step = 1.0F / static_cast<float>(texels_ - 1);
  std::size_t texel = static_cast<std::size_t>(slot) * static_cast<std::size_t>(texels_ * texels_);
  for (Index j = 0; j < texels_; ++j) {
    for (Index i = 0; i < texels_; ++i) {
      const float u = step * static_cast<float>(i), v = step * static_cast<float>(j);
      temperatures_[texel] = temperature.at(u, v);
      marks_[texel] = {white.byte_at(u, v), brown.byte_at(u, v), charred.byte_at(u, v)};
      ++texel;
    }
  }
}

}  // namespace pbdsurg
