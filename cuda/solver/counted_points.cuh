// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Fixed points that tell how often their vertices have moved: one access of 16 bytes for both.

#include <cstdint>

#include "cuda/solver/kernel_support.cuh"

/// Accesses of 16 bytes that order nothing but themselves: since PTX 8.3.
#define PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS (CUDART_VERSION >= 12030)

namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE {
namespace {

/// The count of a point is in the low bits of its unit, a power of two or not a number: bits that
/// are zero in both. It starts anew from zero once it has no more bits, so that counts that follow
/// one another can be told from each other, and no others.
constexpr auto kCountBits = static_cast<std::uint32_t>(TileArrays::kCountBits);
constexpr std::uint32_t kIsEarlier = (kCountBits >> 1) + 1;

__device__ inline FixedPoint load_counted(const FixedPoint* point) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  std::uint64_t low, high;
  asm volatile(
      "{\n\t.reg .b128 point;\n\t"
      "ld.relaxed.gpu.global.b128 point, [%2];\n\t"
      "mov.b128 {%0, %1}, point;\n\t}"
      : "=l"(low), "=l"(high)
      : "l"(point)
      : "memory");
  return {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(low >> 32),
          static_cast<std::uint32_t>(high),
          __uint_as_float(static_cast<std::uint32_t>(high >> 32))};
#else
  return load_point(point);
#endif
}

/// The same where it is wanted, without a branch.
__device__ inline void reload_counted(FixedPoint& point, const FixedPoint* at, bool is_wanted) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  std::uint64_t low = std::uint64_t{point.y} << 32 | point.x;
  std::uint64_t high = std::uint64_t{__float_as_uint(point.unit)} << 32 | point.z;
  asm volatile(
      "{\n\t.reg .b128 point;\n\t.reg .pred wanted;\n\t"
      "setp.ne.u32 wanted, %3, 0;\n\t"
      "mov.b128 point, {%0, %1};\n\t"
      "@wanted ld.relaxed.gpu.global.b128 point, [%2];\n\t"
      "mov.b128 {%0, %1}, point;\n\t}"
      : "+l"(low), "+l"(high)
      : "l"(at), "r"(static_cast<std::uint32_t>(is_wanted))
      : "memory");
  point = {static_cast<std::uint32_t>(low), static_cast<std::uint32_t>(low >> 32),
           static_cast<std::uint32_t>(high),
           __uint_as_float(static_cast<std::uint32_t>(high >> 32))};
#else
  point = is_wanted ? load_point(at) : point;
#endif
}

__device__ inline void store_counted(FixedPoint* to, const FixedPoint& point, Index count) {
#if PBDSURG_CUDA_TOOLKIT_HAS_WIDE_ACCESS
  const std::uint32_t unit =
      __float_as_uint(point.unit) | (static_cast<std::uint32_t>(count) & kCountBits);
  const std::uint64_t low = std::uint64_t{point.y} << 32 | point.x;
  const std::uint64_t high = std::uint64_t{unit} << 32 | point.z;
  asm volatile(
      "{\n\t.reg .b128 point;\n\t"
      "mov.b128 point, {%1, %2};\n\t"
      "st.relaxed.gpu.global.b128 [%0], point;\n\t}"
      :
      : "l"(to), "l"(low), "l"(high)
      : "memory");
#else
  static_cast<void>(count);
  store_point(to, point);
#endif
}

/// Whether the count of a point is before this one.
/// @param count  in which other bits than those of a count mean nothing
__device__ inline bool is_before(const FixedPoint& point, std::uint32_t count) {
  return ((__float_as_uint(point.unit) - count) & kIsEarlier) != 0;
}
__device__ inline FixedPoint without_count(const FixedPoint& point) {
  return {point.x, point.y, point.z, __uint_as_float(__float_as_uint(point.unit) & ~kCountBits)};
}

__device__ inline Vec3<float> way_between(const FixedPoint& from, const FixedPoint& to) {
  return fixed_difference<float, std::uint32_t>({to.x, to.y, to.z}, {from.x, from.y, from.z},
                                                to.unit);
}

}  // namespace
}  // namespace pbdsurg::cuda::PBDSURG_KERNELS_NAMESPACE
