// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The kinds of elastic constraints that there are: the one list of them.

#include <cstdint>

#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/solver/step_plan.h"

namespace pbdsurg {

/// What a constraint stands for: its id is that of this.
enum class Element : std::uint8_t {
  edge_or_link,  ///< see DistanceIds
  edge,
  tet,
};

/// What the solver knows of a kind beside its formula.
template <class Constraint>
struct KindOf;

template <>
struct KindOf<DistanceConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::distance;
  static constexpr Element kElement = Element::edge_or_link;
};
template <>
struct KindOf<VolumeConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::volume;
  static constexpr Element kElement = Element::tet;
};
template <>
struct KindOf<NeoHookeanConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::neo_hookean;
  static constexpr Element kElement = Element::tet;
};
template <>
struct KindOf<StrainLimitConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::strain_limit;
  static constexpr Element kElement = Element::edge;
};

/// In the order in which edits change them.
template <template <class...> class List>
using ForAllConstraints =
    List<DistanceConstraint, VolumeConstraint, NeoHookeanConstraint, StrainLimitConstraint>;

}  // namespace pbdsurg
