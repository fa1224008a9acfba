// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/edge_touches.h"

#include <array>
#include <utility>

#include "lib/base/segment.h"
#include "lib/solver/methods/touch_tree.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;
using SurfaceEdge = ContactBodies::Edge;
using EdgeEnds = std::array<Index, 2>;

// Of sines: by how much the way between two edges may lean over a triangle that is at one of them.
// Beyond, the inside of that triangle is nearer, and one of its corners or other edges meets it.
constexpr float kLean = 0.2F;

EdgeCandidate candidate_of(const SurfaceEdge& first, Index first_body, const SurfaceEdge& second,
                           Index second_body, Index pair, float distance) {
  if (second.ends < first.ends) {
    return candidate_of(second, second_body, first, first_body, pair, distance);
  }
  return {{{first.ends[1], second.ends[0], second.ends[1]}, first.ends[0], kInvalidIndex},
          pair,
          {first_body, second_body},
          {first.opposite, second.opposite},
          distance};
}

// Two edges where a substep starts.
class CrossingEdges {
 public:
  CrossingEdges(const TouchStart& start, const EdgeEnds& first, const EdgeEnds& second)
      : start_(start),
        starts_{start.position(first[0]), start.position(second[0])},
        ways_{start.position(first[1]) - starts_[0], start.position(second[1]) - starts_[1]} {
    const auto [a, b] =
        closest_of_segments(starts_[0], starts_[0] + ways_[0], starts_[1], starts_[1] + ways_[1]);
    shares_ = {a, b};
    between_ = starts_[0] + a * ways_[0] - starts_[1] - b * ways_[1];
    distance_ = std::sqrt(dot(between_, between_));
  }

  [[nodiscard]] float distance() const { return distance_; }                 // m
  [[nodiscard]] const Vector& between() const { return between_; }           // m, to the first
  [[nodiscard]] float share(int edge) const { return shares_[edge]; }        // from its first end
  [[nodiscard]] Vector across() const { return cross(ways_[0], ways_[1]); }  // m^2

  // Where each passes the other between its ends, and not along it.
  [[nodiscard]] bool do_cross() const {
    constexpr float kEnd = 1e-4F, kParallel = 1e-6F;
    const auto is_inside = [](float share) { return share > kEnd && share < 1 - kEnd; };
    const float square = dot(across(), across());
    return std::isfinite(distance_) && is_inside(shares_[0]) && is_inside(shares_[1]) &&
           square > kParallel * dot(ways_[0], ways_[0]) * dot(ways_[1], ways_[1]);
  }

  // Whether a normal that points away from an edge leans over a triangle there.
  [[nodiscard]] bool leans(int edge, const Vector& normal, const EdgeEnds& opposite) const {
    for (const Index corner : opposite) {
      if (corner == kInvalidIndex) {
        continue;
      }
      const Vector in = into(edge, corner);
      const float along = dot(normal, in);
      if (along > 0 && along * along > kLean * kLean * dot(in, in)) {
        return true;
      }
    }
    return false;
  }

  // The sum of the normals of the triangles at an edge of a solid body.
  [[nodiscard]] Vector outwards(int edge, const EdgeEnds& opposite) const {
    Vector sum;
    for (int k = 0; k < 2; ++k) {
      if (opposite[k] != kInvalidIndex) {
        const Vector normal = cross(ways_[edge], into(edge, opposite[k]));
        const float length = std::sqrt(dot(normal, normal));
        sum = sum + ((k == 0 ? 1 : -1) / length) * normal;
      }
    }
    return sum;
  }

 private:
  // From an edge to a corner, at right angles to the edge.
  [[nodiscard]] Vector into(int edge, Index corner) const {
    const Vector to = start_.position(corner) - starts_[edge];
    return to - (dot(to, ways_[edge]) / dot(ways_[edge], ways_[edge])) * ways_[edge];
  }

  const TouchStart& start_;
  std::array<Vector, 2> starts_, ways_;
  std::array<float, 2> shares_{};
  Vector between_;
  float distance_ = 0;
};

}  // namespace

void find_edges(const TouchStart& start, const ContactBodies& bodies, Index pair, float reach,
                TissueTouches::Search& search) {
  const ContactPair& both = bodies.pairs()[pair];
  const ContactBodies::Body& first = bodies.body(both.first);
  const ContactBodies::Body& second = bodies.body(both.second);
  const bool is_itself = &first == &second;
  const float apart = kDeepestTouch * both.contact.thickness;  // at rest
  const TouchTree& tree =
      search.edge_trees[static_cast<std::size_t>(&second - bodies.bodies().data())];
  for (const SurfaceEdge& edge : first.edges) {
    visit_near(tree, box_of(edge.ends, start.positions()), reach, [&](Index i) {
      const SurfaceEdge& other = second.edges[i];
      if ((is_itself && !(edge.ends < other.ends)) ||
          !bodies.may_meet(edge, first.body, other, second, apart)) {
        return;
      }
      const float distance = CrossingEdges(start, edge.ends, other.ends).distance();
      if (distance < reach) {
        search.edges.push_back(candidate_of(edge, first.body, other, second.body, pair, distance));
      }
    });
  }
}

void meet_edges(const TouchStart& start, const ContactBodies& bodies,
                const EdgeCandidate& candidate, float limit, float nearer_by) {
  if (!(candidate.distance - nearer_by < limit)) {
    return;
  }
  const TissueContact& settings = bodies.pairs()[candidate.pair].contact;
  const TouchSlot& slot = candidate.slot;
  const EdgeEnds first{slot.place, slot.edges[0]}, second{slot.edges[1], slot.edges[2]};
  const CrossingEdges edges(start, first, second);
  if (!edges.do_cross()) {
    return;
  }
  // The side: as before; else out of what is solid, or where they are.
  Vector away = edges.distance() > 0 ? edges.between() : edges.across();
  const RememberedTouch* const known = start.find_remembered(slot);
  float side = 1;
  if (known != nullptr) {
    side = dot(away, known->normal) < 0 ? -1.0F : 1.0F;
  } else if (!bodies.body(candidate.bodies[1]).is_two_sided) {
    side = dot(away, edges.outwards(1, candidate.opposite[1])) < 0 ? -1.0F : 1.0F;
  } else if (!bodies.body(candidate.bodies[0]).is_two_sided) {
    side = dot(away, edges.outwards(0, candidate.opposite[0])) > 0 ? -1.0F : 1.0F;
  }
  TissueTouch touch;
  touch.normal = (side / std::sqrt(dot(away, away))) * away;
  if (edges.leans(0, -1.0F * touch.normal, candidate.opposite[0]) ||
      edges.leans(1, touch.normal, candidate.opposite[1])) {
    return;
  }
  touch.slot = slot;
  touch.bodies = candidate.bodies;
  touch.first_corners = 2;
  touch.places = {first[0], first[1], second[0], second[1]};
  touch.weights = {1 - edges.share(0), edges.share(0), edges.share(1) - 1, -edges.share(1)};
  const float distance = side * edges.distance();
  if (start.is_within_reach(touch, settings.thickness, distance)) {
    start.add(touch, distance, settings, known);
  }
}

}  // namespace pbdsurg
