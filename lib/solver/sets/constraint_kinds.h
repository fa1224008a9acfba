// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The kinds of elastic constraints that there are: the one list of them.

#include <cstdint>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/strain_limit.h"
#include "pbdsurg/constraints/volume.h"
#include "pbdsurg/solver/step_plan.h"

// From here on a switch names all enumerators, with or without a default.
#pragma GCC diagnostic error "-Wswitch-enum"

namespace pbdsurg {

/// What a constraint stands for: its id is that of this.
enum class Element : std::uint8_t {
  edge_or_link,  ///< see DistanceIds
  edge,
  tet,
  hinge,
};

/// What the solver knows of a kind beside its formula: its phase and its element, in which
/// projection modes it has a form of its own (a scene is refused where it has only the other; what
/// has no compliance is alike in both, and keeps no multipliers), whether reports measure it.
template <class Constraint>
struct KindOf;

template <>
struct KindOf<DistanceConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::distance;
  static constexpr Element kElement = Element::edge_or_link;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
};
template <>
struct KindOf<VolumeConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::volume;
  static constexpr Element kElement = Element::tet;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
};
template <>
struct KindOf<NeoHookeanConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::neo_hookean;
  static constexpr Element kElement = Element::tet;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
};
template <>
struct KindOf<StrainLimitConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::strain_limit;
  static constexpr Element kElement = Element::edge;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = false;
  static constexpr bool kIsMeasured = false;
};
template <>
struct KindOf<BendingConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::bending;
  static constexpr Element kElement = Element::hinge;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = false;
};

/// Whether projections keep multipliers from sweep to sweep.
template <class Constraint, ProjectionMode kMode>
inline constexpr bool kRemembers =
    kMode == ProjectionMode::compliance&& KindOf<Constraint>::kHasCompliance;

/// In the order in which edits change them.
template <template <class...> class List>
using ForAllConstraints = List<DistanceConstraint, VolumeConstraint, NeoHookeanConstraint,
                               StrainLimitConstraint, BendingConstraint>;

}  // namespace pbdsurg
