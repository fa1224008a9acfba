// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The three-component vector of the constraint maths: plain enough for device code and for any
/// scalar type. Public arrays use Eigen types instead.

#include "pbdsurg/base/host_device.h"

namespace pbdsurg {

/// Three numbers, or three vector registers of numbers.
template <class Scalar>
struct Vec3 {
  Scalar x{},  ///< first
      y{},     ///< second
      z{};     ///< third
};

/// Component by component.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Vec3<Scalar> operator+(Vec3<Scalar> a, Vec3<Scalar> b) {
  return {a.x + b.x, a.y + b.y, a.z + b.z};
}

/// Component by component.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Vec3<Scalar> operator-(Vec3<Scalar> a, Vec3<Scalar> b) {
  return {a.x - b.x, a.y - b.y, a.z - b.z};
}

/// Each component times a number.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Vec3<Scalar> operator*(Scalar s, Vec3<Scalar> a) {
  return {s * a.x, s * a.y, s * a.z};
}

/// Scalar product.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Scalar dot(Vec3<Scalar> a, Vec3<Scalar> b) {
  return a.x * b.x + a.y * b.y + a.z * b.z;
}

/// Vector product, right-handed.
template <class Scalar>
PBDSURG_HOST_DEVICE constexpr Vec3<Scalar> cross(Vec3<Scalar> a, Vec3<Scalar> b) {
  return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

}  // namespace pbdsurg
