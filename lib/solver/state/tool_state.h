// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the solver knows of a tool.

#include <Eigen/Core>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/tool.h"

namespace pbdsurg {

/// A vertex held by a tool.
struct Attachment {
  Index vertex;
  Eigen::Vector3f anchor;      ///< m, in the tool's frame
  float compliance;            ///< m/N
  Eigen::Vector3f target;      ///< m, of the current substep
  Eigen::Vector3f multiplier;  ///< kg m
  Index color;                 ///< how many tools before this one hold the same vertex
};

/// A vertex near a capsule, which stands as a plane for the rest of the substep.
struct Contact {
  Index place;
  Eigen::Vector3f normal;  ///< out of the tool
  float offset;            ///< m
  float multiplier;        ///< kg m
};

struct ToolState {
  std::vector<Capsule> capsules;
  ToolPose pose;    ///< at the end of the last step
  ToolPose target;  ///< at the end of the next step
  std::vector<Attachment> attachments;
  std::vector<Capsule> placed_capsules;  ///< in the world, of the current substep
  std::vector<Contact> contacts;         ///< of the current substep, ascending by place
  Eigen::Vector3f force{0, 0, 0};        ///< N, on the tool
};

}  // namespace pbdsurg
