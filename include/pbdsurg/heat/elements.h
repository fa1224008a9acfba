// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Elements that conduct: tetrahedra of solids and triangles of sheets, told apart by one number.

#include <concepts>
#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"

namespace pbdsurg {

/// The element that is a triangle of a tissue; one that is a tetrahedron has that's id. Below
/// kInvalidIndex, and triangle_of_element() of itself.
[[nodiscard]] constexpr Index element_of_triangle(Index triangle) noexcept {
  return 2 * kInvalidIndex - triangle;
}
/// Which triangle of the tissue an element is.
/// @param element  for which is_triangle()
[[nodiscard]] constexpr Index triangle_of_element(Index element) noexcept {
  return 2 * kInvalidIndex - element;
}
/// Whether an element is a triangle of a sheet.
[[nodiscard]] constexpr bool is_triangle(Index element) noexcept {
  return element < kInvalidIndex;
}
/// 3 or 4
[[nodiscard]] constexpr int corner_count(Index element) noexcept {
  return is_triangle(element) ? 3 : 4;
}

/// A value of each element. Ids are not checked.
template <class Value>
struct ElementValues {
  std::vector<Value> tets;       ///< [tet_count]
  std::vector<Value> triangles;  ///< [triangle_count]

  /// That of an element.
  [[nodiscard]] Value& operator[](Index element) {
    return is_triangle(element) ? triangles[static_cast<std::size_t>(triangle_of_element(element))]
                                : tets[static_cast<std::size_t>(element)];
  }
  /// Likewise.
  [[nodiscard]] const Value& operator[](Index element) const {
    return is_triangle(element) ? triangles[static_cast<std::size_t>(triangle_of_element(element))]
                                : tets[static_cast<std::size_t>(element)];
  }
  /// Keeps what there is; what is new gets a value.
  void resize(Index tet_count, Index triangle_count, const Value& value = {}) {
    tets.resize(static_cast<std::size_t>(tet_count), value);
    triangles.resize(static_cast<std::size_t>(triangle_count), value);
  }
  /// The same value for all.
  void assign(Index tet_count, Index triangle_count, const Value& value) {
    tets.assign(static_cast<std::size_t>(tet_count), value);
    triangles.assign(static_cast<std::size_t>(triangle_count), value);
  }
};

/// Reads numbers of elements. Ids are not checked.
struct ElementSpan {
  std::span<const double> tets{};       ///< [tet_count]
  std::span<const double> triangles{};  ///< [triangle_count]

  ElementSpan() = default;  ///< of none
  /// Of a tissue without sheets: those of tetrahedra.
  template <std::convertible_to<std::span<const double>> Values>
  ElementSpan(const Values& of_tets)  // NOLINT(google-explicit-constructor): as a span does
      : tets(of_tets) {}
  /// Of both.
  ElementSpan(const ElementValues<double>& values)  // NOLINT(google-explicit-constructor): likewise
      : tets(values.tets), triangles(values.triangles) {}

  /// That of an element.
  [[nodiscard]] double operator[](Index element) const {
    return is_triangle(element) ? triangles[static_cast<std::size_t>(triangle_of_element(element))]
                                : tets[static_cast<std::size_t>(element)];
  }
};

}  // namespace pbdsurg
