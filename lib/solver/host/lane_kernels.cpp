// SPDX-License-Identifier: Apache-2.0
// Compiled several times: see lib/solver/CMakeLists.txt. Uses nothing but plain data and templates
// on Lanes, so that no function compiled here for one processor is linked into another's path.
#include "lib/solver/host/lane_kernels.h"

#include <type_traits>
#include <utility>

#include "pbdsurg/base/vec3.h"

#include "lib/solver/host/lanes.h"
#include "lib/solver/methods/loose_end.h"
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

HWY_INLINE Vec3<IntLanes> bits_as_int(const Vec3<Lanes>& v) {
  return {bits_as_int(v.x), bits_as_int(v.y), bits_as_int(v.z)};
}

// In the bits of floats; lost where a condition does not hold.
HWY_INLINE ParticleLanes fixed_quads(const Vec3<IntLanes>& point, LaneMask is_there, Lanes unit) {
  const auto bits = [&](IntLanes number) PBDSURG_INLINE_LAMBDA {
    return select(is_there, bits_as_float(number), Lanes(0));
  };
  return {{bits(point.x), bits(point.y), bits(point.z)}, select(is_there, unit, Lanes(kNoNumber))};
}

// As fixed_point().
HWY_INLINE ParticleLanes fixed_point(const Vec3<Lanes>& base, const Vec3<Lanes>& u, Lanes unit,
                                     Lanes inverse_unit) {
  return fixed_quads(fixed(base, inverse_unit) + fixed(u, inverse_unit),
                     is_fixable(base, inverse_unit) & is_fixable(u, inverse_unit), unit);
}

// As moved_point().
HWY_INLINE ParticleLanes moved_point(const ParticleLanes& point, const Vec3<Lanes>& before,
                                     const Vec3<Lanes>& u, Lanes unit, Lanes inverse_unit) {
  return fixed_quads(bits_as_int(point.x) + fixed(u, inverse_unit) - fixed(before, inverse_unit),
                     (point.w > Lanes(0)) & is_fixable(u, inverse_unit), unit);
}

// kLanes constraints on their way through registers.
template <class Constraint, ProjectionMode kMode, bool kDamped>
class Chunk {
 public:
  HWY_INLINE Chunk(const BlockRange<Constraint>& range, Index slot)
      : block_(range.blocks[slot / kBlockLanes]),
        stored_(range.multipliers[slot / kBlockLanes]),
        lane_(slot % kBlockLanes) {}

