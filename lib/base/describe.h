// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Numbers and points as they appear in error messages.

#include <Eigen/Core>
#include <sstream>
#include <string>

namespace pbdsurg {

inline std::string describe(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

inline std::string describe(const Eigen::Vector3d& point) {
  std::ostringstream text;
  text << '(' << point.x() << ", " << point.y() << ", " << point.z() << ')';
  return text.str();
}

}  // namespace pbdsurg
