// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What emulated hands do: an organ dragged and let go, fat burnt, fat cut.

#include <array>
#include <cstddef>
#include <vector>

#include "pbdsurg/haptics/scripted_hand.h"

#include "apps/cholecystectomy/surgical_scene.h"
#include "apps/rig/rig_description.h"

namespace cholecystectomy {

/// A part of it.
struct RehearsedPart {
  const char* name;
  std::size_t hand;   ///< 0 the grasper, 1 the hook
  double begin, end;  ///< s
};

struct Rehearsal {
  std::array<std::vector<pbdsurg::Waypoint>, 2> hands;  ///< grasper, hook
  std::array<RehearsedPart, 3> parts;                   ///< drag, burn, cut
  double length;                                        ///< s
};

/// For a scene whose organs are where they were made.
/// @param tips  m, where the grasper and the hook begin
[[nodiscard]] Rehearsal make_rehearsal(const SurgicalScene& scene,
                                       const std::array<Eigen::Vector3f, 2>& tips);

}  // namespace cholecystectomy
