// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How the arms of a rig stand to the scene.

#include <Eigen/Core>
#include <array>

#include "pbdsurg/haptics/instrument_mapping.h"

#include "apps/rig/rig_description.h"

namespace rig {

/// Where instruments stand in the scene.
struct RigPlaces {
  std::array<Eigen::Vector3f, 2> ports;  ///< m, [side]
  std::array<Eigen::Vector3f, 2> tips;   ///< m, [side]: where hands begin, the arm's origin
  Eigen::Matrix3f axes;                  ///< of the scene: columns right, up and to the user
};

/// How an arm in the description stands to the scene.
[[nodiscard]] pbdsurg::InstrumentMapping mapping_of(const HandDescription& hand,
                                                    const RigPlaces& places, Side side);

}  // namespace rig
