// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A register of numbers that the constraint maths takes for one: lane by lane the same operations.
///
/// For sources that are compiled once per instruction set and rounding (lane_kernels.cpp), which
/// name the namespace PBDSURG_LANES_NAMESPACE so that no two objects share a symbol, and say with
/// PBDSURG_LANES_FAST whether estimates may stand for division and square root.

#include <cstdint>
#include <limits>

#define HWY_COMPILE_ONLY_STATIC
#include <hwy/highway.h>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/vec3.h"

#include "lib/solver/methods/fixed_point.h"
#include "lib/solver/sets/constraint_block.h"
#include "lib/solver/state/particle.h"

namespace pbdsurg::PBDSURG_LANES_NAMESPACE {

namespace hn = hwy::HWY_NAMESPACE;

using Tag = hn::CappedTag<float, kBlockLanes>;
using Register = hn::Vec<Tag>;
inline constexpr Index kLanes = static_cast<Index>(hn::MaxLanes(Tag()));
static_assert(kLanes == PBDSURG_LANES_COUNT, "Highway takes the flags for another instruction set");
inline constexpr bool kFast = PBDSURG_LANES_FAST;

struct Lanes {
  Register value;

  Lanes() : value(hn::Zero(Tag())) {}
  explicit Lanes(double number) : value(hn::Set(Tag(), static_cast<float>(number))) {}
  Lanes(Register lanes) : value(lanes) {}
};

struct LaneMask {
  hn::Mask<Tag> value;
};

HWY_INLINE Lanes operator+(Lanes a, Lanes b) {
  return hn::Add(a.value, b.value);
}
HWY_INLINE Lanes operator-(Lanes a, Lanes b) {
  return hn::Sub(a.value, b.value);
}
HWY_INLINE Lanes operator*(Lanes a, Lanes b) {
  return hn::Mul(a.value, b.value);
}
HWY_INLINE Lanes operator-(Lanes a) {
  return hn::Neg(a.value);
}

// An estimate, refined once by Newton's method: some 2 to 4 units in the last place.
HWY_INLINE Lanes operator/(Lanes a, Lanes b) {
  if constexpr (kFast) {
    const Lanes estimate = hn::ApproximateReciprocal(b.value);
    return a * (estimate * (Lanes(2) - b * estimate));
  } else {
    return hn::Div(a.value, b.value);
  }
}

HWY_INLINE Lanes sqrt(Lanes a) {
  if constexpr (kFast) {
    const Lanes estimate = hn::ApproximateReciprocalSqrt(a.value);
    return a * (estimate * (Lanes(1.5) - (Lanes(0.5) * a) * (estimate * estimate)));
  } else {
    return hn::Sqrt(a.value);
  }
}

HWY_INLINE Lanes abs(Lanes a) {
  return hn::Abs(a.value);
}
HWY_INLINE Lanes max(Lanes a, Lanes b) {
  return hn::Max(a.value, b.value);
}

HWY_INLINE LaneMask operator>(Lanes a, Lanes b) {
  return {hn::Gt(a.value, b.value)};
}
HWY_INLINE LaneMask operator<(Lanes a, Lanes b) {
  return {hn::Lt(a.value, b.value)};
}
HWY_INLINE LaneMask operator&(LaneMask a, LaneMask b) {
  return {hn::And(a.value, b.value)};
}
HWY_INLINE Lanes select(LaneMask condition, Lanes a, Lanes b) {
  return hn::IfThenElse(condition.value, a.value, b.value);
}

/// A register of integers modulo 2^32.
struct IntLanes {
  using IntTag = hn::RebindToSigned<Tag>;

  hn::Vec<IntTag> value;

