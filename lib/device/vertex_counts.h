// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How long arrays of the vertex-block method are on a device.

#include <cstddef>

#include "pbdsurg/base/types.h"

#include "lib/solver/methods/vertex_blocks.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg::cuda {

struct VertexCounts {
  std::size_t blocks = 0, pulls = 0, springs = 0, volumes = 0, hinges = 0, triangles = 0,
              fibres = 0;
  std::size_t places = 0;  ///< of which is known in which block they are

  VertexCounts() = default;

  /// Those that there are now.
  explicit VertexCounts(const SolverData& data);

  /// Makes room for what others have. Words of an edit may be written after an undo of it.
  void include(const VertexCounts& others) noexcept;

  [[nodiscard]] bool has_room_for(const VertexCounts& others) const noexcept;

  /// Whether there are rows that few scenes have: kernels that know these take more registers.
  [[nodiscard]] bool has_rare_rows() const noexcept { return triangles + fibres > 0; }
};

/// How many more there is to be room for, where edits bring ever more: small scenes may have many
/// copies.
[[nodiscard]] std::size_t part_to_grow(std::size_t count) noexcept;

/// With room for more, where options ask for it or edits have brought vertices before. There is no
/// room in an array that is empty.
[[nodiscard]] VertexCounts with_room(const VertexCounts& counts, const SolverData& data,
                                     bool has_grown);

}  // namespace pbdsurg::cuda