  HWY_INLINE void gather_from(const ProjectionState& state) {
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      const ParticleLanes p = gather(state.moving, block_.corners[k] + lane_);
      moving_[k] = p.x;
      w_[k] = p.w;
      if constexpr (kDisplaces) {
        bases_[k] = gather(state.bases, block_.corners[k] + lane_).x;
      }
    });
  }

  HWY_INLINE void project(const ProjectionState& state, const Substep<Lanes>& substep) {
    Lanes parameters[Constraint::kParameterCount];
    unroll<Constraint::kParameterCount>([&](auto p) PBDSURG_INLINE_LAMBDA {
      parameters[p] = load_lanes(block_.parameters[p] + lane_);
    });
    Vec3<Lanes> seen[kVertices];
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      if constexpr (kDisplaces) {
        seen[k] = seen_corner<k>(bases_, moving_);
      } else {
        seen[k] = moving_[k];
      }
    });
    Moves<Lanes, kVertices> moves;
    Lanes multipliers[Constraint::kMultiplierCount];
    if constexpr (!kRemembers<Constraint, kMode>) {
      moves = Constraint::template move<kMode>(seen, w_, parameters, substep, multipliers);
    } else {
      unroll<Constraint::kMultiplierCount>([&](auto m) PBDSURG_INLINE_LAMBDA {
        multipliers[m] = load_lanes(stored_.values[m] + lane_);
      });
      [[maybe_unused]] const Vec3<Lanes> before = force_of(multipliers);
      if constexpr (kDamped) {
        Vec3<Lanes> roundings[kVertices];
        Damped<Lanes, kVertices> damping;
        unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
          roundings[k] = gather(state.carries, block_.corners[k] + lane_).x;
          damping.start[k] = seen_corner<k>(bases_, roundings);
        });
        moves =
            Constraint::template move<kMode>(seen, w_, parameters, substep, multipliers, damping);
      } else {
        moves = Constraint::template move<kMode>(seen, w_, parameters, substep, multipliers);
      }
      if constexpr (std::is_same_v<Constraint, StiffLinkConstraint>) {
        const Vec3<Lanes> change = force_of(multipliers) - before;
        push_flight(state, 0, pushed_flight(change, w_[0], substep.inverse_dt_squared));
        push_flight(state, 1, pushed_flight(Lanes(-1) * change, w_[1], substep.inverse_dt_squared));
      }
      unroll<Constraint::kMultiplierCount>([&](auto m) PBDSURG_INLINE_LAMBDA {
        store_lanes(multipliers[m], stored_.values[m] + lane_);
      });
    }
    if constexpr (kDisplaces && KindOf<Constraint>::kIsOfVertexBlocks) {
      if (state.fixed_points != nullptr) {
        move_points(state, moves);
      }
    }
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA { moving_[k] = moving_[k] + moves.of[k]; });
  }

  HWY_INLINE void scatter_to(Particle* moving) const {
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      scatter({moving_[k], w_[k]}, moving, block_.corners[k] + lane_);
    });
  }

 private:
  static constexpr int kVertices = Constraint::kVertexCount;

  static HWY_INLINE Vec3<Lanes> force_of(const Lanes (&multipliers)[Constraint::kMultiplierCount]) {
    if constexpr (std::is_same_v<Constraint, StiffLinkConstraint>) {
      return Constraint::force_of(multipliers);
    } else {
      return {};
    }
  }

  HWY_INLINE void push_flight(const ProjectionState& state, int corner,
                              const Vec3<Lanes>& way) const {
    const ParticleOffset* const corners = block_.corners[corner] + lane_;
    ParticleLanes flight = gather(state.flights, corners);
    flight.x = flight.x + way;
    scatter(flight, state.flights, corners);
  }

  HWY_INLINE void move_points(const ProjectionState& state,
                              const Moves<Lanes, kVertices>& moves) const {
    const Lanes unit(state.unit), inverse_unit(1 / state.unit);
    unroll<kVertices>([&](auto k) PBDSURG_INLINE_LAMBDA {
      const ParticleOffset* const corners = block_.corners[k] + lane_;
      scatter(moved_point(gather(state.fixed_points, corners), moving_[k], moving_[k] + moves.of[k],
                          unit, inverse_unit),
              state.fixed_points, corners);
    });
  }

  static constexpr bool kDisplaces = kMode == ProjectionMode::compliance;

  const ConstraintBlock<Constraint>& block_;
  MultiplierBlock<Constraint>& stored_;
  Index lane_;
  Vec3<Lanes> moving_[kVertices];
  Vec3<Lanes> bases_[kVertices];
  Lanes w_[kVertices];
};

