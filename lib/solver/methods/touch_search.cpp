// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/touch_search.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "lib/mesh/closest_on_triangle.h"
#include "lib/solver/methods/touch_tree.h"
#include "lib/solver/methods/vertex_motion.h"
#include "lib/solver/methods/vertex_moves.h"
#include "lib/solver/solver_options.h"
#include "lib/solver/state/load_store.h"
#include "lib/solver/state/solver_data.h"

namespace pbdsurg {
namespace {

using Vector = Vec3<float>;
using Eigen::Vector3f;

// In thicknesses: how far apart what does not move meets, how deep it may overlap, the way of a
// substep that counts, and what surfaces may move between two searches.
constexpr float kReach = 1.5F, kDeepest = 3, kWay = 8, kSlack = 2;
// Of cosines between what a vertex left last and what is near it now: beyond, it is on the other
// side of a thin wall, or of a sheet.
constexpr float kOtherWall = -0.5F, kOtherSide = -0.7F;
constexpr float kAsNear = 1e-4F;  // of a distance: what differs by less is as near

// The point of a triangle that is nearest to a vertex.
struct Nearest {
  ContactBodies::PlaceTriangle triangle;
  std::array<float, 3> weights;
  Vector3f away;      // m, to the vertex
  float distance;     // m
  Vector3f outwards;  // unit, out of the triangle
  float alignment;    // of the way to the vertex with that
};

// The search of one copy.
class TouchSearch {
 public:
  TouchSearch(const StepContext& step, const Substep<float>& lengths, StepReport& report)
      : step_(step),
        bodies_(step.data.contact_bodies),
        touches_(step.copy.touches),
        vertices_(moving_vertices(step)),
        starts_(vertices_.bases == nullptr ? step.scratch.previous.data() : vertices_.bases),
        ends_(moves_vertices(step.data.options) ? step.scratch.flights.data() : vertices_.moving),
        inverse_dt_squared_(lengths.inverse_dt_squared),
        report_(report) {
    for (const ContactPair& pair : bodies_.pairs()) {
      thickest_ = std::max(thickest_, pair.contact.thickness);
    }
  }

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
  }

 private:
  [[nodiscard]] Vector start(Index place) const { return load(starts_[place]); }

  [[nodiscard]] std::size_t index_of(const ContactBodies::Body& body) const {
    return static_cast<std::size_t>(&body - bodies_.bodies().data());
  }

  // m, likewise, to where sweeps begin
  [[nodiscard]] Vector way_from_start(Index place) const {
    return load(vertices_.moving[place]) - own_start(step_, vertices_, place);
  }

