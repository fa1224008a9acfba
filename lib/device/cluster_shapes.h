// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// How each kind of constraint lies in its records and in the words of a cluster.

#include <algorithm>
#include <array>

#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_plan.h"

#include "lib/device/cluster_layout.h"
#include "lib/device/record_table.h"
#include "lib/device/records.h"
#include "lib/device/stages.h"
#include "lib/solver/sets/constraint_kinds.h"

namespace pbdsurg::cuda {

inline constexpr Index kNumbers = sizeof(Word128) / sizeof(std::uint32_t);
/// Of the numbers of a constraint: those before are slots.
inline constexpr Index kFirstParameter = 2;

struct ClusterShape {
  PhaseKind kind;
  DeviceArray array;
  Index corner_count;
  Index parameter_count;  ///< after the places of a record
  Index record_size;      ///< numbers
  Index multiplier_count;

  /// The first two are in word 0. Damping is the last one of volumes and hinges, and left out where
  /// nothing is damped.
  [[nodiscard]] constexpr Index packed_parameters(bool is_damped) const {
    const bool ends_with_damping = array == DeviceArray::volumes || array == DeviceArray::bendings;
    return ends_with_damping && !is_damped ? parameter_count - 1 : parameter_count;
  }
  [[nodiscard]] constexpr Index words(bool is_damped) const {
    return (kFirstParameter + packed_parameters(is_damped) + kNumbers - 1) / kNumbers;
  }
};

template <class... Constraints>
struct ClusterShapesOf {
  ClusterShape shapes[sizeof...(Constraints)] = {
      {KindOf<Constraints>::kPhase, array_of(KindOf<Constraints>::kPhase),
       Constraints::kVertexCount, kRecordParameters<Constraints>,
       sizeof(Record<Constraints>) / sizeof(float),
       KindOf<Constraints>::kHasCompliance ? Constraints::kMultiplierCount : 0}...};
};
inline constexpr auto kClusterShapes = std::to_array(ForAllConstraints<ClusterShapesOf>{}.shapes);

/// Words of the largest kind.
inline constexpr Index kMostWords =
    std::ranges::max(kClusterShapes, {}, [](const ClusterShape& shape) {
      return shape.words(true);
    }).words(true);

/// Null for what no cluster projects.
[[nodiscard]] constexpr const ClusterShape* shape_of(PhaseKind kind) {
  const auto* const shape = std::ranges::find(kClusterShapes, kind, &ClusterShape::kind);
  return shape == std::end(kClusterShapes) ? nullptr : shape;
}
[[nodiscard]] constexpr const ClusterShape* shape_of(DeviceArray array) {
  const auto* const shape = std::ranges::find(kClusterShapes, array, &ClusterShape::array);
  return shape == std::end(kClusterShapes) ? nullptr : shape;
}

}  // namespace pbdsurg::cuda
