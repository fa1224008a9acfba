// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The faces opposite a vertex as strips: see StripRow.

#include <array>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Orders the faces around a vertex so that each shares an edge with the one before, as far as that
/// goes: those around a vertex of tissue make one strip, but for few.
class VertexStrip {
 public:
  struct Step {
    Index corner;
    Index face;  ///< that ends here, or kInvalidIndex
    bool turns;
  };

  /// @param faces  counter-clockwise seen from outside
  /// @return       valid until the next call
  std::span<const Step> find(std::span<const std::array<Index, 3>> faces);

 private:
  void find_neighbors(std::span<const std::array<Index, 3>> faces);
  [[nodiscard]] Index free_neighbors(Index face) const;
  [[nodiscard]] Index next_of(Index face) const;
  [[nodiscard]] Index new_start() const;
  void append_strip(std::span<const std::array<Index, 3>> faces, std::span<const Index> path);

  std::vector<std::array<Index, 3>> neighbors_;  // [face] across each edge, or kInvalidIndex
  std::vector<bool> is_visited_;                 // [face]
  std::vector<Index> paths_, best_;              // faces, strip after strip
  std::vector<Index> firsts_, best_firsts_;      // of strips in these
  std::vector<Step> steps_;
};

}  // namespace pbdsurg
