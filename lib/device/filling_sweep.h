// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a team of threads does in a sweep with what fills a closed surface: the same bits as
/// pbdsurg/surgery/lumen.h on a CPU, since all sums are in the order of triangles and vertices.

#include <cmath>
#include <cstddef>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"
#include "pbdsurg/constraints/stiff_link.h"

#include "lib/solver/methods/displacement.h"
#include "lib/solver/methods/filling.h"
#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/methods/vertex_rows.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg::cuda {

struct FillingTriangle {
  Index corners[3];  ///< places in the list of vertices
};

/// Of a copy, on its way through a step.
struct alignas(16) FillingCopy {
  FillingState now;
  FillingSubstep substep;
  bool is_new;           ///< whether now.amount is to follow from now.pressure
  bool has_pushed;       ///< in this substep
  float compliance = 0;  ///< m^3/Pa, of the last sweep
};

/// What changes from step to step.
struct FillingInput {
  FillingLaw law;
  float h;  ///< s, of a substep
};

/// One surface and its contents. Arrays of copies are those of all; a team takes the part of its.
struct FillingArrays {
  const Index* places;               ///< [vertex] of the solver
  const FillingTriangle* triangles;  ///< [triangle] of the wall, then caps
  const Index* firsts;               ///< [vertex + 1] into:
  const Index* triangles_at;         ///< those that a vertex is of, ascending
  const Index* hole_ends;            ///< [hole] of triangles that are caps over it
  const FillingInput* input;
  FillingCopy* copies;     ///< [copy]
  FillingState* results;   ///< [copy] for the host, of what a copy has after each sweep
  Vec3<double>* ways;      ///< [copy][vertex] m
  Vec3<double>* caps;      ///< [copy][triangle] m^2, of caps twice the area along the normal
  double* volumes;         ///< [copy][triangle] m^3
  Vec3<float>* thirds;     ///< [copy][triangle] m^2
  Vec3<float>* gradients;  ///< [copy][vertex] m^2
  float* gives;            ///< [copy][vertex] m^3/Pa
  // of vertex blocks
  const Index* is_shared;  ///< [vertex] not zero where an earlier surface has the vertex, too
  const Index* pieces;     ///< [piece_count] free ones that the wall has vertices of
  Index vertex_count, triangle_count, wall_count, hole_count;
  Index piece_count;
  bool is_anchored;  ///< whether the wall has other vertices, too
  bool is_first;     ///< of the surfaces

  bool operator==(const FillingArrays&) const = default;
};

[[nodiscard]] PBDSURG_HOST_DEVICE inline FillingArrays of_copy(FillingArrays filling,
                                                               std::size_t copy) {
  const std::size_t vertices = copy * static_cast<std::size_t>(filling.vertex_count);
  const std::size_t triangles = copy * static_cast<std::size_t>(filling.triangle_count);
  filling.copies += copy;
  filling.results += copy;
  filling.ways += vertices;
  filling.caps += triangles;
  filling.volumes += triangles;
  filling.thirds += triangles;
  filling.gradients += vertices;
  filling.gives += vertices;
  return filling;
}

/// The vertices of walls within a substep, by projections: a push takes each as far as its inertia
/// lets it.
struct FreeVertices {
  const Particle* bases;  ///< [place]
  Particle* moving;       ///< [place] displacements
  float square_of_dt;     ///< s^2

  /// m, from where it was at the start of the substep.
  template <class Team>
  [[nodiscard]] PBDSURG_DEVICE Vec3<float> moved(const Team& team, Index place) const {
    return way_of(team.load(moving + place));
  }
  template <class Team>
  [[nodiscard]] PBDSURG_DEVICE Vec3<float> yield(const Team& team, Index place,
                                                 const Vec3<float>& force) const {
    return (square_of_dt * team.load(moving + place).w) * force;
  }
  /// @param way  yield() of the force
  template <class Team>
  PBDSURG_DEVICE void push(const Team& team, Index place, const Vec3<float>& force,
                           const Vec3<float>& way) const {
    const Particle p = team.load(moving + place);
    const Vec3<float> after = way_of(p) + way;
    if (leads_somewhere(after, force)) {
      team.store(moving + place, after, p.w);
    }
  }
  template <class Team>
  PBDSURG_DEVICE void guard(const Team& /*team*/, const FillingArrays& /*filling*/,
                            float /*give*/) const {}
  template <class Team>
  PBDSURG_DEVICE void begin(const Team& /*team*/) const {}
  template <class Team>
  PBDSURG_DEVICE void join(const Team& /*team*/, const FillingArrays& /*filling*/) const {}

 protected:
  PBDSURG_HOST_DEVICE static Vec3<float> way_of(const Particle& p) { return {p.x, p.y, p.z}; }
  PBDSURG_HOST_DEVICE static bool leads_somewhere(const Vec3<float>& after,
                                                  const Vec3<float>& force) {
    return dot(after, after) < kInfinity && dot(force, force) < kInfinity;
  }
};

