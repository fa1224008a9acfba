// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/solver_checks.h"

#include <string>

#include "pbdsurg/base/error.h"

namespace pbdsurg {

CopyState& checked_copy(SolverData& data, Index copy) {
  if (copy < 0 || copy >= data.copy_count()) {
    throw InvalidArgument("there is no copy " + std::to_string(copy) + "; the solver has " +
                          std::to_string(data.copy_count()));
  }
  return data.copy(copy);
}

ToolState& checked_tool(CopyState& copy, ToolId tool) {
  if (tool < 0 || tool >= static_cast<Index>(copy.tools.size())) {
    throw InvalidArgument("there is no tool " + std::to_string(tool.value) + "; the solver has " +
                          std::to_string(copy.tools.size()));
  }
  return copy.tools[tool];
}

void check_pose(const ToolPose& pose) {
  constexpr float kRounding = 1e-3F;  // of a product of unit vectors
  const Eigen::Matrix3f rotation = pose.linear();
  if (!pose.matrix().allFinite() ||
      !(rotation.transpose() * rotation).isApprox(Eigen::Matrix3f::Identity(), kRounding) ||
      !(rotation.determinant() > 0)) {
    throw InvalidArgument("a tool's pose must be a finite translation and a rotation");
  }
}

}  // namespace pbdsurg
