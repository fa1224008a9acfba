// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Where two edges cross, for one pair, on a CPU or a device. Edges meet where each passes the
/// other between its ends; ends are vertices, see touch_meeting.h.

#include <cmath>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/base/segment.h"
#include "lib/solver/methods/touch_meeting.h"
#include "lib/solver/state/tissue_touch.h"
#include "lib/solver/state/touch_features.h"

namespace pbdsurg {

/// Two edges where a substep starts.
/// @tparam Start  see touch_meeting.h
template <class Start>
class EdgeCrossing {
 public:
  /// @param first  the one of the two whose ends are smaller
  PBDSURG_HOST_DEVICE EdgeCrossing(const Start& start, const CrossingEdge& first,
                                   const CrossingEdge& second)
      : start_(start), edges_{&first, &second} {
    for (int edge = 0; edge < 2; ++edge) {
      starts_[edge] = start.position(edges_[edge]->ends[0]);
      ways_[edge] = start.position(edges_[edge]->ends[1]) - starts_[edge];
    }
    const auto [a, b] =
        closest_of_segments(starts_[0], starts_[0] + ways_[0], starts_[1], starts_[1] + ways_[1]);
    shares_[0] = a;
    shares_[1] = b;
    between_ = starts_[0] + a * ways_[0] - starts_[1] - b * ways_[1];
    distance_ = std::sqrt(dot(between_, between_));
  }

  /// m
  [[nodiscard]] PBDSURG_HOST_DEVICE float distance() const { return distance_; }

  [[nodiscard]] PBDSURG_HOST_DEVICE TouchSlot slot() const {
    const auto& first = edges_[0]->ends;
    const auto& second = edges_[1]->ends;
    return slot_of_edges(first[0], first[1], second[0], second[1]);
  }

  /// Where each passes the other between its ends, and not along it.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool do_cross() const {
    constexpr float kEnd = 1e-4F, kParallel = 1e-6F;
    const auto is_inside = [](float share) { return share > kEnd && share < 1 - kEnd; };
    const float square = dot(across(), across());
    return is_finite_number(distance_) && is_inside(shares_[0]) && is_inside(shares_[1]) &&
           square > kParallel * dot(ways_[0], ways_[0]) * dot(ways_[1], ways_[1]);
  }

  /// The contact of edges that cross.
  /// @param known  of the last substep; may be null
  /// @return       whether they meet
  [[nodiscard]] PBDSURG_HOST_DEVICE bool meet(float thickness, const RememberedTouch* known,
                                              TissueTouch& touch, float& distance) const {
    // The side: as before; else out of what is solid, or where they are.
    const Vec3<float> away = distance_ > 0 ? between_ : across();
    float side = 1;
    if (known != nullptr) {
      side = dot(away, known->normal) < 0 ? -1.0F : 1.0F;
    } else if (!edges_[1]->is_two_sided) {
      side = dot(away, outwards(1)) < 0 ? -1.0F : 1.0F;
    } else if (!edges_[0]->is_two_sided) {
      side = dot(away, outwards(0)) > 0 ? -1.0F : 1.0F;
    }
    touch = {};
    touch.normal = (side / std::sqrt(dot(away, away))) * away;
    if (leans(0, -1.0F * touch.normal) || leans(1, touch.normal)) {
      return false;
    }
    touch.slot = slot();
    touch.first_corners = 2;
    for (int edge = 0; edge < 2; ++edge) {
      const float sign = edge == 0 ? 1.0F : -1.0F;
      touch.bodies[edge] = edges_[edge]->body;
      touch.places[2 * edge] = edges_[edge]->ends[0];
      touch.places[2 * edge + 1] = edges_[edge]->ends[1];
      touch.weights[2 * edge] = sign * (1 - shares_[edge]);
      touch.weights[2 * edge + 1] = sign * shares_[edge];
    }
    distance = side * distance_;
    return is_within_reach(start_, touch, thickness, distance);
  }

 private:
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> across() const {  // m^2
    return cross(ways_[0], ways_[1]);
  }

  /// From an edge to a corner, at right angles to the edge.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> into(int edge, Index corner) const {
    const Vec3<float> to = start_.position(corner) - starts_[edge];
    return to - (dot(to, ways_[edge]) / dot(ways_[edge], ways_[edge])) * ways_[edge];
  }

  /// Whether a normal that points away from an edge leans over a triangle there. Then the inside of
  /// that triangle is nearer, and one of its corners or other edges meets it.
  [[nodiscard]] PBDSURG_HOST_DEVICE bool leans(int edge, const Vec3<float>& normal) const {
    constexpr float kLean = 0.2F;  // of sines
    for (const Index corner : edges_[edge]->opposite) {
      if (corner == kInvalidIndex) {
        continue;
      }
      const Vec3<float> in = into(edge, corner);
      const float along = dot(normal, in);
      if (along > 0 && along * along > kLean * kLean * dot(in, in)) {
        return true;
      }
    }
    return false;
  }

  /// The sum of the normals of the triangles at an edge of a solid body.
  [[nodiscard]] PBDSURG_HOST_DEVICE Vec3<float> outwards(int edge) const {
    Vec3<float> sum;
    for (int k = 0; k < 2; ++k) {
      if (edges_[edge]->opposite[k] != kInvalidIndex) {
        const Vec3<float> normal = cross(ways_[edge], into(edge, edges_[edge]->opposite[k]));
        const float length = std::sqrt(dot(normal, normal));
        sum = sum + ((k == 0 ? 1 : -1) / length) * normal;
      }
    }
    return sum;
  }

  const Start& start_;
  const CrossingEdge* edges_[2];
  Vec3<float> starts_[2], ways_[2];
  float shares_[2];
  Vec3<float> between_;  // m, to the first
  float distance_;
};

}  // namespace pbdsurg