// Two chunks at a time, which share no vertex: the processor computes one while it waits for
// another. Lanes without a constraint do what the last that has one does, with its result.
// Flattened: the maths of a constraint must not be called, or its registers pass through memory.
template <class Constraint, ProjectionMode kMode, bool kDamped>
HWY_FLATTEN void project(const BlockRange<Constraint>& range, const ProjectionState& state) {
  const Substep<Lanes> substep{Lanes(state.substep.inverse_dt),
                               Lanes(state.substep.inverse_dt_squared)};
  const Index end = range.last * kBlockLanes < range.size ? range.last * kBlockLanes : range.size;
  Index slot = range.first * kBlockLanes;
  for (; slot + kLanes < end; slot += 2 * kLanes) {
    Chunk<Constraint, kMode, kDamped> one(range, slot), two(range, slot + kLanes);
    one.gather_from(state);
    two.gather_from(state);
    one.project(state, substep);
    two.project(state, substep);
    one.scatter_to(state.moving);
    two.scatter_to(state.moving);
  }
  if (slot < end) {
    Chunk<Constraint, kMode, kDamped> chunk(range, slot);
    chunk.gather_from(state);
    chunk.project(state, substep);
    chunk.scatter_to(state.moving);
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

HWY_INLINE Vec3<Lanes> broadcast(const Vec3<float>& v) {
  return {Lanes(v.x), Lanes(v.y), Lanes(v.z)};
}

HWY_INLINE FreeMotion<Lanes> broadcast(const FreeMotion<float>& motion) {
  return {Lanes(motion.h),         Lanes(motion.inverse_h),   Lanes(motion.keep),
          broadcast(motion.kick),  broadcast(motion.fall),    broadcast(motion.gravity_per_square),
          Lanes(motion.kick_time), Lanes(motion.fall_square), Lanes(motion.inverse_gravity),
          Lanes(motion.push_time)};
}

// Arrays of quads, some of which are not there, on their way through registers: kLanes from each,
// the last few through a copy. What a visitor changes goes back where others may read meanwhile
// what it does not change.
template <class Stored>
class QuadLanes {
 public:
  HWY_INLINE QuadLanes(Stored* quads, Index first, Index count)
      : from_(quads + first), count_(count) {
    if (count < kLanes) {
      for (Index i = 0; i < kLanes; ++i) {
        copies_[i] = i < count ? from_[i] : Stored{};
      }
    }
  }

  [[nodiscard]] HWY_INLINE ParticleLanes load() const {
    return load_interleaved(reinterpret_cast<const float*>(count_ < kLanes ? copies_ : from_));
  }
  HWY_INLINE void store(const ParticleLanes& lanes) {
    if (count_ == kLanes) {
      store_interleaved(lanes, reinterpret_cast<float*>(from_));
      return;
    }
    store_interleaved(lanes, reinterpret_cast<float*>(copies_));
    for (Index i = 0; i < count_; ++i) {
      from_[i] = copies_[i];
    }
  }

 private:
  Stored* from_;
  Index count_;
  alignas(64) Stored copies_[kLanes];
};

// Calls visit(first, count) for registers of vertices, the last of them with fewer.
template <class Visit>
HWY_INLINE void for_each_register(const VertexRange& range, const Visit& visit) {
  for (Index v = range.first; v < range.last; v += kLanes) {
    visit(v, range.last - v < kLanes ? range.last - v : kLanes);
  }
}

/// As falling_motion() of a register of vertices.
HWY_INLINE FreeMotion<Lanes> falling_motion(const VertexRange& range,
                                            const FreeMotion<Lanes>& motion, Index first,
                                            Index count) {
  if (range.gravities == nullptr) {
    return motion;
  }
  const ParticleLanes gravity = QuadLanes(range.gravities, first, count).load();
  return under(gravity.x, gravity.w, motion);
}

/// As flying_motion(), where there are forces.
HWY_INLINE FreeMotion<Lanes> flying_motion(const VertexRange& range,
                                           const FreeMotion<Lanes>& falling, Index first,
                                           Index count) {
  return pushed_by(QuadLanes(range.forces, first, count).load().x,
                   QuadLanes(range.particles, first, count).load().w, falling);
}

/// Calls visit(first, count, falling) as for_each_register(), with falling_motion().
template <class Visit>
HWY_INLINE void for_each_falling(const VertexRange& range, const FreeMotion<float>& single,
                                 const Visit& visit) {
  const FreeMotion<Lanes> motion = broadcast(single);
  if (range.gravities == nullptr) {
    for_each_register(range, [&](Index first, Index count)
                                 PBDSURG_INLINE_LAMBDA { visit(first, count, motion); });
    return;
  }
  for_each_register(range, [&](Index first, Index count) PBDSURG_INLINE_LAMBDA {
    visit(first, count, falling_motion(range, motion, first, count));
  });
}

/// Calls visit(first, count, falling, flying) as for_each_falling(), with flying_motion(), too.
/// Steps without forces have code of their own, and so keep their bits: fast mode contracts
/// operations as the code around them lets it.
template <class Visit>
HWY_INLINE void for_each_motion(const VertexRange& range, const FreeMotion<float>& single,
                                const Visit& visit) {
  const auto freely = [&](Index first, Index count, const FreeMotion<Lanes>& falling)
                          PBDSURG_INLINE_LAMBDA { visit(first, count, falling, falling); };
  const auto pushed = [&](Index first, Index count,
                          const FreeMotion<Lanes>& falling) PBDSURG_INLINE_LAMBDA {
    visit(first, count, falling, flying_motion(range, falling, first, count));
  };
  if (range.forces == nullptr) {
    for_each_falling(range, single, freely);
  } else {
    for_each_falling(range, single, pushed);
  }
}

HWY_FLATTEN void predict_positions(const VertexRange& range, const FreeMotion<float>& single) {
  const auto predict = [&](Index first, Index count, const FreeMotion<Lanes>&,
                           const FreeMotion<Lanes>& flying) PBDSURG_INLINE_LAMBDA {
    QuadLanes particles(range.particles, first, count);
    QuadLanes previous(range.previous, first, count);
    ParticleLanes p = particles.load();
    previous.store(p);
    const Vec3<Lanes> velocity = QuadLanes(range.velocities, first, count).load().x;
    p.x = select(p.w > Lanes(0), p.x + flying.h * (flying.keep * velocity + flying.kick), p.x);
    particles.store(p);
  };
  for_each_motion(range, single, predict);
}

HWY_FLATTEN void update_velocities(const VertexRange& range, const FreeMotion<float>& motion) {
  const Lanes factor(motion.inverse_h);
  for_each_register(range, [&](Index first, Index count) PBDSURG_INLINE_LAMBDA {
    const Vec3<Lanes> way = QuadLanes(range.particles, first, count).load().x -
                            QuadLanes(range.previous, first, count).load().x;
    QuadLanes(range.velocities, first, count).store({factor * way, Lanes(0)});
  });
}

HWY_FLATTEN void predict_displacements(const VertexRange& range, const FreeMotion<float>& single) {
  const Lanes unit(range.unit), inverse_unit(1 / range.unit);
  const auto predict = [&](Index first, Index count, const FreeMotion<Lanes>& falling,
                           const FreeMotion<Lanes>& flying) PBDSURG_INLINE_LAMBDA {
    const ParticleLanes p = QuadLanes(range.particles, first, count).load();
    const Lanes w = p.w;
    const Vec3<Lanes> velocity = QuadLanes(range.velocities, first, count).load().x;
    const ParticleLanes carry = QuadLanes(range.carries, first, count).load();
    const auto flight_in = [&](const FreeMotion<Lanes>& motion) PBDSURG_INLINE_LAMBDA {
      return flight_of(motion, carry.x, flying_velocity(motion, velocity, w));
    };
    Vec3<Lanes> u = flight_in(flying);
    if (range.flights != nullptr) {
      QuadLanes(range.flights, first, count).store({u, Lanes(kFreely)});
      u = start_of(falling, flight_in(falling), w, carry.w);
      QuadLanes(range.fixed_points, first, count)
          .store(fixed_point(p.x, range.starts ? carry.x : u, unit, inverse_unit));
    }
    QuadLanes(range.displacements, first, count).store({u, w});
  };
  for_each_motion(range, single, predict);
}

HWY_FLATTEN void settle(const VertexRange& range, const FreeMotion<float>& single) {
  for_each_falling(
      range, single,
      [&](Index first, Index count, const FreeMotion<Lanes>& falling) PBDSURG_INLINE_LAMBDA {
        QuadLanes particles(range.particles, first, count);
        QuadLanes velocities(range.velocities, first, count);
        QuadLanes carries(range.carries, first, count);
        const ParticleLanes p = particles.load();
        const Settled<Lanes> end =
            pbdsurg::settle(falling, p.x, p.w, velocities.load().x, carries.load().x,
                            QuadLanes(range.displacements, first, count).load().x);
        particles.store({end.x, p.w});
        velocities.store({end.velocity, Lanes(0)});
        carries.store({end.rounding, end.falling});
      });
}

HWY_FLATTEN void displace(const VertexRange& range, Particle* moves) {
  const Lanes unit(range.unit), inverse_unit(1 / range.unit);
  for_each_register(range, [&](Index first, Index count) PBDSURG_INLINE_LAMBDA {
    const ParticleLanes move = QuadLanes(moves, first, count).load();
    QuadLanes displacements(range.displacements, first, count);
    QuadLanes points(range.fixed_points, first, count);
    ParticleLanes u = displacements.load();
    const ParticleLanes point = points.load();
    const LaneMask moves_on = move.w > Lanes(0);
    const Vec3<Lanes> before = u.x;
    u.x = select(moves_on, before + move.x, before);
    displacements.store(u);
    const ParticleLanes after = moved_point(point, before, u.x, unit, inverse_unit);
    points.store({select(moves_on, after.x, point.x), select(moves_on, after.w, point.w)});
  });
}

// kLanes lanes of a block, from one on, within sweeps.
struct RegisterAccess {
  using Scalar = Lanes;

  const FixedPoint* fixed_points;
  Vec3<IntLanes> own;
  Index lane;

  [[nodiscard]] HWY_INLINE Lanes load(const float* numbers) const {
    return load_lanes(numbers + lane);
  }
  [[nodiscard]] HWY_INLINE Vec3<Lanes> position(const ParticleOffset* corners) const {
    const ParticleLanes p = gather(fixed_points, corners + lane);
    return fixed_difference(bits_as_int(p.x), own, p.w);
  }
};

// Likewise at the start of a substep.
struct RegisterStart {
  using Scalar = Lanes;

  const Particle* bases;
  const Carry* carries;
  Vec3<Lanes> own_base;
  Index lane;

  [[nodiscard]] HWY_INLINE Lanes load(const float* numbers) const {
    return load_lanes(numbers + lane);
  }
  HWY_INLINE void store(Lanes lanes, float* numbers) const { store_lanes(lanes, numbers + lane); }
  [[nodiscard]] HWY_INLINE Vec3<Lanes> position(const ParticleOffset* corners) const {
    return (gather(bases, corners + lane).x - own_base) + gather(carries, corners + lane).x;
  }
};

// Likewise: see HeadingAccess.
struct RegisterHeading {
  using Scalar = Lanes;

  const Particle* bases;
  const Velocity* velocities;
  Vec3<Lanes> own_base;
  Lanes time;
  Index lane;

  [[nodiscard]] HWY_INLINE Lanes load(const float* numbers) const {
    return load_lanes(numbers + lane);
  }
  [[nodiscard]] HWY_INLINE Heading<Lanes> position(const ParticleOffset* corners) const {
    return {gather(bases, corners + lane).x - own_base,
            time * gather(velocities, corners + lane).x};
  }
};

// The corners of the last face of a strip.
struct StripFace {
  Vec3<Lanes> a, b, c;

  // @param stiffness  of StripRow
  HWY_INLINE void step(const Vec3<Lanes>& corner, Lanes stiffness) {
    const LaneMask turns = has_sign(stiffness);
    const Vec3<Lanes> before = a;
    a = select(turns, c, before);
    b = select(turns, b, c);
    c = corner;
  }
};

// All but what strips and fans say.
HWY_INLINE VertexBlock without_strips(const VertexBlock& block) {
  VertexBlock others = block;
  if (block.strips.count > 0) {
    others.pulls.count = others.volumes.count = 0;
  }
  if (block.fans.count > 0) {
    others.pulls.count = others.triangles.count = 0;
  }
  return others;
}

// As add_rows(), in another order where a block has strips or fans.
template <class Energy>
HWY_INLINE void add_rows_by_strips(const VertexRows& rows, const VertexBlock& block,
                                   const RegisterAccess& access, Energy& energy) {
  const StripRow* const strips = rows.strips + block.strips.first;
  StripFace face;
  for (Index i = 0; i < block.strips.count; ++i) {
    const Vec3<Lanes> d = access.position(strips[i].corners);
    const Lanes stiffness = access.load(strips[i].stiffness);
    face.step(d, stiffness);
    energy.add_pull(access.load(strips[i].weights), d);
    energy.add_volume(abs(stiffness), access.load(strips[i].target), face.a, face.b, face.c);
  }
  const FanRow* const fans = rows.fans + block.fans.first;
  Vec3<Lanes> corner;
  for (Index i = 0; i < block.fans.count; ++i) {
    const Vec3<Lanes> before = corner;
    corner = access.position(fans[i].corners);
    energy.add_pull(access.load(fans[i].weights), corner);
    if (i < block.fan_steps) {
      energy.add_area(access.load(fans[i].within), access.load(fans[i].stiffness),
                      access.load(fans[i].target), before, corner);
    }
  }
  add_rows(rows, without_strips(block), access, energy);
}

// In the order of a serial step, unless a fast one does without.
template <class Energy>
HWY_INLINE void add_all_rows(const VertexRows& rows, const VertexBlock& block,
                             const RegisterAccess& access, Energy& energy) {
  if constexpr (kFast) {
    add_rows_by_strips(rows, block, access, energy);
  } else {
    add_tree(rows, block, access, energy);
  }
}

HWY_INLINE void store_energy(const VertexEnergy<Lanes>& energy, Index lane, EnergyBlock& to) {
  store_lanes(energy.force.x, to.force[0] + lane);
  store_lanes(energy.force.y, to.force[1] + lane);
  store_lanes(energy.force.z, to.force[2] + lane);
  store_lanes(energy.isotropic, to.isotropic + lane);
  store_lanes(energy.xx, to.squares[0] + lane);
  store_lanes(energy.yy, to.squares[1] + lane);
  store_lanes(energy.zz, to.squares[2] + lane);
  store_lanes(energy.xy, to.squares[3] + lane);
  store_lanes(energy.xz, to.squares[4] + lane);
  store_lanes(energy.yz, to.squares[5] + lane);
}

HWY_FLATTEN LaneBits solve_vertices(const VertexRows& rows, const VertexState& state,
                                    Index block_index, EnergyBlock& energies) {
  const VertexBlock& block = rows.blocks[block_index];
  const Lanes unit(state.unit), inverse_unit(1 / state.unit);
  LaneBits left = 0;
  for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
    ParticleLanes own = gather(state.displacements, block.corners + lane);
    const ParticleLanes point = gather(state.fixed_points, block.corners + lane);
    const ParticleLanes flight = gather(state.flights, block.corners + lane);
    const Lanes asked_for(state.relaxation);
    const Lanes relaxation = select(asked_for < flight.w, asked_for, flight.w);
    const LaneMask moves = own.w > Lanes(0);
    VertexEnergy<Lanes> energy;
    energy.add_pull(select(moves, Lanes(state.inverse_dt_squared) / own.w, Lanes(1)),
                    flight.x - own.x);
    if (state.guards != nullptr) {
      energy.isotropic = energy.isotropic + load_lanes(state.guards[block_index].stiffness + lane);
    }
    add_all_rows(rows, block, RegisterAccess{state.fixed_points, bits_as_int(point.x), lane},
                 energy);
    const Vec3<Lanes> move = relaxation * VertexFactor<Lanes>(energy).solve(energy.force);
    const Lanes infinity(std::numeric_limits<float>::infinity());
    const LaneMask is_finite = (dot(move, move) < infinity) &
                               (dot(energy.force, energy.force) < infinity) & (point.w > Lanes(0));
    const LaneBits finite = bits_of(is_finite) << lane;
    const LaneBits asked = ~state.left_out[block_index];
    const Vec3<Lanes> before = own.x;
    own.x = select(moves & is_finite & mask_of(asked >> lane), before + move, before);
    scatter(own, state.displacements, block.corners + lane);
    scatter(moved_point(point, before, own.x, unit, inverse_unit), state.fixed_points,
            block.corners + lane);
    const LaneBits left_here = ~(finite & asked) & (bits_of(moves) << lane);
    if (left_here != 0) {
      store_energy(energy, lane, energies);
    }
    left |= left_here;
  }
  return left;
}

// N, of the rows of a block.
HWY_INLINE Vec3<Lanes> force_on(const VertexRows& rows, const VertexBlock& block,
                                const RegisterAccess& access) {
  VertexForce<Lanes> sum;
  add_all_rows(rows, block, access, sum);
  return sum.force;
}

HWY_FLATTEN LaneBits push_vertices(const VertexRows& rows, const VertexState& state,
                                   Index block_index) {
  const VertexBlock& block = rows.blocks[block_index];
  const Lanes infinity(std::numeric_limits<float>::infinity());
  LaneBits left = 0;
  for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
    ParticleLanes own = gather(state.displacements, block.corners + lane);
    const ParticleLanes point = gather(state.fixed_points, block.corners + lane);
    const ParticleLanes flight = gather(state.flights, block.corners + lane);
    const LaneMask moves = own.w > Lanes(0);
    const RegisterAccess access{state.fixed_points, bits_as_int(point.x), lane};
    const Vec3<Lanes> force = force_on(rows, block, access);
    const Vec3<Lanes> moved =
        flight.x + pushed_flight(force, own.w, Lanes(state.inverse_dt_squared));
    const LaneMask is_finite =
        (dot(moved, moved) < infinity) & (dot(force, force) < infinity) & (point.w > Lanes(0));
    const LaneBits asked = ~state.left_out[block_index];
    own.x = select(moves & is_finite & mask_of(asked >> lane), moved, own.x);
    scatter(own, state.displacements, block.corners + lane);
    left |= ~((bits_of(is_finite) << lane) & asked) & (bits_of(moves) << lane);
  }
  return left;
}

