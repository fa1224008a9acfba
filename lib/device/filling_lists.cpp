// SPDX-License-Identifier: Apache-2.0
#include "lib/device/filling_lists.h"

#include <algorithm>

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

std::vector<WallTies> find_ties(std::span<const std::span<const Index>> walls,
                                const PieceLists& pieces, std::size_t place_count) {
  std::vector<Index> piece_of(place_count);
  pieces.find_pieces(piece_of);
  std::vector<bool> is_of_earlier(place_count, false);
  std::vector<WallTies> ties;
  for (const std::span<const Index> wall : walls) {
    auto& [is_shared, own_pieces, is_anchored] = ties.emplace_back();
    for (const Index place : wall) {
      is_shared.push_back(is_of_earlier[place] ? 1 : 0);
      is_of_earlier[place] = true;
      if (piece_of[place] == kInvalidIndex) {
        is_anchored = true;
      } else {
        own_pieces.push_back(piece_of[place]);
      }
    }
    std::ranges::sort(own_pieces);
    own_pieces.erase(std::unique(own_pieces.begin(), own_pieces.end()), own_pieces.end());
  }
  return ties;
}

}  // namespace pbdsurg::cuda
