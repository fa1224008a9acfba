// SPDX-License-Identifier: Apache-2.0
// Compiled several times: see lib/solver/CMakeLists.txt. Uses nothing but plain data and templates
// on Lanes, so that no function compiled here for one processor is linked into another's path.
#include "lib/solver/host/lane_kernels.h"

#include <type_traits>
#include <utility>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/host/lanes.h"
#include "lib/solver/methods/vertex_kernel.h"

#define PBDSURG_INLINE_LAMBDA __attribute__((always_inline))

namespace pbdsurg::PBDSURG_LANES_NAMESPACE {
namespace {

// Calls f(std::integral_constant) for 0 to kCount - 1. Compilers keep the elements of an array in
// registers when no index varies; a loop they may leave rolled up, and the array in memory.
template <int kCount, class F>
HWY_INLINE void unroll(const F& f) {
  [&]<int... kIndex>(std::integer_sequence<int, kIndex...>) PBDSURG_INLINE_LAMBDA {
    (f(std::integral_constant<int, kIndex>{}), ...);
  }
  (std::make_integer_sequence<int, kCount>{});
}

// kLanes constraints on their way through registers.
template <class Constraint, ProjectionMode kMode, bool kDamped>
class Chunk {
 public:
  HWY_INLINE Chunk(const BlockRange<Constraint>& range, Index slot)
      : block_(range.blocks[slot / kBlockLanes]),
        stored_(range.multipliers[slot / kBlockLanes]),
        lane_(slot % kBlockLanes) {}

  HWY_INLINE void gather_from(const Particle* particles) {
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      const ParticleLanes p = gather(particles, block_.corners[k] + lane_);
      x_[k] = p.x;
      w_[k] = p.w;
    });
  }

  HWY_INLINE void project([[maybe_unused]] const Particle* previous,
                          const Substep<Lanes>& substep) {
    Lanes parameters[Constraint::kParameterCount];
    unroll<Constraint::kParameterCount>([&](auto p) PBDSURG_INLINE_LAMBDA {
      parameters[p] = load_lanes(block_.parameters[p] + lane_);
    });
    Lanes multipliers[Constraint::kMultiplierCount];
    if constexpr (kMode == ProjectionMode::fraction) {  // has no memory
      Constraint::template project<kMode>(x_, w_, parameters, substep, multipliers);
    } else {
      unroll<Constraint::kMultiplierCount>([&](auto m) PBDSURG_INLINE_LAMBDA {
        multipliers[m] = load_lanes(stored_.values[m] + lane_);
      });
      if constexpr (kDamped) {
        Damped<Lanes, kVertices> damping;
        unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
          damping.start[k] = gather(previous, block_.corners[k] + lane_).x;
        });
        Constraint::template project<kMode>(x_, w_, parameters, substep, multipliers, damping);
      } else {
        Constraint::template project<kMode>(x_, w_, parameters, substep, multipliers);
      }
      unroll<Constraint::kMultiplierCount>([&](auto m) PBDSURG_INLINE_LAMBDA {
        store_lanes(multipliers[m], stored_.values[m] + lane_);
      });
    }
  }

  HWY_INLINE void scatter_to(Particle* particles) const {
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      scatter({x_[k], w_[k]}, particles, block_.corners[k] + lane_);
    });
  }

 private:
  static constexpr int kVertices = Constraint::kVertexCount;

  const ConstraintBlock<Constraint>& block_;
  MultiplierBlock<Constraint>& stored_;
  Index lane_;
  Vec3<Lanes> x_[kVertices];
  Lanes w_[kVertices];
};

// Two chunks at a time, which share no vertex: the processor computes one while it waits for
// another. Lanes without a constraint do what the last that has one does, with its result.
// Flattened: the maths of a constraint must not be called, or its registers pass through memory.
template <class Constraint, ProjectionMode kMode, bool kDamped>
HWY_FLATTEN void project(const BlockRange<Constraint>& range, const ProjectionState& state) {
  const Substep<Lanes> substep{Lanes(state.substep.inverse_dt),
                               Lanes(state.substep.inverse_dt_squared)};
  Particle* const particles = state.particles;
  const Index end = range.last * kBlockLanes < range.size ? range.last * kBlockLanes : range.size;
  Index slot = range.first * kBlockLanes;
  for (; slot + kLanes < end; slot += 2 * kLanes) {
    Chunk<Constraint, kMode, kDamped> one(range, slot), two(range, slot + kLanes);
    one.gather_from(particles);
    two.gather_from(particles);
    one.project(state.previous, substep);
    two.project(state.previous, substep);
    one.scatter_to(particles);
    two.scatter_to(particles);
  }
  if (slot < end) {
    Chunk<Constraint, kMode, kDamped> chunk(range, slot);
    chunk.gather_from(particles);
    chunk.project(state.previous, substep);
    chunk.scatter_to(particles);
  }
}