HWY_FLATTEN void find_residuals(const VertexRows& rows, const VertexState& state, Index block_index,
                                Particle* residuals) {
  const VertexBlock& block = rows.blocks[block_index];
  const Lanes infinity(std::numeric_limits<float>::infinity());
  for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
    const ParticleLanes own = gather(state.displacements, block.corners + lane);
    const ParticleLanes point = gather(state.fixed_points, block.corners + lane);
    const Vec3<Lanes> flight = gather(state.flights, block.corners + lane).x;
    const LaneMask moves = own.w > Lanes(0);
    const RegisterAccess access{state.fixed_points, bits_as_int(point.x), lane};
    const Vec3<Lanes> force = force_on(rows, block, access);
    const Lanes weight = select(moves, Lanes(state.inverse_dt_squared) / own.w, Lanes(1));
    const Vec3<Lanes> residual = weight * (flight - own.x) + force;
    const LaneMask counts = moves & (dot(residual, residual) < infinity) & (point.w > Lanes(0)) &
                            mask_of(~state.left_out[block_index] >> lane);
    scatter({select(counts, residual, Vec3<Lanes>{Lanes(0), Lanes(0), Lanes(0)}),
             select(counts, Lanes(1), Lanes(0))},
            residuals, block.corners + lane);
  }
}

