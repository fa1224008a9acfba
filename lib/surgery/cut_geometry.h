// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where the vertices of a cut lie, and where its surface does.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/tissue/topology_edit.h"

#include "lib/surgery/cut_neighborhood.h"
#include "lib/surgery/cut_surface.h"

namespace pbdsurg {

/// 1, -1 or 0.
[[nodiscard]] inline int sign_of(double value) {
  return (value > 0) - (value < 0);
}

[[nodiscard]] Eigen::Vector3d mean(std::span<const Eigen::Vector3d> points);

/// The neighbourhood of a cut, with vertices on edges that it splits.
class CutGeometry {
 public:
  /// @param splits  vertices after those of the neighbourhood
  CutGeometry(const CutNeighborhood& near, const CutSides& sides,
              const std::vector<NewVertex>& splits)
      : near_(near), sides_(sides), splits_(splits) {}

  /// m
  [[nodiscard]] Eigen::Vector3d position(Index v) const;
  /// m
  [[nodiscard]] double longest_edge(const Tet& tet) const;

  /// Whether the surface itself lies there, not what continues it. Heights are of the size of an
  /// edge for faces beside the surface, and larger where a point is between two of its sheets.
  [[nodiscard]] bool surface_is_at(const Eigen::Vector3d& point, double edge) const;

  /// Above the surface if positive, below if negative.
  [[nodiscard]] double height(const Eigen::Vector3d& point) const {
    return sides_.locate(point).height;
  }

 private:
  const CutNeighborhood& near_;
  const CutSides& sides_;
  const std::vector<NewVertex>& splits_;
};

}  // namespace pbdsurg
