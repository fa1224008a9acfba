// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Plans a cut on plain arrays.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/cut.h"

namespace pbdsurg {

/// Tissue as a cut finds it, in the ids of a solver.
struct CutTissue {
  std::span<const Eigen::Vector3f> positions;  ///< [vertex_count] m
  std::span<const Tet> tets;                   ///< [tet_count]
  std::vector<bool> tet_alive;                 ///< [tet_count]
  std::span<const Link> links;                 ///< [link_count]
  std::vector<bool> link_alive;                ///< [link_count]
};

/// See the public function of this name.
[[nodiscard]] CutPlan plan_cut(const CutTissue& tissue, const CutSurface& surface,
                               const CutOptions& options);

}  // namespace pbdsurg