// C and the rest value that it is measured against.
struct Measured {
  Lanes value, rest;
};

template <class Constraint>
HWY_INLINE Measured measure_lanes(const ConstraintBlock<Constraint>& block, Index lane,
                                  const Vec3<Lanes> (&x)[Constraint::kVertexCount]) {
  if constexpr (std::is_same_v<Constraint, NeoHookeanConstraint>) {
    Lanes parameters[Constraint::kParameterCount];
    unroll<Constraint::kParameterCount>([&](auto p) PBDSURG_INLINE_LAMBDA {
      parameters[p] = load_lanes(block.parameters[p] + lane);
    });
    return {Constraint::value(x, parameters), Lanes(1)};
  } else {
    const Lanes rest = load_lanes(block.parameters[Constraint::kRest] + lane);
    return {Constraint::value(x, rest), rest};
  }
}

template <class Constraint>
HWY_FLATTEN Residual measure(const BlockRange<Constraint>& range, const Particle* particles) {
  Residual residual;
  const Lanes infinity(std::numeric_limits<float>::infinity());
  Lanes largest;
  for (Index b = range.first; b < range.last; ++b) {
    const ConstraintBlock<Constraint>& block = range.blocks[b];
    for (Index lane = 0; lane < kBlockLanes; lane += kLanes) {
      Vec3<Lanes> x[Constraint::kVertexCount];
      unroll<Constraint::kVertexCount>([&](auto k) PBDSURG_INLINE_LAMBDA {
        x[k] = gather(particles, block.corners[k] + lane).x;
      });
      const auto [value, rest] = measure_lanes<Constraint>(block, lane, x);
      const Lanes ratio = Lanes(hn::Div(abs(value).value, rest.value));
      const Index idle = b * kBlockLanes + lane + kLanes - range.size;
      const auto used = hn::FirstN(
          Tag(), static_cast<std::size_t>(idle > 0 ? (idle < kLanes ? kLanes - idle : 0) : kLanes));
      // what is not a number counts as infinite: it must not hide behind the finite ones; an idle
      // lane may hold what its constraint was before an edit
      const LaneMask counts{hn::And(used, (rest > Lanes(0)).value)};
      largest = max(largest, select(counts, select(ratio < infinity, ratio, infinity), Lanes(0)));
      residual.inverted +=
          static_cast<Index>(hn::CountTrue(Tag(), hn::And(used, (value + rest < Lanes(0)).value)));
    }
  }
  residual.largest = hn::GetLane(hn::MaxOfLanes(Tag(), largest.value));
  return residual;
}

// Calls visit(pointers to kLanes elements of each array) for all of a range; the last few vertices
// pass through copies.
// @tparam kPredicts  whether the visitor sets particles and where they were; else it sets
// velocities
template <bool kPredicts, class Visit>
HWY_INLINE void for_each_vertex_lanes(const VertexRange& range, const Visit& visit) {
  Index v = range.first;
  for (; v + kLanes <= range.last; v += kLanes) {
    visit(range.particles + v, range.previous + v, range.velocities + v);
  }
  if (v < range.last) {
    const Index count = range.last - v;
    alignas(64) Particle particles[kLanes] = {};
    alignas(64) Particle previous[kLanes] = {};
    alignas(64) Velocity velocities[kLanes] = {};
    for (Index i = 0; i < count; ++i) {
      particles[i] = range.particles[v + i];
      previous[i] = range.previous[v + i];
      velocities[i] = range.velocities[v + i];
    }
    visit(particles, previous, velocities);
    for (Index i = 0; i < count; ++i) {
      if constexpr (kPredicts) {
        range.particles[v + i] = particles[i];
        range.previous[v + i] = previous[i];
      } else {  // others read particles by now
        range.velocities[v + i] = velocities[i];
      }
    }
  }
}

