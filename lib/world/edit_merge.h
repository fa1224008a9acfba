// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// One edit of what several ask for.

#include <vector>

#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/tissue/tissue_change.h"
#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

[[nodiscard]] bool is_empty(const TopologyEdit& edit) noexcept;

/// Adds a request to an edit, but for removals that it has already. What the request brings is
/// numbered behind what the edit does.
/// @param vertex_count  of the tissue for which both were made
/// @return  whether that can be; else nothing was added: a request names a vertex that neither the
///          tissue has nor it brings, or both bring a body of one name
bool merge(TopologyEdit& edit, TopologyEdit request, Index vertex_count);

/// How many of each there ever were.
struct IdCounts {
  Index vertices = 0, tets = 0, triangles = 0, edges = 0, links = 0, bodies = 0;
};
[[nodiscard]] IdCounts count_ids(const Tissue& tissue);

/// What edits did since others were made for the same tissue.
class EarlierEdits {
 public:
  explicit EarlierEdits(const Tissue& tissue) : before_(count_ids(tissue)) {}

  void note(const TissueChange& change);

  /// Leaves out removals that are done, and numbers what an edit brings behind what has come; so
  /// nothing is taken for something else that has its number now.
  void adapt(TopologyEdit& edit, const Tissue& tissue) const;

 private:
  IdCounts before_;
  std::vector<Index> tets_, triangles_, links_, bodies_;  // that have gone, ascending
};

}  // namespace pbdsurg