/// Likewise by vertex blocks, whose rows hold against it: see ConstraintSweep. Before the sweeps
/// it is where vertices go by themselves that pushes change.
/// @tparam kForecast  whether that is now
template <bool kForecast>
struct HeldVertices : FreeVertices {
  LinkEnds ends;
  Particle* flights;           ///< [place]
  FixedPoint* points;          ///< [place]
  const Index* lane_of_place;  ///< see VertexArrays
  float* guards;               ///< [block][lane] likewise
  Index* groups;               ///< [group_count] see FreePieceArrays
  Index group_count;
  float inverse_dt_squared;  ///< 1/s^2

  template <class Team>
  [[nodiscard]] PBDSURG_DEVICE Vec3<float> moved(const Team& team, Index place) const {
    const Vec3<float> now = FreeVertices::moved(team, place);
    return kForecast ? now + way_of(team.load(ends.ways + place)) : now;
  }
  template <class Team>
  [[nodiscard]] PBDSURG_DEVICE Vec3<float> yield(const Team& team, Index place,
                                                 const Vec3<float>& force) const {
    const Particle give = team.load(ends.gives + place), shear = team.load(ends.shears + place);
    return VertexGive<float>{give.x, give.y, give.z, shear.x, shear.y, shear.z} * force;
  }
  template <class Team>
  PBDSURG_DEVICE void push(const Team& team, Index place, const Vec3<float>& force,
                           const Vec3<float>& way) const {
    Particle* const own = (kForecast ? ends.ways : moving) + place;
    const Particle p = team.load(own);
    const Vec3<float> before = way_of(p), after = before + way;
    if (!leads_somewhere(after, force)) {
      return;
    }
    team.store(own, after, p.w);
    const Particle flight = team.load(flights + place);
    const float w = team.load(moving + place).w;
    team.store(flights + place, way_of(flight) + pushed_flight(force, w, inverse_dt_squared),
               flight.w);
    if (!kForecast) {
      team.store(points + place, moved_point(team.load(points + place), before, after));
    }
  }
  /// Holds the vertices of a wall back by as much stiffness as its contents have, in addition to
  /// what earlier surfaces do.
  /// @param give  m^3/Pa, of wall and contents; infinite where these push nothing
  template <class Team>
  PBDSURG_DEVICE void guard(const Team& team, const FillingArrays& filling, float give) const {
    team.for_each(filling.vertex_count, [&](Index i) {
      const Index lane = lane_of_place[filling.places[i]];
      if (lane != kInvalidIndex) {
        const Vec3<float> gradient = filling.gradients[i];
        const float before = filling.is_shared[i] != 0 ? team.load(guards + lane) : 0.0F;
        guards[lane] = before + (give < kInfinity ? dot(gradient, gradient) / give : 0.0F);
      }
    });
  }

  /// Each free piece is by itself.
  template <class Team>
  PBDSURG_DEVICE void begin(const Team& team) const {
    team.for_each(group_count, [&](Index piece) { groups[piece] = piece; });
  }
  /// The pieces of a wall go together from here on, with those that go with them; not at all, if
  /// the wall is of others, too: as PushedPieces have it.
  template <class Team>
  PBDSURG_DEVICE void join(const Team& team, const FillingArrays& filling) const {
    Index group = filling.is_anchored ? kInvalidIndex : group_count;
    for (Index i = 0; i < filling.piece_count; ++i) {
      const Index own = team.load(groups + filling.pieces[i]);
      group = own < group ? own : group;
    }
    for (Index i = 0; i < filling.piece_count; ++i) {
      const Index before = team.load(groups + filling.pieces[i]);
      team.meet();  // before it is another
      team.for_each(before == group ? 0 : group_count, [&](Index piece) {
        if (team.load(groups + piece) == before) {
          groups[piece] = group;
        }
      });
    }
  }
};

/// m^3, within the surface whose vertices are at the ways.
template <class Team>
PBDSURG_DEVICE double filling_volume(const Team& team, const FillingArrays& filling) {
  team.for_each(filling.triangle_count, [&](Index t) {
    const Index* const corners = filling.triangles[t].corners;
    filling.volumes[t] = six_volumes(filling.ways[0], filling.ways[corners[0]],
                                     filling.ways[corners[1]], filling.ways[corners[2]]);
  });
  return team.sum(0.0, filling.volumes, filling.triangle_count) / 6;
}

