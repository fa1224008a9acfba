// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_search.h"

#include <algorithm>
#include <cmath>
#include <span>

#include "lib/solver/methods/edge_touches.h"
#include "lib/solver/methods/touch_meeting.h"
#include "lib/solver/methods/touch_start.h"
#include "lib/solver/methods/touch_tree.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;

// Candidates and slots a vertex, and candidates of one: with more, lists grow in a step.
constexpr std::size_t kRoom = 8, kRoomOfSlots = 2, kRoomOfOne = 256;

// The search of one copy.
class TouchSearch {
 public:
  TouchSearch(const StepContext& step, const Substep<float>& lengths, StepReport& report)
      : start_(step, lengths, report),
        bodies_(step.data.contact_bodies),
        touches_(step.copy.touches) {}

  void run() {
    if (!is_search_valid()) {
      search();
    }
    touches_.contacts.clear();
    for (const TouchCandidates& candidates : touches_.search.slots) {
      meet(candidates);
    }
    for (const EdgeCandidate& candidate : touches_.search.edges) {
      const ContactPair& pair = bodies_.pairs()[candidate.pair];
      meet_edges(start_, bodies_, candidate, limit_of(pair), nearer_by(pair));
    }
  }

 private:
  [[nodiscard]] Vector start(Index place) const { return start_.position(place); }

  [[nodiscard]] std::size_t index_of(const ContactBodies::Body& body) const {
    return static_cast<std::size_t>(&body - bodies_.bodies().data());
  }

  template <class Visit>
  static void for_each_vertex(const ContactBodies::Body& body, const Visit& visit) {
    for (std::size_t i = 0; i < body.places.size(); ++i) {
      visit(body.places[i], static_cast<std::size_t>(body.first_vertex) + i);
    }
  }

  [[nodiscard]] bool is_search_valid() {
    TissueTouches::Search& search = touches_.search;
    if (search.revision != bodies_.revision()) {
      return false;
    }
    float most_way = 0;  // m^2
    bool is_valid = true;
    const float most = kTouchWay * start_.thickest();
    // by the farthest and the fastest of each body, which corners of one edge may be
    for (const ContactBodies::Body& body : bodies_.bodies()) {
      float most_moved = 0, most_ahead = 0;  // m^2
      for_each_vertex(body, [&](Index place, std::size_t i) {
        const Vector x = start(place);
        if (!is_finite_way(x)) {  // what was lost and is no more: written by hand
          return;
        }
        const Vector d = x - search.seen[i];
        const float moved = dot(d, d), ahead = std::min(start_.square_of_way(place), most * most);
        search.moved_squares[static_cast<std::size_t>(place)] = moved;
        most_moved = std::max(most_moved, moved);
        most_ahead = std::max(most_ahead, ahead);
      });
      most_way = std::max(most_way, most_ahead);
      search.moved[index_of(body)] = std::sqrt(most_moved);
      is_valid = is_valid && std::sqrt(most_moved) + std::sqrt(most_ahead) <= search.slack;
    }
    most_way_ = std::sqrt(most_way);
    return is_valid;
  }

