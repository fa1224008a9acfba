// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step as data: what is projected in which order. Backends execute it.

#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/core/types.h"

namespace pbdsurg {

/// What a phase projects.
enum class PhaseKind : std::uint8_t {
  distance,    ///< one colour of edges and links
  volume,      ///< one colour of tetrahedra
  attachment,  ///< grasped vertices, one attachment a vertex
  contact,     ///< vertices against one tool
};

/// Constraints of one kind that share no vertex.
struct Phase {
  PhaseKind kind;
  Index color;  ///< of the kind's colouring; for contacts the tool
};

/// The phases of one sweep, executed in order. The number of phases is what limits a parallel step.
struct StepPlan {
  std::string name;  ///< quoted in reports: colouring and composition
  std::vector<Phase> phases;
};

}  // namespace pbdsurg
