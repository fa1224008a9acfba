// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A texture of heat and its marks that needs no texture coordinates and survives cuts.

#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/surface_map.h"
#include "pbdsurg/views/change_log.h"
#include "pbdsurg/views/live_surface.h"

namespace pbdsurg {

/// A square tile of texels for each slot of a surface, so that a triangle that an edit bares has
/// its texels at once (the idea of mesh colours: Yuksel, Keyser and House 2010). For renderers that
/// draw into the texture or add detail of their own; others take SurfaceMap's vertices.
///
/// Texel (i, j) of n x n, at i + n j of the tile, lies at a + u (b - a) + v (c - a) of its triangle
/// (a, b, c), u = i / (n - 1), v = j / (n - 1), and holds what is linear between the corners:
/// beyond the edge b-c extrapolated, so that bilinear filtering gives linear values up to the edge
/// (bytes are clamped). Tiles depend on the map alone, not on what was before; a slot without a
/// triangle keeps what it had.
///
/// Cost of an update: O(changed vertices and slots), n^2 each. Allocates when slots are added.
class PBDSURG_API SurfaceTexture {
 public:
  /// @param texels  n, along an edge of a tile, in [2, 64]
  /// @throws InvalidArgument  for n out of range
  explicit SurfaceTexture(Index texels = 8);

  /// Takes over what changed since the last update.
  /// @param surface  always the same
  /// @param map      always the same, of that surface and updated after it
  /// @throws InvalidArgument  naming the slot whose triangle has a vertex that the map has not;
  ///                          then nothing has changed
  void update(const LiveSurface& surface, const SurfaceMap& map);

  /// n, along an edge of a tile.
  [[nodiscard]] Index texels() const noexcept { return texels_; }

  /// [slot_count * n * n] degrees Celsius, tile by tile
  [[nodiscard]] std::span<const float> temperatures() const noexcept { return temperatures_; }

  /// [slot_count * n * n]
  [[nodiscard]] std::span<const BurnBytes> marks() const noexcept { return marks_; }

  /// Grows with every tile that changes. Above zero.
  [[nodiscard]] std::uint64_t version() const noexcept { return changes_.version(); }

  /// Which slots' tiles a reader has to copy that has seen a version (ChangeLog::collect).
  void collect_changes(std::uint64_t since, std::vector<SlotRange>& ranges) const {
    changes_.collect(since, static_cast<Index>(triangles_.size()), ranges);
  }

 private:
  void follow(const LiveSurface& surface);
  void unlink(Index slot);
  void link(Index slot, const Triangle& triangle);
  void mark(Index slot);
  void draw(Index slot, const SurfaceMap& map);

  Index texels_;
  std::vector<Triangle> triangles_;     // [slot_count] as drawn
  std::vector<float> temperatures_;     // [slot_count * n * n]
  std::vector<BurnBytes> marks_;        // [slot_count * n * n]
  std::vector<Index> first_corners_;    // [vertex_count] corner 3 slot + k is followed by
  std::vector<Index> next_corners_;     // [3 * slot_count] the next at the same vertex
  std::vector<std::uint8_t> is_stale_;  // [slot_count] scratch
  std::vector<Index> stale_;            // scratch
  std::vector<SlotRange> ranges_;       // scratch
  ChangeLog changes_;
  std::uint64_t seen_surface_ = 0, seen_map_ = 0;
};

}  // namespace pbdsurg