HWY_INLINE ParticleLanes load_interleaved(const float* quads) {
  ParticleLanes lanes;
  hn::LoadInterleaved4(Tag(), quads, lanes.x.x.value, lanes.x.y.value, lanes.x.z.value,
                       lanes.w.value);
  return lanes;
}

HWY_INLINE void store_interleaved(const ParticleLanes& lanes, float* quads) {
  hn::StoreInterleaved4(lanes.x.x.value, lanes.x.y.value, lanes.x.z.value, lanes.w.value, Tag(),
                        quads);
}

HWY_FLATTEN void predict(const VertexRange& range, const Prediction& prediction) {
  const Lanes h(prediction.h), keep(prediction.keep);
  const Vec3<Lanes> kick{Lanes(prediction.kick.x), Lanes(prediction.kick.y),
                         Lanes(prediction.kick.z)};
  for_each_vertex_lanes<true>(
      range, [&](Particle* particles, Particle* previous, Velocity* velocities) {
        ParticleLanes p = load_interleaved(&particles->x);
        store_interleaved(p, &previous->x);
        const Vec3<Lanes> velocity = load_interleaved(&velocities->x).x;
        p.x = select(p.w > Lanes(0), p.x + h * (keep * velocity + kick), p.x);
        store_interleaved(p, &particles->x);
      });
}

HWY_FLATTEN void update_velocities(const VertexRange& range, float inverse_h) {
  const Lanes factor(inverse_h);
  for_each_vertex_lanes<false>(range, [&](Particle* particles, Particle* previous,
                                          Velocity* velocities) {
    const Vec3<Lanes> moved = load_interleaved(&particles->x).x - load_interleaved(&previous->x).x;
    store_interleaved({factor * moved, Lanes(0)}, &velocities->x);
  });
}

// kLanes lanes of a block, from one on.
struct RegisterAccess {
  using Scalar = Lanes;

  const Particle* particles;
  Index lane;

  [[nodiscard]] HWY_INLINE Lanes load(const float* numbers) const {
    return load_lanes(numbers + lane);
  }
  HWY_INLINE void store(Lanes lanes, float* numbers) const { store_lanes(lanes, numbers + lane); }
  [[nodiscard]] HWY_INLINE Vec3<Lanes> position(const ParticleOffset* corners) const {
    return gather(particles, corners + lane).x;
  }
};

HWY_FLATTEN LaneBits solve_vertices(const VertexRows& rows, const VertexState& state,
                                    Index block_index) {
  const VertexBlock& block = rows.blocks[block_index];
  LaneBits left = 0;
  for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
    const RegisterAccess access{state.particles, lane};
    ParticleLanes own = gather(state.particles, block.corners + lane);
    const Vec3<Lanes> flight = gather(state.flights, block.corners + lane).x;
    const LaneMask moves = own.w > Lanes(0);
    VertexEnergy<Lanes> energy;
    energy.add_pull(select(moves, Lanes(state.inverse_dt_squared) / own.w, Lanes(1)),
                    flight - own.x);
    add_rows(rows, block, access, own.x, energy);
    const Vec3<Lanes> moved =
        own.x + Lanes(state.relaxation) * VertexFactor<Lanes>(energy).solve(energy.force);
    const Vec3<Lanes> way = moved - own.x;
    const LaneMask is_finite = dot(way, way) < Lanes(std::numeric_limits<float>::infinity());
    const LaneBits finite = bits_of(is_finite) << lane;
    const LaneBits asked = ~state.left_out[block_index];
    own.x = select(moves & is_finite & mask_of(asked >> lane), moved, own.x);
    scatter(own, state.particles, block.corners + lane);
    left |= ~(finite & asked) & (bits_of(moves) << lane);
  }
  return left;
}

HWY_FLATTEN void add_damping(const DampedRows& rows, const Particle* start, float inverse_dt,
                             Index first, Index last) {
  for (Index b = first; b < last; ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index lane = 0; block.is_damped && lane < kBlockLanes; lane += kLanes) {
      pbdsurg::add_damping(rows, block, RegisterAccess{start, lane}, Lanes(inverse_dt));
    }
  }
}

