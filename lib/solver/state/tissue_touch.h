// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a copy knows of contacts between bodies.

#include <array>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/state/contact_bodies.h"

namespace pbdsurg {

/// A vertex and the body whose surface it touches, or two edges: the slot of a contact, which all
/// lists of them are in the order of.
struct TouchSlot {
  /// Of two edges: the other end of the first, then the ends of the second; places. The smaller
  /// end of each comes first, and so does the edge with the smallest.
  std::array<Index, 3> edges{kInvalidIndex, kInvalidIndex, kInvalidIndex};
  Index place = kInvalidIndex;  ///< of the vertex, or of the first edge
  Index body = kInvalidIndex;   ///< of the triangle or link; none of two edges

  [[nodiscard]] bool has_edges() const noexcept { return edges[0] != kInvalidIndex; }

  auto operator<=>(const TouchSlot& other) const noexcept = default;
};

/// A vertex near the surface of a body, or near a link of it; or two edges that cross. It keeps
///
///     C = normal . sum(weights * u) - offset >= 0    m
///
/// with u the displacements of its corners since the start of the substep, in fraction mode their
/// positions. Normal and weights are those of the start, where the normal is the way from the
/// second side to the first: so a force along it has no moment.
struct TissueTouch {
  static constexpr int kCorners = 4;

  TouchSlot slot;
  std::array<Index, 2> bodies{kInvalidIndex, kInvalidIndex};  ///< of either side
  /// The vertex, then the triangle's corners, or the ends of both edges; a link has its second end
  /// twice.
  std::array<Index, kCorners> places{};
  /// Of the points that touch, those of the second side negative; 0 where a place comes again.
  std::array<float, kCorners> weights{};
  int first_corners = 1;  ///< of the first side
  Vec3<float> normal;     ///< out of the second side
  float offset = 0;       ///< m
  Vec3<float> drift;      ///< m: sum(weights * u) of tissue that sticks
  float mu = 0;           ///< coefficient of friction
  float multiplier = 0;   ///< kg m
  Vec3<float> friction;   ///< kg m, multipliers across the normal
  float stiffness = 0;    ///< N/m, with which vertex blocks meet it
  /// m, sum(weights * u) of either side when a sweep of vertex blocks began: what the other side
  /// sees of it, as vertices of both may move at the same time
  std::array<Vec3<float>, 2> seen{};
  bool is_likely = false;  ///< whether it pushes as sweeps begin
  bool is_eased = false;   ///< with the pieces that it touches: see ease_pieces()

  /// The corners of a side.
  [[nodiscard]] int first_of(int side) const noexcept { return side == 0 ? 0 : first_corners; }
  [[nodiscard]] int end_of(int side) const noexcept { return side == 0 ? first_corners : kCorners; }
  [[nodiscard]] int side_of(int corner) const noexcept { return corner < first_corners ? 0 : 1; }
  /// Where one of them is.
  [[nodiscard]] Index place_on(int side) const noexcept { return places[first_of(side)]; }
};

/// What a substep leaves to the next of a contact.
struct RememberedTouch {
  /// Puts the places of two edges in the order of slots, after these have got other numbers.
  void sort_edges();

  TouchSlot slot;
  Vec3<float> normal;    ///< the side on which the vertex or the first edge is
  float force = 0;       ///< N, along it
  Vec3<float> friction;  ///< N
};

struct TouchBox {
  Vec3<float> low, high;  ///< m
};

/// The triangles or edges of a body in an order in which near ones are near, with boxes around them
/// and around pairs of boxes, as a heap: box i holds boxes 2 i + 1 and 2 i + 2.
struct TouchTree {
  std::vector<Index> order;  ///< of the body's
  std::vector<TouchBox> boxes;
  std::size_t first_leaf = 0;
};

/// A triangle, or a link, that a vertex may meet.
struct TouchCandidate {
  TouchSlot slot;
  Index pair;  ///< of ContactBodies
  std::array<Index, 3> triangle;
  float distance;  ///< m, when it was found

  auto operator<=>(const TouchCandidate& other) const noexcept = default;
};

/// Edges that may meet.
struct EdgeCandidate {
  TouchSlot slot;
  Index pair;                                    ///< of ContactBodies
  std::array<Index, 2> bodies;                   ///< of the edges
  std::array<std::array<Index, 2>, 2> opposite;  ///< see ContactBodies::Edge
  float distance;                                ///< m, when it was found

  auto operator<=>(const EdgeCandidate& other) const noexcept = default;
};

/// All of a copy.
struct TissueTouches {
  std::vector<TissueTouch> contacts;        ///< of the current substep
  std::vector<RememberedTouch> remembered;  ///< of the last

  /// All that vertices and edges may meet before anything has moved by `slack` from where it was
  /// seen. What it holds beyond that changes no result.
  struct Search {
    std::uint64_t revision = 0;              ///< of ContactBodies; zero: there was none
    float slack = 0;                         ///< m
    std::vector<Vec3<float>> seen;           ///< [vertices of ContactBodies] m
    std::vector<float> moved;                ///< [bodies of ContactBodies] m, at most since then
    std::vector<TouchTree> trees;            ///< [bodies of ContactBodies]
    std::vector<TouchTree> edge_trees;       ///< likewise, of their edges
    std::vector<TouchCandidate> candidates;  ///< ascending
    std::vector<EdgeCandidate> edges;        ///< likewise
  } search;
};

}  // namespace pbdsurg
