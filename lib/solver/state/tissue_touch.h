// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Contacts between bodies.

#include <compare>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// A vertex and the body whose surface it touches, or two edges: the slot of a contact, which all
/// lists of them are in the order of, those of vertices first. Neighbours are not to follow one
/// another, so that devices can go through many contacts at once: of 320 between a liver and its
/// gallbladder, a vertex of which has 41, those that have to wait for each other are 204 in a row
/// in the order of places, and 79 in this one.
struct TouchSlot {
  /// Of two edges: the other end of the first, then the ends of the second; places. The smaller
  /// end of each comes first, and so does the edge with the smallest.
  Index edges[3] = {kInvalidIndex, kInvalidIndex, kInvalidIndex};
  Index place = kInvalidIndex;  ///< of the vertex, or of the first edge
  Index body = kInvalidIndex;   ///< of the triangle or link; none of two edges
  std::uint64_t turn = 0;       ///< random bits of these

  [[nodiscard]] PBDSURG_HOST_DEVICE bool has_edges() const noexcept {
    return edges[0] != kInvalidIndex;
  }

  /// Below zero if it comes before another, zero if it is the same.
  [[nodiscard]] PBDSURG_HOST_DEVICE int compared_with(const TouchSlot& other) const noexcept {
    if (has_edges() != other.has_edges()) {
      return has_edges() ? 1 : -1;
    }
    if (turn != other.turn) {
      return turn < other.turn ? -1 : 1;
    }
    const Index own[] = {place, edges[0], edges[1], edges[2], body};
    const Index its[] = {other.place, other.edges[0], other.edges[1], other.edges[2], other.body};
    for (int k = 0; k < 5; ++k) {
      if (own[k] != its[k]) {
        return own[k] < its[k] ? -1 : 1;
      }
    }
    return 0;
  }
  std::strong_ordering operator<=>(const TouchSlot& other) const noexcept {
    return compared_with(other) <=> 0;
  }
  bool operator==(const TouchSlot& other) const noexcept { return compared_with(other) == 0; }
};

/// Of the ids of a slot.
[[nodiscard]] PBDSURG_HOST_DEVICE inline std::uint64_t turn_of(const Index (&ids)[4]) {
  const auto bits = [&](int k) { return static_cast<std::uint64_t>(ids[k]); };
  return random_bits(random_bits(bits(0), bits(1)), bits(2), bits(3));
}

[[nodiscard]] PBDSURG_HOST_DEVICE inline TouchSlot slot_of_vertex(Index place, Index body) {
  TouchSlot slot;
  slot.place = place;
  slot.body = body;
  slot.turn = turn_of({place, body, 0, 0});
  return slot;
}
/// Of edges in their order.
[[nodiscard]] PBDSURG_HOST_DEVICE inline TouchSlot slot_of_edges(Index first, Index first_end,
                                                                 Index second, Index second_end) {
  TouchSlot slot;
  slot.place = first;
  slot.edges[0] = first_end;
  slot.edges[1] = second;
  slot.edges[2] = second_end;
  slot.turn = turn_of({first, first_end, second, second_end});
  return slot;
}

/// A vertex near the surface of a body, or near a link of it; or two edges that cross. It keeps
///
///     C = normal . sum(weights * u) - offset >= 0    m
///
/// with u the displacements of its corners since the start of the substep, in fraction mode their
/// positions. Normal and weights are those of the start, where the normal is the way from the
/// second side to the first: so a force along it has no moment.
struct alignas(16) TissueTouch {
  static constexpr int kCorners = 4;

  TouchSlot slot;
  Index bodies[2] = {kInvalidIndex, kInvalidIndex};  ///< of either side
  /// The vertex, then the triangle's corners, or the ends of both edges; a link has its second end
  /// twice.
  Index places[kCorners] = {};
  /// Of the points that touch, those of the second side negative; 0 where a place comes again.
  float weights[kCorners] = {};
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
  Vec3<float> seen[2];
  bool is_likely = false;  ///< whether it pushes as sweeps begin
  bool is_eased = false;   ///< with the pieces that it touches: see ease_pieces()

  /// The corners of a side.
  [[nodiscard]] PBDSURG_HOST_DEVICE int first_of(int side) const noexcept {
    return side == 0 ? 0 : first_corners;
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE int end_of(int side) const noexcept {
    return side == 0 ? first_corners : kCorners;
  }
  [[nodiscard]] PBDSURG_HOST_DEVICE int side_of(int corner) const noexcept {
    return corner < first_corners ? 0 : 1;
  }
  /// Where one of them is.
  [[nodiscard]] PBDSURG_HOST_DEVICE Index place_on(int side) const noexcept {
    return places[first_of(side)];
  }
};

/// What a substep leaves to the next of a contact.
struct alignas(16) RememberedTouch {
  /// Puts the places of two edges in the order of a slot, after these have got other numbers.
  void sort_edges();

  TouchSlot slot;
  Vec3<float> normal;    ///< the side on which the vertex or the first edge is
  float force = 0;       ///< N, along it
  Vec3<float> friction;  ///< N
};

}  // namespace pbdsurg
