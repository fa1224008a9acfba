// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Positions as integers of 32 bits, for sweeps over vertices: the difference between neighbours is
/// exact wherever a body is, and a neighbour is one load of 16 bytes. Numbers wrap around: a
/// difference is right as long as neighbours are no further apart than 2^31 units. A template on
/// numbers or registers of them, which bring nearest_int(), to_float() and shifted_up().

#include <cmath>
#include <cstdint>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/select.h"
#include "pbdsurg/base/vec3.h"
#include "pbdsurg/constraints/projection.h"

namespace pbdsurg {

/// Where a vertex is, as wide as a particle.
struct alignas(16) FixedPoint {
  std::uint32_t x, y, z;  ///< units, modulo 2^32
  float unit;             ///< m, a power of two; not a number where the vertex is lost
};

inline constexpr float kUsualUnit = 0x1p-32F;  ///< m: for edges of 4 mm, see choose_unit()

/// By so many bits a number is split that has more digits than an integer.
inline constexpr int kSplitBits = 24;

PBDSURG_HOST_DEVICE inline std::uint32_t nearest_int(float number) {
#if defined(__CUDA_ARCH__)
  return static_cast<std::uint32_t>(__float2int_rn(number));
#else
  return static_cast<std::uint32_t>(static_cast<std::int32_t>(std::nearbyintf(number)));
#endif
}
PBDSURG_HOST_DEVICE inline float to_float(std::uint32_t number) {
  return static_cast<float>(static_cast<std::int32_t>(number));
}
PBDSURG_HOST_DEVICE inline std::uint32_t shifted_up(std::uint32_t number) {
  return number << kSplitBits;
}

/// Whether no integer overflows: up to 2^50 units, which is hundreds of kilometres.
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto is_fixable(const Vec3<Scalar>& v, Scalar inverse_unit) {
  constexpr double kMost = 0x1p50;
  const Vec3<Scalar> units = inverse_unit * v;
  return dot(units, units) < Scalar(kMost * kMost);
}

/// A vector in units, to the nearest.
/// @param v  m, is_fixable()
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto fixed(const Vec3<Scalar>& v, Scalar inverse_unit) {
  using Int = decltype(nearest_int(v.x));
  const auto fix = [&](const Scalar& x) {
    const Scalar units = inverse_unit * x;  // exact, and so is what it is split into
    const Int high = nearest_int(Scalar(1.0 / (1 << kSplitBits)) * units);
    const Int low = nearest_int(units - Scalar(1 << kSplitBits) * to_float(high));
    return shifted_up(high) + low;
  };
  return Vec3<Int>{fix(v.x), fix(v.y), fix(v.z)};
}

/// m, from one fixed point to another.
template <class Scalar, class Int>
PBDSURG_HOST_DEVICE inline Vec3<Scalar> fixed_difference(const Vec3<Int>& to, const Vec3<Int>& from,
                                                         Scalar unit) {
  const Vec3<Int> way = to - from;
  return {unit * to_float(way.x), unit * to_float(way.y), unit * to_float(way.z)};
}

PBDSURG_HOST_DEVICE inline FixedPoint lost_point() {
  return {0, 0, 0, kNoNumber};
}
PBDSURG_HOST_DEVICE inline bool is_lost(const FixedPoint& point) {
  return !(point.unit > 0);
}

/// @param unit  m, a power of two
PBDSURG_HOST_DEVICE inline FixedPoint fixed_point(const Vec3<float>& base, const Vec3<float>& u,
                                                  float unit) {
  const float inverse_unit = 1 / unit;
  if (!is_fixable(base, inverse_unit) || !is_fixable(u, inverse_unit)) {
    return lost_point();
  }
  const Vec3<std::uint32_t> point = fixed(base, inverse_unit) + fixed(u, inverse_unit);
  return {point.x, point.y, point.z, unit};
}

/// Where a vertex is without its displacement; what was lost stays so.
/// @param inverse_unit  1/m, of the point's unit
PBDSURG_HOST_DEVICE inline FixedPoint without_move(const FixedPoint& point, const Vec3<float>& u,
                                                   float inverse_unit) {
  const Vec3<std::uint32_t> base =
      Vec3<std::uint32_t>{point.x, point.y, point.z} - fixed(u, inverse_unit);
  return {base.x, base.y, base.z, point.unit};
}

/// And with another one, which may lose it.
PBDSURG_HOST_DEVICE inline FixedPoint with_move(const FixedPoint& base, const Vec3<float>& u,
                                                float inverse_unit) {
  if (is_lost(base) || !is_fixable(u, inverse_unit)) {
    return lost_point();
  }
  const Vec3<std::uint32_t> point =
      Vec3<std::uint32_t>{base.x, base.y, base.z} + fixed(u, inverse_unit);
  return {point.x, point.y, point.z, base.unit};
}

/// Both at once.
/// @param before  m, the displacement of this point
PBDSURG_HOST_DEVICE inline FixedPoint moved_point(const FixedPoint& point,
                                                  const Vec3<float>& before, const Vec3<float>& u) {
  const float inverse_unit = 1 / point.unit;
  return is_lost(point) ? point
                        : with_move(without_move(point, before, inverse_unit), u, inverse_unit);
}

}  // namespace pbdsurg