HWY_FLATTEN float stiffest(const VertexRows& rows, const Particle* bases,
                           const Velocity* velocities, float heading, const float* shares,
                           Index first, Index last) {
  Lanes largest(0);
  for (Index b = first; b < last; ++b) {
    const VertexBlock& block = rows.blocks[b];
    for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
      const Vec3<Lanes> base = gather(bases, block.corners + lane).x;
      const Lanes share = hn::LoadU(Tag(), shares + b * kBlockLanes + lane);  // of a vector
      VolumeStiffness<Lanes> stiffness;
      add_tree(rows, block, RegisterHeading{bases, velocities, base, Lanes(heading), lane},
               stiffness);
      largest = stiffness.most(share, largest);
    }
  }
  return hn::GetLane(hn::MaxOfLanes(Tag(), largest.value));
}

HWY_FLATTEN LaneBits find_loose_ends(const VertexRows& rows, const VertexState& state,
                                     const LinkEnds& ends, Index block_index, LaneBits lanes) {
  const VertexBlock& block = rows.blocks[block_index];
  const Lanes infinity(std::numeric_limits<float>::infinity());
  LaneBits found = 0;
  for (Index lane = 0; lane < block.lane_count; lane += kLanes) {
    constexpr LaneBits kAll = ~LaneBits{0} >> (32 - kLanes);
    if ((lanes >> lane & kAll) == 0) {
      continue;
    }
    const ParticleLanes own = gather(state.displacements, block.corners + lane);
    const ParticleLanes point = gather(state.fixed_points, block.corners + lane);
    const Vec3<Lanes> flight = gather(state.flights, block.corners + lane).x;
    const LaneMask moves = own.w > Lanes(0);
    VertexEnergy<Lanes> energy;
    energy.add_pull(select(moves, Lanes(state.inverse_dt_squared) / own.w, Lanes(1)),
                    flight - own.x);
    add_all_rows(rows, block, RegisterAccess{state.fixed_points, bits_as_int(point.x), lane},
                 energy);
    const LooseEnd<Lanes> end = LooseEnd<Lanes>::of(energy);
    const LaneMask is_finite = (dot(end.way, end.way) < infinity) &
                               (dot(energy.force, energy.force) < infinity) & (point.w > Lanes(0));
    found |= bits_of(moves & is_finite) << lane;
    const VertexGive<Lanes>& give = end.give;
    scatter({end.way, end.is_known}, ends.ways, block.corners + lane);
    scatter({{give.xx, give.yy, give.zz}, Lanes(0)}, ends.gives, block.corners + lane);
    scatter({{give.xy, give.xz, give.yz}, Lanes(0)}, ends.shears, block.corners + lane);
  }
  return lanes & ~found;
}