  // m^2, of the way of a vertex in this substep, as nothing stops it
  [[nodiscard]] float square_of_way(Index place) const {
    const Vector u = load(ends_[place]) - (vertices_.bases == nullptr ? start(place) : Vector{});
    return is_finite_way(u) ? dot(u, u) : 0;
  }
  [[nodiscard]] float way(Index place) const { return std::sqrt(square_of_way(place)); }

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
    const float most = kWay * thickest_;
    for (const ContactBodies::Body& body : bodies_.bodies()) {
      float most_moved = 0;  // m^2
      for_each_vertex(body, [&](Index place, std::size_t i) {
        const Vector x = start(place);
        if (!is_finite_way(x)) {  // what was lost and is no more: written by hand
          return;
        }
        const Vector d = x - search.seen[i];
        const float moved = dot(d, d), ahead = std::min(square_of_way(place), most * most);
        most_moved = std::max(most_moved, moved);
        most_way = std::max(most_way, ahead);
        is_valid = is_valid && (2 * (moved + ahead) <= search.slack * search.slack ||
                                std::sqrt(moved) + std::sqrt(ahead) <= search.slack);
      });
      search.moved[index_of(body)] = std::sqrt(most_moved);
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
        most_way_ = std::max(most_way_, std::min(way(place), kWay * thickest_));
      });
    }
    search.slack = most_way_ + kSlack * thickest_;
    const std::span<const Particle> starts(starts_, step_.copy.particles.size());
    search.trees.resize(bodies.size());
    for (std::size_t b = 0; b < bodies.size(); ++b) {
      if (search.revision != bodies_.revision()) {
        order_triangles(bodies[b].triangles, starts, search.trees[b]);
      }
      fit_boxes(bodies[b].triangles, starts, search.trees[b]);
    }
    search.revision = bodies_.revision();
    search.candidates.clear();
    const std::span<const ContactPair> pairs = bodies_.pairs();
    for (std::size_t p = 0; p < pairs.size(); ++p) {
      const ContactBodies::Body& first = bodies_.body(pairs[p].first);
      const ContactBodies::Body& second = bodies_.body(pairs[p].second);
      add_candidates(static_cast<Index>(p), first, second);
      if (&first != &second) {
        add_candidates(static_cast<Index>(p), second, first);
      }
    }
    std::ranges::sort(search.candidates);
  }

  void add_candidates(Index pair, const ContactBodies::Body& from, const ContactBodies::Body& to) {
    TissueTouches::Search& search = touches_.search;
    const TouchTree& tree = search.trees[index_of(to)];
    const float thickness = bodies_.pairs()[pair].contact.thickness;
    const float reach = kDeepest * thickness + 2 * search.slack;
    for (const Index place : from.places) {
      const Vector x = start(place);
      visit_near(tree, x, reach, [&](Index t) {
        const ContactBodies::PlaceTriangle& triangle = to.triangles[t];
        const TrianglePoint<float> point = closest(triangle, x);
        if (point.point.squaredNorm() < reach * reach &&
            bodies_.may_meet(place, from.body, triangle, to, kDeepest * thickness)) {
          search.candidates.push_back({{place, to.body}, pair, triangle, point.point.norm()});
        }
      });
    }
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
           kRounding * thickest_;
  }

  // None of a triangle without a place, or of one that faces what the vertex left last.
  [[nodiscard]] std::optional<Nearest> measure(const TouchCandidate& candidate, const Vector& x,
                                               bool is_two_sided,
                                               const RememberedTouch* known) const {
    const auto& t = candidate.triangle;
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
    const RememberedTouch* const known = find_remembered(slot);
    const float most = kWay * thickness;
    const float limit =
        std::max(kReach * thickness + 2 * std::min(most_way_, most), kDeepest * thickness);
    const std::optional<Nearest> nearest =
        find_nearest(candidates, x, limit, nearer_by(pair), is_two_sided, known);
    if (!nearest) {
      return;
    }
    const auto& [triangle, weights, away, unsigned_distance, outwards, alignment] = *nearest;
    float ways = 0, mobility = step_.copy.particles[slot.place].w;
    for (const Index corner : triangle) {
      ways = std::max(ways, way(corner));
      mobility += step_.copy.particles[corner].w;
    }
    const float reach = kReach * thickness + std::min(way(slot.place), most) + std::min(ways, most);
    const Index vertex_body = slot.body == pair.first ? pair.second : pair.first;
    const bool is_corner = std::ranges::count(weights, 0.0F) == 2;
    if (!(unsigned_distance < std::max(reach, kDeepest * thickness)) || !(mobility > 0) ||
        (is_corner && vertex_body > slot.body)) {  // the corner has a contact of its own
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
    if (!(distance < reach) || !(distance > -kDeepest * thickness)) {
      return;
    }
    if (const auto face = find_passed_face(candidates, *nearest, normal, thickness)) {
      add(slot, vertex_body, *face, load(face->outwards), face->distance, pair.contact, known);
      return;
    }
    add(slot, vertex_body, *nearest, load(normal), distance, pair.contact, known);
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
    Vector way = way_from_start(place);
    for (int k = 0; k < 3; ++k) {
      way = way - edge.weights[k] * way_from_start(edge.triangle[k]);
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

  void add(const TouchSlot& slot, Index vertex_body, const Nearest& nearest, const Vector& normal,
           float distance, const TissueContact& settings, const RememberedTouch* known) {
    if (touches_.contacts.size() >= static_cast<std::size_t>(step_.data.options.contact_capacity)) {
      ++report_.dropped_contacts;
      return;
    }
    TissueTouch touch;
    touch.slot = slot;
    touch.vertex_body = vertex_body;
    touch.places[0] = slot.place;
    touch.weights[0] = 1;
    for (int k = 0; k < 3; ++k) {
      touch.places[k + 1] = nearest.triangle[k];
      touch.weights[k + 1] = -nearest.weights[k];
    }
    touch.normal = normal;
    touch.mu = settings.friction;
    const float wanted = std::min(settings.thickness, distance + kRecovery * step_.data.part.h);
    touch.offset = vertices_.bases == nullptr ? wanted : wanted - distance;
    for (int k = 0; k < TissueTouch::kCorners; ++k) {
      touch.drift = touch.drift + touch.weights[k] * own_start(step_, vertices_, touch.places[k]);
    }
    const SolverOptions& options = step_.data.options;  // projections begin anew
    if (known != nullptr && moves_vertices(options) && !is_explicit(options)) {
      touch.multiplier = known->force / inverse_dt_squared_;
      const Vector along = known->friction - dot(known->friction, normal) * normal;
      touch.friction = (1 / inverse_dt_squared_) * along;
    }
    touches_.contacts.push_back(touch);
  }

  [[nodiscard]] const RememberedTouch* find_remembered(const TouchSlot& slot) const {
    const auto found =
        std::ranges::lower_bound(touches_.remembered, slot, {}, &RememberedTouch::slot);
    return found != touches_.remembered.end() && found->slot == slot ? &*found : nullptr;
  }

  const StepContext& step_;
  const ContactBodies& bodies_;
  TissueTouches& touches_;
  MovingVertices vertices_;
  const Particle* starts_;
  const Particle* ends_;  // of its free way in this substep; displacements, where starts are bases
  float inverse_dt_squared_;
  StepReport& report_;
  float thickest_ = 0;
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
