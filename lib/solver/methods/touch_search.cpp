// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_search.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lib/mesh/closest_on_triangle.h"
#include "lib/solver/methods/edge_touches.h"
#include "lib/solver/methods/touch_start.h"
#include "lib/solver/methods/touch_tree.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;
using Eigen::Vector3f;

constexpr float kSlack = 2;       // thicknesses that surfaces may move between two searches
constexpr std::size_t kRoom = 8;  // candidates a vertex: with more, lists grow in a step
// Of cosines between what a vertex left last and what is near it now: beyond, it is on the other
// side of a thin wall, or of a sheet.
constexpr float kOtherWall = -0.5F, kOtherSide = -0.7F;
constexpr float kAsNear = 1e-4F;  // of a distance: what differs by less is as near

// The point of a triangle, or of a link, that is nearest to a vertex.
struct Nearest {
  ContactBodies::PlaceTriangle triangle;
  std::array<float, 3> weights;
  Vector3f away;      // m, to the vertex
  float distance;     // m
  Vector3f outwards;  // unit, out of the triangle; of a link, to the vertex
  float alignment;    // of the way to the vertex with that
};

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
    const std::vector<TouchCandidate>& candidates = touches_.search.candidates;
    for (auto first = candidates.begin(); first != candidates.end();) {
      const auto end = std::find_if(first, candidates.end(),
                                    [&](const TouchCandidate& c) { return c.slot != first->slot; });
      meet({first, end});
      first = end;
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
    most_way_ = 0;
    for (const ContactBodies::Body& body : bodies) {
      for_each_vertex(body, [&](Index place, std::size_t i) {
        search.seen[i] = start(place);
        most_way_ = std::max(most_way_, std::min(start_.way(place), kTouchWay * start_.thickest()));
      });
    }
    search.slack = most_way_ + kSlack * start_.thickest();
    search.trees.resize(bodies.size());
    search.edge_trees.resize(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (search.revision != bodies_.revision()) {
        order(bodies[b].triangles, start_.positions(), search.trees[b]);
        order(bodies[b].edges, start_.positions(), search.edge_trees[b]);
      }
      fit_boxes(bodies[b].triangles, start_.positions(), search.trees[b]);
      fit_boxes(bodies[b].edges, start_.positions(), search.edge_trees[b]);
    }
    search.revision = bodies_.revision();
    search.candidates.clear();
    search.edges.clear();
    search.candidates.reserve(kRoom * search.seen.size());
    search.edges.reserve(kRoom * search.seen.size());
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
    std::ranges::sort(search.candidates);
    std::ranges::sort(search.edges);
  }

  void add_candidates(Index pair, const ContactBodies::Body& from, const ContactBodies::Body& to) {
    TissueTouches::Search& search = touches_.search;
    const TouchTree& tree = search.trees[index_of(to)];
    const float thickness = bodies_.pairs()[pair].contact.thickness;
    const float reach = reach_of(bodies_.pairs()[pair]);
    for (const Index place : from.places) {
      const Vector x = start(place);
      visit_near(tree, {x, x}, reach, [&](Index t) {
        const ContactBodies::PlaceTriangle& triangle = to.triangles[t];
        const TrianglePoint<float> point = closest(triangle, x);
        if (point.point.squaredNorm() < reach * reach &&
            bodies_.may_meet(place, from.body, triangle, to, kDeepestTouch * thickness)) {
          search.candidates.push_back(
              {{.place = place, .body = to.body}, pair, triangle, point.point.norm()});
        }
      });
    }
  }

  // m, how near surfaces come to meet before the next search.
  [[nodiscard]] float reach_of(const ContactPair& pair) const {
    return kDeepestTouch * pair.contact.thickness + 2 * touches_.search.slack;
  }

  // m, how far apart what meets in this substep may be, by the fastest of all.
  [[nodiscard]] float limit_of(const ContactPair& pair) const {
    const float thickness = pair.contact.thickness;
    return std::max(kTouchReach * thickness + 2 * std::min(most_way_, kTouchWay * thickness),
                    kDeepestTouch * thickness);
  }

  // From the vertex at x.
  [[nodiscard]] TrianglePoint<float> closest(const ContactBodies::PlaceTriangle& triangle,
                                             const Vector& x) const {
    return closest_on_triangle<float>(vector_of(start(triangle[0]) - x),
                                      vector_of(start(triangle[1]) - x),
                                      vector_of(start(triangle[2]) - x), Vector3f::Zero());
  }

  // m, what both bodies of a pair may have come nearer since the last search.
  [[nodiscard]] float nearer_by(const ContactPair& pair) const {
    constexpr float kRounding = 1e-3F;  // of a thickness
    const std::vector<float>& moved = touches_.search.moved;
    return moved[index_of(bodies_.body(pair.first))] + moved[index_of(bodies_.body(pair.second))] +
           kRounding * start_.thickest();
  }

  // None of a triangle without a place, or of one that faces what the vertex left last.
  [[nodiscard]] std::optional<Nearest> measure(const TouchCandidate& candidate, const Vector& x,
                                               bool is_two_sided,
                                               const RememberedTouch* known) const {
    const auto& t = candidate.triangle;
    if (t[1] == t[2]) {
      return measure_link(t, x);
    }
    const Vector3f outwards =
        vector_of(cross(start(t[1]) - start(t[0]), start(t[2]) - start(t[0]))).normalized();
    if (known != nullptr && !is_two_sided && outwards.dot(vector_of(known->normal)) < kOtherWall) {
      return std::nullopt;
    }
    const TrianglePoint<float> point = closest(t, x);
    const float distance = point.point.norm();
    if (!std::isfinite(distance) || !outwards.allFinite()) {
      return std::nullopt;
    }
    const Vector3f away = -point.point;
    return Nearest{t,        point.weights, away,
                   distance, outwards,      distance > 0 ? outwards.dot(away) / distance : 1.0F};
  }

  // What is on a link is nowhere beside it.
  [[nodiscard]] std::optional<Nearest> measure_link(const ContactBodies::PlaceTriangle& link,
                                                    const Vector& x) const {
    const Vector3f a = vector_of(start(link[0]) - x), b = vector_of(start(link[1]) - x);
    const Vector3f along = b - a;
    const float share = std::clamp(-a.dot(along) / along.squaredNorm(), 0.0F, 1.0F);
    const Vector3f away = -(a + share * along);
    const float distance = away.norm();
    if (!(distance > 0) || !std::isfinite(distance)) {
      return std::nullopt;
    }
    return Nearest{link, {1 - share, share, 0}, away, distance, away / distance, 1};
  }

  // Of triangles at a corner or an edge, the one that faces the vertex most, or turns away from it
  // most: it tells the side.
  // @param limit      m, what is no nearer does not count
  // @param nearer_by  m, than candidates were
  [[nodiscard]] std::optional<Nearest> find_nearest(std::span<const TouchCandidate> candidates,
                                                    const Vector& x, float limit, float nearer_by,
                                                    bool is_two_sided,
                                                    const RememberedTouch* known) const {
    const auto first = std::ranges::min_element(candidates, {}, &TouchCandidate::distance);
    if (!(first->distance - nearer_by < limit)) {
      return std::nullopt;
    }
    const std::optional<Nearest> likely = measure(*first, x, is_two_sided, known);
    std::optional<Nearest> best;
    for (auto c = candidates.begin(); c != candidates.end(); ++c) {
      const float nearest =
          std::min(likely ? likely->distance : limit, best ? best->distance : limit);
      if (c->distance - nearer_by > (1 + kAsNear) * nearest) {
        continue;
      }
      const std::optional<Nearest> met = c == first ? likely : measure(*c, x, is_two_sided, known);
      if (!met) {
        continue;
      }
      const float alignment = std::abs(met->alignment);
      const bool is_nearer = !best || met->distance < (1 - kAsNear) * best->distance;
      const bool is_as_near = best && met->distance <= (1 + kAsNear) * best->distance;
      if (is_nearer || (is_as_near && alignment > std::abs(best->alignment) + kAsNear)) {
        best = met;
      }
    }
    return best;
  }

  void meet(std::span<const TouchCandidate> candidates) {
    const TouchSlot& slot = candidates.front().slot;
    const ContactPair& pair = bodies_.pairs()[candidates.front().pair];
    const float thickness = pair.contact.thickness;
    const Vector x = start(slot.place);
    if (!is_finite_way(x)) {
      return;
    }
    const bool is_two_sided = bodies_.body(slot.body).is_two_sided;
    const RememberedTouch* const known = start_.find_remembered(slot);
    const std::optional<Nearest> nearest =
        find_nearest(candidates, x, limit_of(pair), nearer_by(pair), is_two_sided, known);
    if (!nearest) {
      return;
    }
    const auto& [triangle, weights, away, unsigned_distance, outwards, alignment] = *nearest;
    const Index vertex_body = slot.body == pair.first ? pair.second : pair.first;
    const bool is_corner = std::ranges::count(weights, 0.0F) == 2;
    if (is_corner && vertex_body > slot.body) {  // the corner has a contact of its own
      return;
    }
    Vector3f normal = outwards;
    float distance = 0;
    if (unsigned_distance > 0) {
      float side = alignment < 0 ? -1.0F : 1.0F;
      const Vector3f towards = away / unsigned_distance;
      if (is_two_sided) {
        side =
            known != nullptr && towards.dot(vector_of(known->normal)) < kOtherSide ? -1.0F : 1.0F;
      }
      distance = side * unsigned_distance;
      normal = side * towards;
    } else if (known != nullptr) {
      normal = vector_of(known->normal);
    }
    TissueTouch touch = touch_of(slot, vertex_body, *nearest, load(normal));
    if (!start_.is_within_reach(touch, thickness, distance)) {
      return;
    }
    if (const auto face = find_passed_face(candidates, *nearest, normal, thickness)) {
      touch = touch_of(slot, vertex_body, *face, load(face->outwards));
      distance = face->distance;
    }
    start_.add(touch, distance, pair.contact, known);
  }

  [[nodiscard]] static TissueTouch touch_of(const TouchSlot& slot, Index vertex_body,
                                            const Nearest& nearest, const Vector& normal) {
    TissueTouch touch;
    touch.slot = slot;
    touch.bodies = {vertex_body, slot.body};
    touch.places[0] = slot.place;
    touch.weights[0] = 1;
    for (int k = 0; k < 3; ++k) {
      touch.places[k + 1] = nearest.triangle[k];
      touch.weights[k + 1] = -nearest.weights[k];
    }
    touch.normal = normal;
    return touch;
  }

  // What slides on a surface comes near edges of it, and is none the nearer for that: the plane of
  // an edge would stop it there. So where that would push in this substep and one face at the edge
  // would do so less, and is as far away as surfaces should be, it stands for the edge, beyond its
  // own triangle.
  [[nodiscard]] std::optional<Nearest> find_passed_face(std::span<const TouchCandidate> candidates,
                                                        const Nearest& edge, const Vector3f& normal,
                                                        float thickness) const {
    constexpr float kRest = 0.9F;  // of the thickness, where surfaces lie on each other
    if (std::ranges::count(edge.weights, 0.0F) == 0 || !(edge.distance > thickness)) {
      return std::nullopt;
    }
    const Index place = candidates.front().slot.place;
    Vector way = start_.way_from_start(place);
    for (int k = 0; k < 3; ++k) {
      way = way - edge.weights[k] * start_.way_from_start(edge.triangle[k]);
    }
    const Vector3f ahead = edge.away + vector_of(way);
    float most = normal.dot(ahead);
    std::optional<Nearest> passed;
    for (const TouchCandidate& candidate : candidates) {
      if (!(most < thickness)) {
        break;
      }
      const auto& t = candidate.triangle;
      const bool is_at_edge = std::ranges::all_of(std::array{0, 1, 2}, [&](int k) {
        return edge.weights[k] == 0 || std::ranges::find(t, edge.triangle[k]) != t.end();
      });
      if (!is_at_edge) {
        continue;
      }
      const Vector3f a = vector_of(start(t[0]) - start(place));
      const Vector3f ab = vector_of(start(t[1]) - start(t[0]));
      const Vector3f ac = vector_of(start(t[2]) - start(t[0]));
      const Vector3f across = ab.cross(ac), outwards = across.normalized();
      const float distance = outwards.dot(edge.away), clear = outwards.dot(ahead);
      if (distance > kRest * thickness && clear > most) {
        const Vector3f at = -distance * outwards - a;
        const float b = across.dot(at.cross(ac)) / across.squaredNorm();
        const float c = across.dot(ab.cross(at)) / across.squaredNorm();
        most = clear;
        passed = {t, {1 - b - c, b, c}, distance * outwards, distance, outwards, 1};
      }
    }
    return passed;
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
