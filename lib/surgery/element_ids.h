// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Elements that go along with a compaction.

#include <vector>

#include "pbdsurg/heat/elements.h"
#include "pbdsurg/heat/thermal_mesh.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/tissue/renumber.h"

namespace pbdsurg {

/// The new id; kInvalidIndex for one that has gone.
inline Index new_element(Index element, const Renumbering& ids) {
  if (!is_triangle(element)) {
    return new_id(element, ids.tets);
  }
  const Index triangle = new_id(triangle_of_element(element), ids.triangles);
  return triangle == kInvalidIndex ? kInvalidIndex : element_of_triangle(triangle);
}

/// Those of a list that live, in their order.
inline void renumber_elements(std::vector<Index>& list, const Renumbering& ids) {
  std::ranges::transform(list, list.begin(), [&](Index id) { return new_element(id, ids); });
  std::erase(list, kInvalidIndex);
}

/// @param mesh  after the compaction
template <class Value>
void renumber_elements(ElementValues<Value>& values, const Renumbering& ids,
                       const ThermalMesh& mesh) {
  renumber_values(values.tets, ids.tets, static_cast<std::size_t>(mesh.tet_count()));
  renumber_values(values.triangles, ids.triangles, static_cast<std::size_t>(mesh.triangle_count()));
}

}  // namespace pbdsurg
