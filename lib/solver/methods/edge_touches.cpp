// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/edge_touches.h"

#include "lib/solver/methods/edge_crossing.h"
#include "lib/solver/methods/touch_tree.h"

namespace pbdsurg {
namespace {

using SurfaceEdge = ContactBodies::Edge;

CrossingEdge crossing_edge(const ContactBodies::Body& body, const SurfaceEdge& edge) {
  return {{edge.ends[0], edge.ends[1]},
          {edge.opposite[0], edge.opposite[1]},
          body.body,
          body.is_two_sided};
}

// Each end of one with both of the other.
bool may_meet(const TouchRules& rules, const CrossingEdge& edge, const CrossingEdge& other,
              float near) {
  const Index link[] = {other.ends[0], other.ends[1], other.ends[1]};
  return rules.may_meet(edge.ends[0], link, edge.body == other.body, near) &&
         rules.may_meet(edge.ends[1], link, edge.body == other.body, near);
}

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
    const CrossingEdge own = crossing_edge(first, edge);
    visit_near(tree, box_of(edge.ends, start.positions()), reach, [&](Index i) {
      if (is_itself && !(edge.ends < second.edges[i].ends)) {
        return;
      }
      const CrossingEdge other = crossing_edge(second, second.edges[i]);
      if (!may_meet(bodies.rules(), own, other, apart)) {
        return;
      }
      const bool is_first = edge.ends < second.edges[i].ends;
      const EdgeCrossing crossing(start, is_first ? own : other, is_first ? other : own);
      if (crossing.distance() < reach) {
        search.edges.push_back({crossing.slot(), pair, is_first ? own : other,
                                is_first ? other : own, crossing.distance()});
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
  const EdgeCrossing crossing(start, candidate.first, candidate.second);
  const RememberedTouch* const known = start.find_remembered(candidate.slot);
  TissueTouch touch;
  float distance = 0;
  if (crossing.do_cross() && crossing.meet(settings.thickness, known, touch, distance)) {
    start.add(touch, distance, settings, known);
  }
}

}  // namespace pbdsurg
