// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The kinds of elastic constraints that there are: the one list of them.

#include <algorithm>
#include <cstdint>

#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/distance.h"
#include "pbdsurg/constraints/fibre.h"
#include "pbdsurg/constraints/membrane.h"
#include "pbdsurg/constraints/neo_hookean.h"
#include "pbdsurg/constraints/stiff_link.h"
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
  link,
  tet,
  triangle,
  hinge,
};

/// What the solver knows of a kind beside its formula: its phase and its element, in which
/// projection modes it has a form of its own (a scene is refused where it has only the other; what
/// has no compliance is alike in both, and keeps no multipliers), whether reports measure it, and
/// whether the vertex-block method projects it after its vertices.
template <class Constraint>
struct KindOf;

template <>
struct KindOf<DistanceConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::distance;
  static constexpr Element kElement = Element::edge_or_link;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<VolumeConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::volume;
  static constexpr Element kElement = Element::tet;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<NeoHookeanConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::neo_hookean;
  static constexpr Element kElement = Element::tet;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = true;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<FibreConstraint> {  // beside the matrix of the tetrahedron
  static constexpr PhaseKind kPhase = PhaseKind::fibre;
  static constexpr Element kElement = Element::tet;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = false;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<MembraneConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::membrane;
  static constexpr Element kElement = Element::triangle;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = false;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<StrainLimitConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::strain_limit;
  static constexpr Element kElement = Element::edge;
  static constexpr bool kHasFraction = true;
  static constexpr bool kHasCompliance = false;
  static constexpr bool kIsMeasured = false;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<BendingConstraint> {
  static constexpr PhaseKind kPhase = PhaseKind::bending;
  static constexpr Element kElement = Element::hinge;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = false;
  static constexpr bool kIsOfVertexBlocks = false;
};
template <>
struct KindOf<StiffLinkConstraint> {  // beside the distance of the link
  static constexpr PhaseKind kPhase = PhaseKind::stiff_link;
  static constexpr Element kElement = Element::link;
  static constexpr bool kHasFraction = false;
  static constexpr bool kHasCompliance = true;
  static constexpr bool kIsMeasured = false;
  static constexpr bool kIsOfVertexBlocks = true;
};

/// Whether projections keep multipliers from sweep to sweep.
template <class Constraint, ProjectionMode kMode>
inline constexpr bool kRemembers =
    kMode == ProjectionMode::compliance&& KindOf<Constraint>::kHasCompliance;

/// In the order in which edits change them.
template <template <class...> class List>
using ForAllConstraints =
    List<DistanceConstraint, VolumeConstraint, NeoHookeanConstraint, StrainLimitConstraint,
         BendingConstraint, StiffLinkConstraint, MembraneConstraint, FibreConstraint>;

template <class... Constraints>
struct KindsAfterVertices {
  static constexpr bool have(PhaseKind kind) noexcept {
    return (... || (KindOf<Constraints>::kPhase == kind && KindOf<Constraints>::kIsOfVertexBlocks));
  }
};

/// Whether a plan of the vertex-block method has stiff links.
[[nodiscard]] inline bool has_stiff_links(const StepPlan& plan) noexcept {
  return std::ranges::find(plan.phases, PhaseKind::stiff_link, &Phase::kind) != plan.phases.end();
}

/// Whether the vertex-block method has phases of a kind after those of vertices.
[[nodiscard]] constexpr bool is_after_vertices(PhaseKind kind) noexcept {
  return ForAllConstraints<KindsAfterVertices>::have(kind);
}

}  // namespace pbdsurg
