// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a team of threads does in a sweep with what fills a closed surface: the same bits as
/// pbdsurg/surgery/lumen.h by projections on a CPU, since all sums are in the order of triangles
/// and vertices.

#include <cmath>
#include <cstddef>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

#include "lib/solver/methods/filling.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg::cuda {

struct FillingTriangle {
  Index corners[3];  ///< places in the list of vertices
};

/// Of a copy, on its way through a step.
struct alignas(16) FillingCopy {
  FillingState now;
  FillingSubstep substep;
  bool is_new;  ///< whether now.amount is to follow from now.pressure
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
  Index vertex_count, triangle_count, wall_count, hole_count;

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

/// Where vertices are in a substep, in compliance mode.
struct FillingVertices {
  const Particle* bases;  ///< [place]
  Particle* moving;       ///< [place] displacements
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
                                  const FillingVertices& vertices, FillingCopy& own) {
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
}

/// Projects the constraint on the volume, as ConstraintSweep::satisfy_together() does by
/// projections, and pushes the wall.
template <class Team>
PBDSURG_DEVICE void push_wall(const Team& team, const FillingArrays& filling,
                              const FillingVertices& vertices, float inverse_dt_squared,
                              FillingCopy& own) {
  const FillingLaw law = filling.input->law;
  const auto load_vector = [&](const Particle* particle) {
    const Particle p = team.load(particle);
    return Vec3<float>{p.x, p.y, p.z};
  };
  const Index origin = filling.places[0];
  const Vec3<float> base = load_vector(vertices.bases + origin);
  const Vec3<float> moved = load_vector(vertices.moving + origin);
  team.for_each(filling.vertex_count, [&](Index i) {
    const Index place = filling.places[i];
    const Vec3<float> way = (load_vector(vertices.bases + place) - base) +
                            (load_vector(vertices.moving + place) - moved);
    filling.ways[i] = {way.x, way.y, way.z};
  });
  team.for_each(filling.triangle_count, [&](Index t) {
    const Index* const corners = filling.triangles[t].corners;
    filling.thirds[t] =
        third_of_area(filling.ways[corners[0]], filling.ways[corners[1]], filling.ways[corners[2]]);
  });
  const float square_of_dt = 1 / inverse_dt_squared;
  team.for_each(filling.vertex_count, [&](Index i) {
    Vec3<float> gradient;
    for (Index k = filling.firsts[i]; k < filling.firsts[i + 1]; ++k) {
      gradient = gradient + filling.thirds[filling.triangles_at[k]];
    }
    const float w = team.load(vertices.moving + filling.places[i]).w;
    filling.gradients[i] = gradient;
    filling.gives[i] = dot(gradient, (square_of_dt * w) * gradient);
  });
  const auto [value, compliance] = law.constraint(own.substep, filling_volume(team, filling));
  const float give = team.sum(compliance, filling.gives, filling.vertex_count);
  const float before = own.substep.multiplier;
  float multiplier = before - (value + compliance * before) / give;
  if (!(give > 0) || !(multiplier < kInfinity && multiplier > -kInfinity)) {
    multiplier = before;  // nothing yields, or a vertex is lost
  }
  const float least = -law.ambient_pressure;
  multiplier = multiplier < least ? least : multiplier;
  const float change = multiplier - before;
  own.substep.multiplier = own.substep.pressure = multiplier;
  team.for_each(change == 0 ? 0 : filling.vertex_count, [&](Index i) {
    Particle* const particle = vertices.moving + filling.places[i];
    const Particle p = team.load(particle);
    const Vec3<float> force = change * filling.gradients[i];
    const Vec3<float> after = Vec3<float>{p.x, p.y, p.z} + (square_of_dt * p.w) * force;
    if (dot(after, after) < kInfinity && dot(force, force) < kInfinity) {
      team.store(particle, after, p.w);
    }
  });
}

/// A copy's contents in a sweep.
/// @param team      for_each(count, visit): shares indices out and meets at the end; sum(start,
///                  values, count): start + values[0] + values[1] and so on, in this order;
///                  load(), store(); meet(); is_leader(). All threads of it take part, and all
///                  have what sum() finds.
/// @param is_first  of the sweeps of a substep
template <class Team>
PBDSURG_DEVICE void project_filling(const Team& team, const FillingArrays& filling,
                                    const FillingVertices& vertices, float inverse_dt_squared,
                                    bool is_first) {
  FillingCopy own = team.load(filling.copies);
  if (is_first) {
    begin_filling(team, filling, vertices, own);
  }
  if (filling.wall_count > 0) {
    push_wall(team, filling, vertices, inverse_dt_squared, own);
    own.now = FillingLaw::end(own.substep);
  }
  team.meet();  // before it is another
  if (team.is_leader()) {
    *filling.copies = own;
    *filling.results = own.now;
  }
}

}  // namespace pbdsurg::cuda
