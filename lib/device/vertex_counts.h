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
  std::size_t blocks = 0, pulls = 0, springs = 0, volumes = 0, hinges = 0;
  std::size_t places = 0;  ///< of which is known in which block they are; none without blocks

  VertexCounts() = default;

  /// Those that there are now.
  explicit VertexCounts(const SolverData& data);

  /// Makes room for what others have. Words of an edit may be written after an undo of it.
  void include(const VertexCounts& others) noexcept;

  [[nodiscard]] bool has_room_for(const VertexCounts& others) const noexcept;
};

/// With room for more, where options ask for it or edits have brought vertices before: in the
/// latter case an eighth more than there are, so that edits that bring ever more rarely come to
/// this. There is no room in an array that is empty.
[[nodiscard]] VertexCounts with_room(const VertexCounts& counts, const SolverData& data,
                                     bool has_grown);

}  // namespace pbdsurg::cuda
