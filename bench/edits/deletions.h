// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Which tetrahedra go in which frame.

#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/tet_mesh.h"

namespace pbdsurg::bench {

inline constexpr int kFramesPerSecond = 60;

enum class Pattern {
  regional,   ///< around a point that moves through the body, as a burn eats
  scattered,  ///< anywhere
};

/// "regional", "scattered"
[[nodiscard]] const char* name_of(Pattern pattern) noexcept;

/// How many tetrahedra go in a frame, so that a rate is kept on the whole.
[[nodiscard]] Index deletions_in_frame(int per_second, int frame) noexcept;

/// Deals out the tetrahedra of a mesh, each once.
class Deletions {
 public:
  Deletions(const TetMesh& mesh, Pattern pattern);

  /// Those that go next. @param count  at most as many as are left
  [[nodiscard]] std::vector<Index> next(Index count);

 private:
  const TetMesh* mesh_;
  Pattern pattern_;
  Eigen::Vector3d point_, velocity_;  // m, m/s: of the burn
  std::vector<Index> left_;
};

}  // namespace pbdsurg::bench
