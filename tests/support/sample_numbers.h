// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Numbers as files of meshes hold them.

#include <algorithm>
#include <bit>
#include <cstring>
#include <locale>
#include <sstream>
#include <string>

#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/mesh_data.h"

namespace pbdsurg::testing {

/// The bytes of a number.
template <class Number>
std::string packed(Number value, std::endian order) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (order != std::endian::native) {
    std::reverse(bytes.begin(), bytes.end());
  }
  return bytes;
}

/// With all digits.
inline std::string text(double value) {
  std::ostringstream out;
  out.imbue(std::locale::classic());
  out.precision(17);
  out << value;
  return out.str();
}

inline std::string point_text(const Eigen::Vector3d& p) {
  return text(p.x()) + ' ' + text(p.y()) + ' ' + text(p.z());
}

/// The vertices of an element, a space before each.
/// @param base  the number of the first vertex
template <class Element>
std::string ids_text(const Element& element, int base) {
  std::string out;
  for (const Index v : element) {
    out += ' ' + std::to_string(v + base);
  }
  return out;
}

}  // namespace pbdsurg::testing