HWY_INLINE LooseEnd<Lanes> load_ends(const LinkEnds& ends, const ParticleOffset* corners) {
  const ParticleLanes way = gather(ends.ways, corners);
  const Vec3<Lanes> give = gather(ends.gives, corners).x;
  const Vec3<Lanes> shear = gather(ends.shears, corners).x;
  return {{give.x, give.y, give.z, shear.x, shear.y, shear.z}, way.x, way.w};
}

HWY_FLATTEN void begin_joints(const BlockRange<StiffLinkConstraint>& range,
                              const ProjectionState& state, const LinkEnds& ends) {
  using Constraint = StiffLinkConstraint;
  const Index end = range.last * kBlockLanes < range.size ? range.last * kBlockLanes : range.size;
  for (Index slot = range.first * kBlockLanes; slot < end; slot += kLanes) {
    const Index lane = slot % kBlockLanes;
    const ConstraintBlock<Constraint>& block = range.blocks[slot / kBlockLanes];
    const ParticleOffset* const corners[2] = {block.corners[0] + lane, block.corners[1] + lane};
    LooseEnd<Lanes> pair[2] = {load_ends(ends, corners[0]), load_ends(ends, corners[1])};
    const ParticleLanes moved[2] = {gather(state.moving, corners[0]),
                                    gather(state.moving, corners[1])};
    const Vec3<Lanes> d = (gather(state.bases, corners[1]).x - gather(state.bases, corners[0]).x) +
                          (moved[1].x - moved[0].x);
    const auto joint =
        begin_joint(pair[0], pair[1], d, load_lanes(block.parameters[Constraint::kRest] + lane),
                    load_lanes(block.parameters[Constraint::kStiffness] + lane));
    Lanes multipliers[Constraint::kMultiplierCount];
    joint.store(multipliers);
    unroll<Constraint::kMultiplierCount>([&](auto m) PBDSURG_INLINE_LAMBDA {
      store_lanes(multipliers[m], range.multipliers[slot / kBlockLanes].values[m] + lane);
    });
    unroll<2>([&](auto k) PBDSURG_INLINE_LAMBDA {
      const Vec3<Lanes> force = Lanes(k == 0 ? 1 : -1) * joint.force;
      pair[k].push(force);
      scatter({pair[k].way, pair[k].is_known}, ends.ways, corners[k]);
      const Vec3<Lanes> flight = gather(state.flights, corners[k]).x;
      scatter({flight + pushed_flight(force, moved[k].w, Lanes(state.substep.inverse_dt_squared)),
               Lanes(kToLeastEnergy)},
              state.flights, corners[k]);
    });
  }
}