  IntLanes() : value(hn::Zero(IntTag())) {}
  IntLanes(hn::Vec<IntTag> lanes) : value(lanes) {}
};
HWY_INLINE IntLanes operator+(IntLanes a, IntLanes b) {
  return hn::Add(a.value, b.value);
}
HWY_INLINE IntLanes operator-(IntLanes a, IntLanes b) {
  return hn::Sub(a.value, b.value);
}
HWY_INLINE IntLanes nearest_int(Lanes a) {
  return hn::NearestInt(a.value);
}
HWY_INLINE Lanes to_float(IntLanes a) {
  return hn::ConvertTo(Tag(), a.value);
}
HWY_INLINE IntLanes shifted_up(IntLanes a) {
  return hn::ShiftLeft<kSplitBits>(a.value);
}
HWY_INLINE IntLanes bits_as_int(Lanes a) {
  return hn::BitCast(IntLanes::IntTag(), a.value);
}
HWY_INLINE Lanes bits_as_float(IntLanes a) {
  return hn::BitCast(Tag(), a.value);
}

/// Whether there is a sign, of zero, too.
HWY_INLINE LaneMask has_sign(Lanes a) {
  return {hn::RebindMask(Tag(), hn::Lt(bits_as_int(a).value, hn::Zero(IntLanes::IntTag())))};
}

/// As the template of this name. Estimates end where numbers lose their normal form.
HWY_INLINE LaneMask is_usable(Lanes a) {
  constexpr float kLeast = kFast ? 8 * std::numeric_limits<float>::min() : 0;
  constexpr float kMost =
      kFast ? std::numeric_limits<float>::max() / 8 : std::numeric_limits<float>::infinity();
  return (a > Lanes(kLeast)) & (a < Lanes(kMost));
}

/// One bit for each lane, the first lane's the lowest.
HWY_INLINE std::uint32_t bits_of(LaneMask mask) {
  std::uint64_t bits = 0;
  hn::StoreMaskBits(Tag(), mask.value, reinterpret_cast<std::uint8_t*>(&bits));
  return static_cast<std::uint32_t>(bits);
}
HWY_INLINE LaneMask mask_of(std::uint32_t bits) {
  const std::uint64_t wide = bits & ((std::uint64_t{1} << kLanes) - 1);
  return {hn::LoadMaskBits(Tag(), reinterpret_cast<const std::uint8_t*>(&wide))};
}

/// @param numbers  [kLanes] aligned to its own size
HWY_INLINE Lanes load_lanes(const float* numbers) {
  return hn::Load(Tag(), numbers);
}
HWY_INLINE void store_lanes(Lanes lanes, float* numbers) {
  hn::Store(lanes.value, Tag(), numbers);
}

namespace detail {

using Quad = hn::Full128<float>;
using QuadRegister = hn::Vec<Quad>;
using Wide = hn::RepartitionToWide<Tag>;

/// Quads `stride` apart from the first on, side by side.
template <class D, class Stored>
HWY_INLINE hn::Vec<D> gather_quads(D, const Stored* quads, const ParticleOffset* corners) {
  constexpr int kQuads = static_cast<int>(hn::MaxLanes(D())) / 4;
  if constexpr (kQuads == 1) {
    return hn::Load(Quad(), reinterpret_cast<const float*>(&at(quads, *corners)));
  } else {
    const hn::Half<D> half;
    return hn::Combine(D(), gather_quads(half, quads, corners + 2 * kQuads),
                       gather_quads(half, quads, corners));
  }
}

template <class D, class Stored>
HWY_INLINE void scatter_quads(D, hn::Vec<D> lanes, Stored* quads, const ParticleOffset* corners) {
  constexpr int kQuads = static_cast<int>(hn::MaxLanes(D())) / 4;
  if constexpr (kQuads == 1) {
    hn::Store(lanes, Quad(), reinterpret_cast<float*>(&at(quads, *corners)));
  } else {
    const hn::Half<D> half;
    scatter_quads(half, hn::LowerHalf(half, lanes), quads, corners);
    scatter_quads(half, hn::UpperHalf(half, lanes), quads, corners + 2 * kQuads);
  }
}

HWY_INLINE Lanes lower_pairs(Register a, Register b) {
  return hn::BitCast(Tag(),
                     hn::InterleaveLower(Wide(), hn::BitCast(Wide(), a), hn::BitCast(Wide(), b)));
}
HWY_INLINE Lanes upper_pairs(Register a, Register b) {
  return hn::BitCast(Tag(),
                     hn::InterleaveUpper(Wide(), hn::BitCast(Wide(), a), hn::BitCast(Wide(), b)));
}

}  // namespace detail

/// Particles of kLanes vertices, transposed.
struct ParticleLanes {
  Vec3<Lanes> x;
  Lanes w;
};

/// @tparam Stored  a particle, or what an array as wide has of it
/// @param corners   [kLanes]
template <class Stored>
HWY_INLINE ParticleLanes gather(const Stored* quads, const ParticleOffset* corners) {
  const Register a = detail::gather_quads(Tag(), quads, corners);
  const Register b = detail::gather_quads(Tag(), quads, corners + 1);
  const Register c = detail::gather_quads(Tag(), quads, corners + 2);
  const Register d = detail::gather_quads(Tag(), quads, corners + 3);
  const Register xy_low = hn::InterleaveLower(Tag(), a, b);  // x x y y
  const Register xy_high = hn::InterleaveLower(Tag(), c, d);
  const Register zw_low = hn::InterleaveUpper(Tag(), a, b);
  const Register zw_high = hn::InterleaveUpper(Tag(), c, d);
  return {{detail::lower_pairs(xy_low, xy_high), detail::upper_pairs(xy_low, xy_high),
           detail::lower_pairs(zw_low, zw_high)},
          detail::upper_pairs(zw_low, zw_high)};
}

/// @param corners  [kLanes] all different
template <class Stored>
HWY_INLINE void scatter(const ParticleLanes& lanes, Stored* quads, const ParticleOffset* corners) {
  const Register xy_low = hn::InterleaveLower(Tag(), lanes.x.x.value, lanes.x.y.value);
  const Register xy_high = hn::InterleaveUpper(Tag(), lanes.x.x.value, lanes.x.y.value);
  const Register zw_low = hn::InterleaveLower(Tag(), lanes.x.z.value, lanes.w.value);
  const Register zw_high = hn::InterleaveUpper(Tag(), lanes.x.z.value, lanes.w.value);
  detail::scatter_quads(Tag(), detail::lower_pairs(xy_low, zw_low).value, quads, corners);
  detail::scatter_quads(Tag(), detail::upper_pairs(xy_low, zw_low).value, quads, corners + 1);
  detail::scatter_quads(Tag(), detail::lower_pairs(xy_high, zw_high).value, quads, corners + 2);
  detail::scatter_quads(Tag(), detail::upper_pairs(xy_high, zw_high).value, quads, corners + 3);
}

}  // namespace pbdsurg::PBDSURG_LANES_NAMESPACE
