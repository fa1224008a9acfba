// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Checks of the vertices that elements name.

#include <span>

#include "pbdsurg/base/types.h"

#include "lib/base/check.h"

namespace pbdsurg {

/// @param elements  Edge, Triangle or Tet
/// @throws InvalidArgument  naming the vertex out of [0, vertex_count), or that count if negative
template <class Element>
void check_vertex_ids(Index vertex_count, std::span<const Element> elements) {
  check(vertex_count >= 0, "vertex_count", vertex_count, "not negative");
  for (const Element& element : elements) {
    for (const Index v : element) {
      check_id("vertex", v, static_cast<std::size_t>(vertex_count));
    }
  }
}

}  // namespace pbdsurg