// As add_damping() does of volumes.
HWY_INLINE void damp_strips(const DampedRows& rows, const VertexBlock& block,
                            const RegisterStart& access, Lanes inverse_dt) {
  const Vec3<Lanes> x = access.position(block.corners);
  StripFace face;
  for (Index i = block.strips.first; i < block.strips.first + block.strips.count; ++i) {
    const DampedRow& from = rows.damped_strips[i];
    const Lanes signed_stiffness = access.load(from.stiffness);
    face.step(access.position(rows.strips[i].corners) - x, signed_stiffness);
    const Lanes start = dot(face.a, cross(face.b - face.a, face.c - face.a));
    const Lanes given = abs(signed_stiffness), rest = access.load(from.target);
    const Lanes damping = access.load(from.damping) * inverse_dt;
    const Lanes sum = given + damping;
    access.store(select(has_sign(signed_stiffness), -sum, sum), rows.strips[i].stiffness);
    access.store(select(damping > Lanes(0), (given * rest + damping * start) / sum, rest),
                 rows.strips[i].target);
  }
}

template <class Damp>
HWY_INLINE void for_each_start(const VertexBlock& block, const Particle* bases,
                               const Carry* carries, const Damp& damp) {
  for (Index lane = 0; block.is_damped && lane < kBlockLanes; lane += kLanes) {
    damp(RegisterStart{bases, carries, gather(bases, block.corners + lane).x, lane});
  }
}

