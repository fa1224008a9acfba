// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// From ids before a compaction to those after it.

#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// kInvalidIndex stands for what was dead. Of one body, and among links or hinges, the order stays.
struct Renumbering {
  std::vector<Index> vertices;       ///< [vertex_count before]
  std::vector<Index> tets;           ///< [tet_count before]
  std::vector<Index> triangles;      ///< [triangle_count before]
  std::vector<Index> edges;          ///< [edge_count before]
  std::vector<Index> links;          ///< [link_count before]
  std::vector<Index> hinges;         ///< [hinge_count before]
  std::vector<Index> bodies;         ///< [body_count before]
  std::uint64_t version_before = 0;  ///< of the tissue, before the compaction
  std::uint64_t version = 0;         ///< of the tissue, one that it never had
};

}  // namespace pbdsurg
