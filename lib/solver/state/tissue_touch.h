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

/// A vertex and the body whose surface it touches: the slot of a contact, which all lists of them
/// are in the order of.
struct TouchSlot {
  Index place = kInvalidIndex;  ///< of the vertex
  Index body = kInvalidIndex;   ///< of the triangle

  auto operator<=>(const TouchSlot& other) const noexcept = default;
};

/// A vertex near the surface of a body. It keeps
///
///     C = normal . sum(weights * u) - offset >= 0    m
///
/// with u the displacements of its corners since the start of the substep, in fraction mode their
/// positions. Normal and weights are those of the start, where the normal is the way from the
/// triangle to the vertex: so a force along it has no moment.
struct TissueTouch {
  static constexpr int kCorners = 4;

  TouchSlot slot;
  Index vertex_body = kInvalidIndex;
  std::array<Index, kCorners> places{};   ///< the vertex, then the triangle's corners
  std::array<float, kCorners> weights{};  ///< 1, then minus the barycentric coordinates
  Vec3<float> normal;                     ///< out of the triangle's body
  float offset = 0;                       ///< m
  Vec3<float> drift;                      ///< m: sum(weights * u) of tissue that sticks
  float mu = 0;                           ///< coefficient of friction
  float multiplier = 0;                   ///< kg m
  Vec3<float> friction;                   ///< kg m, multipliers across the normal
  float stiffness = 0;                    ///< N/m, with which vertex blocks meet it
  /// m, sum(weights * u) of either side when a sweep of vertex blocks began: what the other side
  /// sees of it, as vertices of both may move at the same time
  std::array<Vec3<float>, 2> seen{};
  bool is_likely = false;  ///< whether it pushes as sweeps begin
  bool is_eased = false;   ///< with the pieces that it touches: see ease_pieces()
};

/// What a substep leaves to the next of a contact.
struct RememberedTouch {
  TouchSlot slot;
  Vec3<float> normal;    ///< the side on which the vertex is
  float force = 0;       ///< N, along it
  Vec3<float> friction;  ///< N
};

struct TouchBox {
  Vec3<float> low, high;  ///< m
};

/// The triangles of a body in an order in which near ones are near, with boxes around them and
/// around pairs of boxes, as a heap: box i holds boxes 2 i + 1 and 2 i + 2.
struct TouchTree {
  std::vector<Index> order;  ///< of the body's triangles
  std::vector<TouchBox> boxes;
  std::size_t first_leaf = 0;
};

/// A triangle that a vertex may meet.
struct TouchCandidate {
  TouchSlot slot;
  Index pair;  ///< of ContactBodies
  std::array<Index, 3> triangle;
  float distance;  ///< m, when it was found

  auto operator<=>(const TouchCandidate& other) const noexcept = default;
};

/// All of a copy.
struct TissueTouches {
  std::vector<TissueTouch> contacts;        ///< of the current substep
  std::vector<RememberedTouch> remembered;  ///< of the last

  /// All triangles that vertices may meet before anything has moved by `slack` from where it was
  /// seen. What it holds beyond that changes no result.
  struct Search {
    std::uint64_t revision = 0;              ///< of ContactBodies; zero: there was none
    float slack = 0;                         ///< m
    std::vector<Vec3<float>> seen;           ///< [vertices of ContactBodies] m
    std::vector<float> moved;                ///< [bodies of ContactBodies] m, at most since then
    std::vector<TouchTree> trees;            ///< [bodies of ContactBodies]
    std::vector<TouchCandidate> candidates;  ///< ascending
  } search;
};

}  // namespace pbdsurg
