// SPDX-License-Identifier: Apache-2.0
#include "lib/device/filling_lists.h"

namespace pbdsurg::cuda {

FillingLists::FillingLists(const Filling::Surface& surface, std::span<const Index> place_of_vertex)
    : firsts(surface.vertices.size() + 1, 0),
      triangles_at(3 * surface.triangles.size()),
      hole_ends(surface.hole_ends.begin(), surface.hole_ends.end()),
      wall_count(surface.wall_count) {
  for (const Index v : surface.vertices) {
    places.push_back(place_of_vertex[v]);
  }
  for (const auto& [a, b, c] : surface.triangles) {
    triangles.push_back({{a, b, c}});
    for (const Index i : {a, b, c}) {
      ++firsts[static_cast<std::size_t>(i) + 1];
    }
  }
  for (std::size_t i = 0; i + 1 < firsts.size(); ++i) {
    firsts[i + 1] += firsts[i];
  }
  std::vector<Index> next(firsts.begin(), firsts.end() - 1);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    for (const Index i : triangles[t].corners) {
      triangles_at[next[i]++] = static_cast<Index>(t);
    }
  }
}

}  // namespace pbdsurg::cuda
