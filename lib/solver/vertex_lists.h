// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What there is at each vertex, while it changes.

#include <algorithm>
#include <cstddef>
#include <span>

#include "pbdsurg/core/types.h"
#include "pbdsurg/mesh/topology.h"

#include "coloring/list_pool.h"

namespace pbdsurg {

/// A list of ids for each vertex, ascending, so that it does not matter in which order they came.
class VertexLists {
 public:
  VertexLists() = default;
  explicit VertexLists(const IndexLists& lists) : vertex_count_(lists.list_count()) {
    pool_.resize(static_cast<std::size_t>(vertex_count_));
    pool_.reserve_room(0, lists.entries.size() * 2);
    for (Index v = 0; v < vertex_count_; ++v) {
      pool_.assign(v, lists[v]);
    }
  }

  [[nodiscard]] std::span<const Index> operator[](Index vertex) const noexcept {
    return pool_[vertex];
  }

  // Cost: proportional to the vertex's list.
  void insert(Index vertex, Index id) { pool_.insert(vertex, position_of(vertex, id), id); }
  void erase(Index vertex, Index id) { pool_.erase(vertex, position_of(vertex, id)); }

  /// Vertices with empty lists follow, or the last ones go, with what is there.
  void resize(Index vertex_count) {
    for (Index v = vertex_count; v < vertex_count_; ++v) {
      pool_.clear(v);
    }
    pool_.resize(static_cast<std::size_t>(vertex_count));
    vertex_count_ = vertex_count;
  }

  /// Makes room for more vertices, and for so many entries more in all.
  void reserve(std::size_t vertices, std::size_t entries) { pool_.reserve_room(vertices, entries); }

  [[nodiscard]] std::size_t memory_bytes() const noexcept { return pool_.memory_bytes(); }

 private:
  [[nodiscard]] Index position_of(Index vertex, Index id) const noexcept {
    const auto list = pool_[vertex];
    return static_cast<Index>(std::ranges::lower_bound(list, id) - list.begin());
  }

  ListPool pool_;
  Index vertex_count_ = 0;
};

}  // namespace pbdsurg
