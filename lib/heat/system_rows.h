// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How the rows of a local system hang together, for those who sum and solve it, host or device.

#include <span>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// What one row takes of one element that it is a corner of.
struct RowTet {
  Index tet;
  int corner;
  Index entries[3];  ///< of the system, one for each other corner, others ascending
};

/// Where the edge from a corner to its k-th other corner, others ascending, stands in kTetEdges.
PBDSURG_HOST_DEVICE constexpr int edge_of_corner(int corner, int k) {
  const int a = k < corner ? k : corner;
  const int b = k < corner ? corner : k + 1;
  return a == 0 ? b - 1 : a + b;
}

struct SystemRows {
  std::span<const Index> starts;          ///< [row_count + 1] of a row's entries
  std::span<const Index> columns;         ///< [entry_count]
  std::span<const Index> row_tet_starts;  ///< [row_count + 1]
  std::span<const RowTet> row_tets;       ///< [4 tet_count] those of a row in the order of tets
  std::span<const Index> groups;          ///< [group_count + 1] first rows; empty: none

  [[nodiscard]] Index row_count() const { return static_cast<Index>(starts.size()) - 1; }
  [[nodiscard]] Index tet_count() const { return static_cast<Index>(row_tets.size() / 4); }
};

}  // namespace pbdsurg