/// Begins a substep: how much there would be at its end without pressure.
template <class Team>
PBDSURG_DEVICE void begin_filling(const Team& team, const FillingArrays& filling,
                                  const FreeVertices& vertices, FillingCopy& own) {
  using std::sqrt;
  const FillingLaw law = filling.input->law;
  team.for_each(filling.vertex_count, [&](Index i) {
    const Particle base = team.load(vertices.bases + filling.places[i]);
    filling.ways[i] = {base.x, base.y, base.z};
  });
  if (own.is_new) {
    own.now.pressure = filling.wall_count > 0 ? own.now.pressure : 0.0F;
    own.now.amount = law.amount_in(filling_volume(team, filling), own.now.pressure);
    own.is_new = false;
  }
  team.for_each(filling.triangle_count - filling.wall_count, [&](Index cap) {
    const Index t = filling.wall_count + cap;
    const Index* const corners = filling.triangles[t].corners;
    const Vec3<double> a = filling.ways[corners[0]];
    filling.caps[t] = cross(filling.ways[corners[1]] - a, filling.ways[corners[2]] - a);
  });
  double holes = 0;
  Index t = filling.wall_count;
  for (Index hole = 0; hole < filling.hole_count; ++hole) {
    Vec3<double> area;
    for (; t < filling.hole_ends[hole]; ++t) {
      area = area + filling.caps[t];
    }
    holes += sqrt(dot(area, area)) / 2;
  }
  own.substep = law.begin(own.now, holes, filling.input->h);
  own.has_pushed = false;
}

/// Projects the constraint on the volume, as ConstraintSweep::satisfy_together() does, and pushes
/// the wall.
template <class Team, class Vertices>
PBDSURG_DEVICE void push_wall(const Team& team, const FillingArrays& filling,
                              const Vertices& vertices, FillingCopy& own) {
  const FillingLaw law = filling.input->law;
  const auto base_of = [&](Index place) {
    const Particle p = team.load(vertices.bases + place);
    return Vec3<float>{p.x, p.y, p.z};
  };
  const Index origin = filling.places[0];
  const Vec3<float> base = base_of(origin);
  const Vec3<float> moved = vertices.moved(team, origin);
  team.for_each(filling.vertex_count, [&](Index i) {
    const Index place = filling.places[i];
    const Vec3<float> way = (base_of(place) - base) + (vertices.moved(team, place) - moved);
    filling.ways[i] = {way.x, way.y, way.z};
  });
  team.for_each(filling.triangle_count, [&](Index t) {
    const Index* const corners = filling.triangles[t].corners;
    filling.thirds[t] =
        third_of_area(filling.ways[corners[0]], filling.ways[corners[1]], filling.ways[corners[2]]);
  });
  team.for_each(filling.vertex_count, [&](Index i) {
    Vec3<float> gradient;
    for (Index k = filling.firsts[i]; k < filling.firsts[i + 1]; ++k) {
      gradient = gradient + filling.thirds[filling.triangles_at[k]];
    }
    filling.gradients[i] = gradient;
    filling.gives[i] = dot(gradient, vertices.yield(team, filling.places[i], gradient));
  });
  const auto [value, compliance] = law.constraint(own.substep, filling_volume(team, filling));
  const float give = team.sum(compliance, filling.gives, filling.vertex_count);
  const float before = own.substep.multiplier;
  float multiplier = before - (value + compliance * before) / give;
  const bool yields = give > 0 && multiplier < kInfinity && multiplier > -kInfinity;
  if (!yields) {
    multiplier = before;  // nothing yields, or a vertex is lost
  }
  const float least = -law.ambient_pressure;
  multiplier = multiplier < least ? least : multiplier;
  const float change = multiplier - before;
  own.substep.multiplier = own.substep.pressure = multiplier;
  own.compliance = compliance;
  vertices.guard(team, filling, yields && multiplier != 0 ? give : kInfinity);
  team.for_each(change == 0 ? 0 : filling.vertex_count, [&](Index i) {
    const Vec3<float> force = change * filling.gradients[i];
    const Index place = filling.places[i];
    vertices.push(team, place, force, vertices.yield(team, place, force));
  });
  if (change != 0 && !own.has_pushed) {
    own.has_pushed = true;
    vertices.join(team, filling);
  }
}

/// A copy's contents in a sweep.
/// @param team      for_each(count, visit): shares indices out and meets at the end; sum(start,
///                  values, count): start + values[0] + values[1] and so on, in this order;
///                  load(), store(); meet(); is_leader(). All threads of it take part, and all
///                  have what sum() finds.
/// @param is_first  whether a substep begins: with the first sweep of projections, or before those
///                  of vertex blocks
template <class Team, class Vertices>
PBDSURG_DEVICE void project_filling(const Team& team, const FillingArrays& filling,
                                    const Vertices& vertices, bool is_first) {
  FillingCopy own = team.load(filling.copies);
  if (is_first) {
    if (filling.is_first) {
      vertices.begin(team);
    }
    begin_filling(team, filling, vertices, own);
  }
  if (filling.wall_count > 0) {
    push_wall(team, filling, vertices, own);
    own.now = FillingLaw::end(own.substep);
  }
  team.meet();  // before it is another
  if (team.is_leader()) {
    *filling.copies = own;
    *filling.results = own.now;
  }
}

}  // namespace pbdsurg::cuda
