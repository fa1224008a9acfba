// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Choice without a branch, so that constraint maths runs on one number or on a vector register of
/// them, each with its own answer. Types of such registers bring their own comparisons and
/// select().

#include <type_traits>

#include "pbdsurg/base/host_device.h"
#include "pbdsurg/base/vec3.h"

namespace pbdsurg {

/// One of two numbers.
/// @return  a where the condition holds, else b; both are computed
template <class Scalar>
requires std::is_arithmetic_v<Scalar> PBDSURG_HOST_DEVICE constexpr Scalar select(
    bool condition, std::type_identity_t<Scalar> a, Scalar b) {
  return condition ? a : b;
}

/// As above, component by component.
template <class Condition, class Scalar>
PBDSURG_HOST_DEVICE constexpr Vec3<Scalar> select(const Condition& condition, const Vec3<Scalar>& a,
                                                  const Vec3<Scalar>& b) {
  return {select(condition, a.x, b.x), select(condition, a.y, b.y), select(condition, a.z, b.z)};
}

}  // namespace pbdsurg
