// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a step has to say about itself. Physics never throws, unless options ask for it: it is
/// reported here.

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Contacts of a step for which there was no room: SolverOptions::contact_capacity. Those that lie
/// deepest, or come first, stay.
struct DroppedContacts {
  Index at_vertices = 0;  ///< of tools that meet vertices alone
  Index at_surfaces = 0;  ///< of tools that meet edges and triangles, too
  Index of_bodies = 0;    ///< between bodies

  /// All classes together.
  [[nodiscard]] constexpr Index total() const noexcept {
    return at_vertices + at_surfaces + of_bodies;
  }
  /// Adds class by class, as over substeps.
  constexpr DroppedContacts& operator+=(const DroppedContacts& other) noexcept {
    at_vertices += other.at_vertices;
    at_surfaces += other.at_surfaces;
    of_bodies += other.of_bodies;
    return *this;
  }
  /// Whether each class has as many.
  constexpr bool operator==(const DroppedContacts&) const noexcept = default;
};

/// State after one step. Of many copies, counts are sums and residuals the largest.
struct StepReport {
  Index inverted_tets = 0;                 ///< live tetrahedra of negative volume
  Index non_finite_vertices = 0;           ///< vertices with a NaN or infinite coordinate
  Index first_non_finite = kInvalidIndex;  ///< scene vertex, the smallest such id of the copy below
  Index first_non_finite_copy = kInvalidIndex;  ///< the first copy that has such a vertex
  Index contacts = 0;                           ///< vertex-tool contacts in the last substep
  DroppedContacts dropped_contacts{};           ///< over all substeps
  float distance_residual = 0;  ///< largest |C| / rest length over live edges and links; infinite
                                ///< when one is not a number
  float volume_residual = 0;    ///< likewise over live tetrahedra, |C| / rest volume
  /// The largest Convergence::ratio() of a body of the first copy, if this step is one of those
  /// that SolverOptions::convergence_interval names; else 0.
  float convergence = 0;
  int substeps = 0;  ///< that the step took; none of one that was given up
  /// Tools that pressed on tissue and went further than half a radius of a capsule in each substep,
  /// although automatic substeps are up to four times as many where tools are fast. What they meet
  /// stays on its side, but may be pressed too little or thrown off.
  Index fast_tools = 0;
  /// A device did not go on for half a second, as no driver should let it: the step was given up.
  /// The state is that before it, no force is on a tool, and steps from now on go to the device
  /// launch by launch, which in fast mode have other bits.
  bool stalled = false;
};

}  // namespace pbdsurg