struct VertexPointers {
  Particle* particles;
  const Particle* previous;
  const Velocity* velocities;
};

// Calls visit(vertices, flights, falling) with pointers to kLanes of each; the last few pass
// through copies.
// @tparam kBegins  whether the visitor sets particles and flights; else it sets falling
template <bool kBegins, class Visit>
HWY_INLINE void for_each_falling_lanes(const FallingRange& range, const Visit& visit) {
  const VertexRange& all = range.vertices;
  Index v = all.first;
  for (; v + kLanes <= all.last; v += kLanes) {
    visit({all.particles + v, all.previous + v, all.velocities + v}, range.flights + v,
          range.falling + v);
  }
  if (v < all.last) {
    const Index count = all.last - v;
    alignas(64) Particle particles[kLanes] = {};
    alignas(64) Particle previous[kLanes] = {};
    alignas(64) Velocity velocities[kLanes] = {};
    alignas(64) Particle flights[kLanes] = {};
    float falling[kLanes] = {};
    for (Index i = 0; i < count; ++i) {
      particles[i] = all.particles[v + i];
      previous[i] = all.previous[v + i];
      velocities[i] = all.velocities[v + i];
      flights[i] = range.flights[v + i];
      falling[i] = range.falling[v + i];
    }
    visit({particles, previous, velocities}, flights, falling);
    for (Index i = 0; i < count; ++i) {
      if constexpr (kBegins) {
        all.particles[v + i] = particles[i];
        range.flights[v + i] = flights[i];
      } else {  // others read particles by now
        range.falling[v + i] = falling[i];
      }
    }
  }
}

HWY_INLINE Vec3<Lanes> broadcast(const Vec3<float>& v) {
  return {Lanes(v.x), Lanes(v.y), Lanes(v.z)};
}

HWY_FLATTEN void extrapolate(const FallingRange& range, const Vec3<float>& fall) {
  for_each_falling_lanes<true>(
      range, [&](const VertexPointers& vertices, Particle* flights, const float* falling) {
        ParticleLanes p = load_interleaved(&vertices.particles->x);
        store_interleaved(p, &flights->x);
        p.x = start_of(p.x, p.w, Lanes(hn::LoadU(Tag(), falling)), broadcast(fall));
        store_interleaved(p, &vertices.particles->x);
      });
}

HWY_FLATTEN void measure_fall(const FallingRange& range, const Vec3<float>& gravity_per_square,
                              float inverse_dt) {
  for_each_falling_lanes<false>(
      range, [&](const VertexPointers& vertices, const Particle*, float* falling) {
        const Lanes share = falling_of(load_interleaved(&vertices.particles->x).x,
                                       load_interleaved(&vertices.previous->x).x,
                                       load_interleaved(&vertices.velocities->x).x,
                                       broadcast(gravity_per_square), Lanes(inverse_dt));
        hn::StoreU(share.value, Tag(), falling);
      });
}

template <class Constraint>
constexpr ConstraintKernels<Constraint> kernels_of() {
  using Kind = KindOf<Constraint>;
  ConstraintKernels<Constraint> kernels{};
  if constexpr (Kind::kHasFraction) {
    kernels.project_fraction = &project<Constraint, ProjectionMode::fraction, false>;
    kernels.project_compliance = kernels.project_damped = kernels.project_fraction;
  }
  if constexpr (Kind::kHasCompliance) {
    kernels.project_compliance = &project<Constraint, ProjectionMode::compliance, false>;
    kernels.project_damped = &project<Constraint, ProjectionMode::compliance, true>;
  }
  if constexpr (Kind::kIsMeasured) {
    kernels.measure = &measure<Constraint>;
  }
  return kernels;
}

template <class... Constraints>
constexpr AllConstraintKernels<Constraints...> all_kernels(
    AllConstraintKernels<Constraints...> /*kinds*/) {
  return {kernels_of<Constraints>()...};
}

}  // namespace

extern const LaneKernels kernels;
constinit const LaneKernels kernels{all_kernels(ForAllConstraints<AllConstraintKernels>{}),
                                    PBDSURG_LANES_NAME,
                                    &predict,
                                    &update_velocities,
                                    &solve_vertices,
                                    &add_damping,
                                    &extrapolate,
                                    &measure_fall};

}  // namespace pbdsurg::PBDSURG_LANES_NAMESPACE
