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

inline constexpr float kUsualUnit = 0x1p-32F;  ///< m: edges of 16 mm may be stretched 30 times

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

/// Whether no integer overflows.
/// @param base  m, where a vertex was
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto is_fixable_base(const Vec3<Scalar>& base, Scalar inverse_unit) {
  constexpr double kMost = 0x1p50;
  const Vec3<Scalar> units = inverse_unit * base;
  return dot(units, units) < Scalar(kMost * kMost);
}
/// @param u  m, its displacement from there
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto is_fixable_way(const Vec3<Scalar>& u, Scalar inverse_unit) {
  constexpr double kMost = 0x1p30;
  const Vec3<Scalar> units = inverse_unit * u;
  return dot(units, units) < Scalar(kMost * kMost);
}

/// @param u  m, is_fixable_way()
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto fixed_way(const Vec3<Scalar>& u, Scalar inverse_unit) {
  using Int = decltype(nearest_int(u.x));
  return Vec3<Int>{nearest_int(inverse_unit * u.x), nearest_int(inverse_unit * u.y),
                   nearest_int(inverse_unit * u.z)};
}

/// @param base  m, is_fixable_base()
template <class Scalar>
PBDSURG_HOST_DEVICE inline auto fixed_base(const Vec3<Scalar>& base, Scalar inverse_unit) {
  using Int = decltype(nearest_int(base.x));
  const auto fix = [&](const Scalar& x) {
    const Scalar units = inverse_unit * x;  // exact, and so is what it is split into
    const Int high = nearest_int(Scalar(1.0 / (1 << kSplitBits)) * units);
    const Int low = nearest_int(units - Scalar(1 << kSplitBits) * to_float(high));
    return shifted_up(high) + low;
  };
  return Vec3<Int>{fix(base.x), fix(base.y), fix(base.z)};
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
  if (!is_fixable_base(base, inverse_unit) || !is_fixable_way(u, inverse_unit)) {
    return lost_point();
  }
  const Vec3<std::uint32_t> point = fixed_base(base, inverse_unit) + fixed_way(u, inverse_unit);
  return {point.x, point.y, point.z, unit};
}

/// The same for another displacement; what was lost stays so.
/// @param before  m, the displacement of this point
PBDSURG_HOST_DEVICE inline FixedPoint moved_point(const FixedPoint& point,
                                                  const Vec3<float>& before, const Vec3<float>& u) {
  const float inverse_unit = 1 / point.unit;
  if (is_lost(point) || !is_fixable_way(u, inverse_unit)) {
    return lost_point();
  }
  const Vec3<std::uint32_t> moved = Vec3<std::uint32_t>{point.x, point.y, point.z} +
                                    fixed_way(u, inverse_unit) - fixed_way(before, inverse_unit);
  return {moved.x, moved.y, moved.z, point.unit};
}

}  // namespace pbdsurg
