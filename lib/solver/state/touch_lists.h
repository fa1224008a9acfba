// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a copy knows of contacts between bodies, and how a host finds them.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/solver/tissue_contact.h"

#include "lib/solver/state/contact_bodies.h"
#include "lib/solver/state/tissue_touch.h"
#include "lib/solver/state/touch_features.h"

namespace pbdsurg {

struct TouchBox {
  Vec3<float> low, high;  ///< m
};

/// The triangles or edges of a body in an order in which near ones are near, with boxes around them
/// and around pairs of boxes, as a heap: box i holds boxes 2 i + 1 and 2 i + 2.
struct TouchTree {
  std::vector<Index> order;  ///< of the body's
  std::vector<TouchBox> boxes;
  std::size_t first_leaf = 0;
  std::uint64_t body = 0;  ///< ContactBodies::Body::revision, which the order is of
};

/// A triangle, or a link, that a vertex may meet.
struct TouchCandidate {
  Index triangle;  ///< of the body
  float distance;  ///< m, when it was found
};

/// Those of a vertex and a body.
struct TouchCandidates {
  TouchSlot slot;
  Index pair;          ///< of ContactBodies
  Index first, count;  ///< in the order of triangles
  Index nearest;       ///< of these, when they were found
};

/// Edges that may meet.
struct EdgeCandidate {
  TouchSlot slot;
  Index pair;  ///< of ContactBodies
  CrossingEdge first, second;
  float distance;  ///< m, when it was found
};

/// All of a copy.
struct TissueTouches {
  std::vector<TissueTouch> contacts;        ///< of the current substep
  std::vector<RememberedTouch> remembered;  ///< of the last
  std::vector<BodyContact> told;            ///< of a solver before this one: told_contacts.h

  /// Forgets contacts of places and bodies from these on. If there were any, all that was found in
  /// the substep goes with them.
  void forget_from(Index place, Index body);

  /// All that vertices and edges may meet before anything has moved by `slack` from where it was
  /// seen. What it holds beyond that changes no result.
  struct Search {
    std::uint64_t revision = 0;         ///< of ContactBodies; zero: there was none
    float slack = 0;                    ///< m
    std::vector<Vec3<float>> seen;      ///< [vertices of ContactBodies] m
    std::vector<float> moved;           ///< [bodies of ContactBodies] m, at most since then
    std::vector<float> moved_squares;   ///< [place] m^2, likewise; of those that bodies have
    std::vector<TouchTree> trees;       ///< [bodies of ContactBodies]
    std::vector<TouchTree> edge_trees;  ///< likewise, of their edges
    std::vector<TouchCandidate> candidates;
    std::vector<TouchCandidates> slots;  ///< in the order of slots
    std::vector<EdgeCandidate> edges;    ///< in the order of slots
    std::vector<NearPoint> near;         ///< of one vertex, while contacts are found
  } search;
};

}  // namespace pbdsurg