  void search() {
    TissueTouches::Search& search = touches_.search;
    search.seen.resize(static_cast<std::size_t>(bodies_.vertex_count()));
    const std::span<const ContactBodies::Body> bodies = bodies_.bodies();
    search.moved.assign(bodies.size(), 0);
    search.moved_squares.assign(start_.positions().size(), 0);
    most_way_ = 0;
    for (const ContactBodies::Body& body : bodies) {
      for_each_vertex(body, [&](Index place, std::size_t i) {
        search.seen[i] = start(place);
        most_way_ = std::max(most_way_, std::min(start_.way(place), kTouchWay * start_.thickest()));
      });
    }
    search.slack = most_way_ + kTouchSlack * start_.thickest();
    search.trees.resize(bodies.size());
    search.edge_trees.resize(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (search.trees[b].body != bodies[b].revision) {
        order(bodies[b].triangles, start_.positions(), search.trees[b]);
        order(bodies[b].edges, start_.positions(), search.edge_trees[b]);
        search.trees[b].body = bodies[b].revision;
      }
      fit_boxes(bodies[b].triangles, start_.positions(), search.trees[b]);
      fit_boxes(bodies[b].edges, start_.positions(), search.edge_trees[b]);
    }
    search.revision = bodies_.revision();
    search.candidates.clear();
    search.slots.clear();
    search.edges.clear();
    search.candidates.reserve(kRoom * search.seen.size());
    search.slots.reserve(kRoomOfSlots * search.seen.size());
    search.edges.reserve(kRoom * search.seen.size());
    search.near.reserve(kRoomOfOne);
    const std::span<const ContactPair> pairs = bodies_.pairs();
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const ContactBodies::Body& first = bodies_.body(pairs[p].first);
      const ContactBodies::Body& second = bodies_.body(pairs[p].second);
      add_candidates(static_cast<Index>(p), first, second);
      if (&first != &second) {
        add_candidates(static_cast<Index>(p), second, first);
      }
      find_edges(start_, bodies_, static_cast<Index>(p), reach_of(pairs[p]), search);
    }
    std::ranges::sort(search.slots, {}, &TouchCandidates::slot);
    std::ranges::sort(search.edges, {}, &EdgeCandidate::slot);
  }

  void add_candidates(Index pair, const ContactBodies::Body& from, const ContactBodies::Body& to) {
    TissueTouches::Search& search = touches_.search;
    const TouchTree& tree = search.trees[index_of(to)];
    const float thickness = bodies_.pairs()[pair].contact.thickness;
    const float reach = reach_of(bodies_.pairs()[pair]);
    for (const Index place : from.places) {
      const std::size_t before = search.candidates.size();
      const Vector x = start(place);
      visit_near(tree, {x, x}, reach, [&](Index t) {
        const Index* const corners = corners_of(to, t);
        NearPoint near;
        if (is_box_near(corners, x, reach) && find_near(start_, place, corners, nullptr, near) &&
            near.distance < reach &&
            bodies_.rules().may_meet(place, corners, from.body == to.body,
                                     kDeepestTouch * thickness)) {
          search.candidates.push_back({t, near.distance});
        }
      });
      const std::span<TouchCandidate> own = std::span(search.candidates).subspan(before);
      if (!own.empty()) {
        std::ranges::sort(own, {}, &TouchCandidate::triangle);
        const auto nearest = std::ranges::min_element(own, {}, &TouchCandidate::distance);
        search.slots.push_back({slot_of_vertex(place, to.body), pair, static_cast<Index>(before),
                                static_cast<Index>(own.size()),
                                static_cast<Index>(nearest - own.begin())});
      }
    }
  }

  // Whether a point is within reach of the box of a triangle: of those in near leaves two thirds
  // are not, and to see that takes a fraction of find_near().
  [[nodiscard]] bool is_box_near(const Index* corners, const Vector& x, float reach) const {
    const Vector a = start(corners[0]) - x, b = start(corners[1]) - x, c = start(corners[2]) - x;
    const auto is_near = [reach](float p, float q, float r) {
      return std::min({p, q, r}) < reach && std::max({p, q, r}) > -reach;
    };
    return is_near(a.x, b.x, c.x) && is_near(a.y, b.y, c.y) && is_near(a.z, b.z, c.z);
  }

  // m, how near surfaces come to meet before the next search.
  [[nodiscard]] float reach_of(const ContactPair& pair) const {
    return kDeepestTouch * pair.contact.thickness + 2 * touches_.search.slack;
  }

  // m, in this substep, by the fastest of all.
  [[nodiscard]] float limit_of(const ContactPair& pair) const {
    return touch_limit(pair.contact.thickness, most_way_);
  }

  [[nodiscard]] static const Index* corners_of(const ContactBodies::Body& body, Index triangle) {
    return body.triangles[triangle].data();
  }

  // m, of rounding.
  [[nodiscard]] float rounding() const { return 1e-3F * start_.thickest(); }

  // m, what both bodies of a pair may have come nearer since the last search.
  [[nodiscard]] float nearer_by(const ContactPair& pair) const {
    const std::vector<float>& moved = touches_.search.moved;
    return moved[index_of(bodies_.body(pair.first))] + moved[index_of(bodies_.body(pair.second))] +
           rounding();
  }

  // m^2, that a place has moved since then.
  [[nodiscard]] float square_moved(Index place) const {
    return touches_.search.moved_squares[static_cast<std::size_t>(place)];
  }

  // Whether anything that a vertex may meet can have come within a limit, m.
  [[nodiscard]] bool is_any_near(const TouchCandidates& slot, const ContactBodies::Body& body,
                                 float limit) const {
    const TouchCandidate& nearest = candidates_of(slot)[static_cast<std::size_t>(slot.nearest)];
    return nearest.distance - std::sqrt(square_moved(slot.slot.place)) - rounding() -
               touches_.search.moved[index_of(body)] <
           limit;
  }

  // Lists what may be nearest.
  // @param limit  m, what is no nearer does not count
  // @return       m, the least distance
  float list_near(const TouchCandidates& slot, const ContactBodies::Body& body, float limit,
                  const Vector* left) {
    std::vector<NearPoint>& near = touches_.search.near;
    near.clear();
    const Index place = slot.slot.place;
    const float own_way = std::sqrt(square_moved(place)) + rounding();
    const std::span<const TouchCandidate> candidates = candidates_of(slot);
    const TouchCandidate& likely = candidates[static_cast<std::size_t>(slot.nearest)];
    const float moved = touches_.search.moved[index_of(body)];
    NearPoint likely_point, point;
    float least = limit;
    // whether a candidate may be as near as that, by what its body, then by what its corners moved
    const auto may_be_nearest = [&](const TouchCandidate& candidate) {
      const float beyond = candidate.distance - own_way - (1 + kAsNear) * least;
      if (beyond > moved) {
        return false;
      }
      const Index* const corners = corners_of(body, candidate.triangle);
      const float square =
          std::max({square_moved(corners[0]), square_moved(corners[1]), square_moved(corners[2])});
      return !(beyond > 0) || beyond * beyond <= square;
    };
    const bool has_likely =
        may_be_nearest(likely) &&
        find_near(start_, place, corners_of(body, likely.triangle), left, likely_point);
    if (has_likely) {
      least = std::min(least, likely_point.distance);
    }
    for (const TouchCandidate& candidate : candidates) {
      if (&candidate == &likely) {
        if (has_likely) {
          near.push_back(likely_point);
        }
      } else if (may_be_nearest(candidate) &&
                 find_near(start_, place, corners_of(body, candidate.triangle), left, point)) {
        least = std::min(least, point.distance);
        near.push_back(point);
      }
    }
    return least;
  }

  // Of a list.
  [[nodiscard]] const NearPoint* find_nearest(float least) const {
    std::vector<NearPoint>& all = touches_.search.near;
    float most = -1;
    for (NearPoint& near : all) {
      if (is_as_near(near, least)) {
        face(start_, near);
        most = std::max(most, std::fabs(near.alignment));
      }
    }
    const auto found = std::ranges::find_if(all, [&](const NearPoint& near) {
      return is_as_near(near, least) && faces_as_much(near, most);
    });
    return found != all.end() ? &*found : nullptr;
  }

  [[nodiscard]] std::span<const TouchCandidate> candidates_of(const TouchCandidates& slot) const {
    return std::span(touches_.search.candidates)
        .subspan(static_cast<std::size_t>(slot.first), static_cast<std::size_t>(slot.count));
  }

  void meet(const TouchCandidates& candidates) {
    const TouchSlot& slot = candidates.slot;
    const ContactPair& pair = bodies_.pairs()[candidates.pair];
    const float thickness = pair.contact.thickness;
    if (!is_finite_way(start(slot.place))) {
      return;
    }
    const ContactBodies::Body& body = bodies_.body(slot.body);
    const float limit = limit_of(pair);
    if (!is_any_near(candidates, body, limit)) {
      return;
    }
    const RememberedTouch* const known = start_.find_remembered(slot);
    const Vector* const left = known != nullptr && !body.is_two_sided ? &known->normal : nullptr;
    const float least = list_near(candidates, body, limit, left);
    const NearPoint* const nearest = find_nearest(least);
    if (nearest == nullptr) {
      return;
    }
    const Index vertex_body = slot.body == pair.first ? pair.second : pair.first;
    if (nearest->is_corner() && vertex_body > slot.body) {  // the corner has a contact of its own
      return;
    }
    auto [normal, distance] = side_of(*nearest, body.is_two_sided, known);
    TissueTouch touch = touch_of(slot, vertex_body, *nearest, normal);
    if (!is_within_reach(start_, touch, thickness, distance)) {
      return;
    }
    const PassedEdge passed(start_, slot.place, *nearest, normal, thickness);
    float most_clear = passed.clear();
    const std::span<const TouchCandidate> faces =
        passed.has_any() ? candidates_of(candidates) : std::span<const TouchCandidate>();
    for (const TouchCandidate& candidate : faces) {
      NearPoint face;
      float clear = 0;
      if (passed.find_face(start_, corners_of(body, candidate.triangle), face, clear) &&
          clear > most_clear) {
        most_clear = clear;
        touch = touch_of(slot, vertex_body, face, face.outwards);
        distance = face.distance;
      }
    }
    start_.add(touch, distance, pair.contact, known);
  }

  TouchStart start_;
  const ContactBodies& bodies_;
  TissueTouches& touches_;
  float most_way_ = 0;  // m, of all vertices in this substep
};

}  // namespace

bool has_touches(const StepContext& step) noexcept {
  return !step.data.contact_bodies.empty();
}

void find_touches(const StepContext& step, const Substep<float>& lengths, StepReport& report) {
  if (has_touches(step)) {
    TouchSearch(step, lengths, report).run();
  }
}

void remember_touches(const StepContext& step, const Substep<float>& lengths) {
  TissueTouches& touches = step.copy.touches;
  touches.remembered.clear();
  for (const TissueTouch& touch : touches.contacts) {
    touches.remembered.push_back({touch.slot, touch.normal,
                                  lengths.inverse_dt_squared * touch.multiplier,
                                  lengths.inverse_dt_squared * touch.friction});
  }
}

}  // namespace pbdsurg