HWY_FLATTEN void damp_rows(const DampedRows& rows, const Particle* bases, const Carry* carries,
                           float inverse_dt, Index first, Index last) {
  for (Index b = first; b < last; ++b) {
    const VertexBlock& block = rows.blocks[b];
    for_each_start(block, bases, carries, [&](const RegisterStart& start) PBDSURG_INLINE_LAMBDA {
      if constexpr (kFast) {
        damp_strips(rows, block, start, Lanes(inverse_dt));
        add_damping(rows, without_strips(block), start, Lanes(inverse_dt));
      } else {
        add_damping(rows, block, start, Lanes(inverse_dt));
      }
    });
  }
}

HWY_FLATTEN void damp_volumes(const DampedRows& rows, const Particle* bases, const Carry* carries,
                              float inverse_dt, Index block_index) {
  VertexBlock block = rows.blocks[block_index];
  block.springs.count = block.hinges.count = block.triangles.count = 0;
  for_each_start(block, bases, carries, [&](const RegisterStart& start) PBDSURG_INLINE_LAMBDA {
    add_damping(rows, block, start, Lanes(inverse_dt));
  });
}

template <class Constraint>
constexpr ConstraintKernels<Constraint> kernels_of() {
  using Kind = KindOf<Constraint>;
  ConstraintKernels<Constraint> kernels{};
  if constexpr (Kind::kHasFraction) {
    kernels.project_fraction = &project<Constraint, ProjectionMode::fraction, false>;
  }
  kernels.project_compliance = &project<Constraint, ProjectionMode::compliance, false>;
  kernels.project_damped = &project<Constraint, ProjectionMode::compliance, Kind::kHasCompliance>;
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
                                    &predict_positions,
                                    &update_velocities,
                                    &predict_displacements,
                                    &settle,
                                    &solve_vertices,
                                    &push_vertices,
                                    &find_residuals,
                                    &displace,
                                    &stiffest,
                                    &find_loose_ends,
                                    &begin_joints,
                                    &damp_rows,
                                    kFast ? &damp_volumes : nullptr};

}  // namespace pbdsurg::PBDSURG_LANES_NAMESPACE
