// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A step as data: what is projected in which order. Backends execute it.

#include <cstdint>
#include <string>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// Who projects the distance constraints of edges.
enum class PlanComposition : std::uint8_t {
  /// The fastest for the backend: nested on a CPU; on a CUDA device separate, or joint for more
  /// than 320,000 tetrahedra.
  automatic,
  separate,  ///< distances, colour by colour, then volumes
  /// Each edge is owned by one of its tetrahedra (assign_edges_to_tets()), which projects the edges
  /// it owns, then its volume: one phase a colour of tetrahedra. Distances without such an owner
  /// (links, edges of bodies without volume constraints) come before, colour by colour.
  joint,
  /// As separate for fewer than 6000 vertices. More are halved again and again, down to domains of
  /// 3000 to 6000, which are coloured and projected each for itself, distances then volumes; then
  /// what joins two domains, and what joins two such pairs, up to the whole. Domains of one level
  /// share no vertex, so threads meet once a level in place of once a colour: the fastest plan on a
  /// CPU.
  nested,
};

/// What a phase projects.
enum class PhaseKind : std::uint8_t {
  distance,  ///< edges and links
  volume,    ///< tetrahedra
  /// Tetrahedra, each after the edges that it owns, in the order of kTetEdges. In a serial phase
  /// all edges at one place of kTetEdges come before those at the next, and volumes last.
  joint,
  neo_hookean,   ///< tetrahedra of Neo-Hookean bodies
  fibre,         ///< those of them that have fibres
  membrane,      ///< triangles of sheets
  strain_limit,  ///< edges of bodies whose stretch is limited, of the projection method
  bending,       ///< hinges
  stiff_link,    ///< links that the vertex-block method solves after vertices, both ends at once
  /// Vertices, each moved to the least energy that its neighbours leave it, contacts and grasps
  /// among them: what the vertex-block method has beside stiff links, and explicit steps have
  /// alone.
  vertex,
  attachment,    ///< grasped vertices, one attachment a vertex
  grip,          ///< points that jaws hold with a limit, one after another
  contact,       ///< vertices against one tool; of vertex blocks, the surfaces of all tools
  body_contact,  ///< bodies against each other, one contact after another
  custom,        ///< a set of CustomConstraints
};

/// Constraints of one kind that share no vertex, unless the phase is serial.
struct Phase {
  PhaseKind kind;  ///< what it projects
  Index color;     ///< of the kind's colouring; for contacts the tool, for custom the set
  /// These are what ColoringOptions::max_colors left over: they may share vertices and are
  /// projected one after another.
  bool serial = false;
  Index level = 0;  ///< of a nested plan: 0 for its smallest domains
  /// Within the level; phases of one level and different domains share no vertex.
  Index domain = 0;
};

/// The phases of one sweep, executed in order. The number of phases is what limits a parallel step.
struct StepPlan {
  std::string name;           ///< quoted in reports: colouring, composition, what is automatic
  std::vector<Phase> phases;  ///< in the order of execution
  float longest_substep = 0;  ///< s, where substeps are automatic or explicit; else zero: any
};

}  // namespace pbdsurg
