// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What there is at each vertex, while it changes.

#include <algorithm>
#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/mesh/topology.h"

#include "lib/base/list_pool.h"

namespace pbdsurg {

/// A list of ids for each vertex, ascending, so that it does not matter in which order they came.
/// Undo as of an UndoArray.
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
  void insert(Index vertex, Index id) {
    log_.push_back({vertex, id, true});
    put_in(vertex, id);
  }
  void erase(Index vertex, Index id) {
    log_.push_back({vertex, id, false});
    take_out(vertex, id);
  }

  /// Vertices with empty lists follow.
  void resize(std::size_t vertex_count) {
    pool_.resize(vertex_count);
    vertex_count_ = static_cast<Index>(vertex_count);
  }

  void begin_edit() noexcept {
    log_.clear();
    count_before_ = vertex_count_;
  }

  void undo() {
    for (; !log_.empty(); log_.pop_back()) {
      const auto [vertex, id, was_added] = log_.back();
      if (was_added) {
        take_out(vertex, id);
      } else {
        put_in(vertex, id);
      }
    }
    for (Index v = count_before_; v < vertex_count_; ++v) {
      pool_.clear(v);
    }
    resize(static_cast<std::size_t>(count_before_));
  }

  /// Makes room for more vertices, for so many entries more in all, and for an edit that changes so
  /// many.
  void reserve(std::size_t vertices, std::size_t entries, std::size_t writes) {
    pool_.reserve_room(vertices, entries);
    log_.reserve(std::min(writes, kEntriesOfEdit));
  }

  [[nodiscard]] std::size_t memory_bytes() const noexcept {
    return pool_.memory_bytes() + log_.capacity() * sizeof(Entry);
  }

 private:
  struct Entry {
    Index vertex, id;
    bool was_added;
  };

  [[nodiscard]] Index position_of(Index vertex, Index id) const noexcept {
    const auto list = pool_[vertex];
    return static_cast<Index>(std::ranges::lower_bound(list, id) - list.begin());
  }
  void put_in(Index vertex, Index id) { pool_.insert(vertex, position_of(vertex, id), id); }
  void take_out(Index vertex, Index id) { pool_.erase(vertex, position_of(vertex, id)); }

  ListPool pool_;
  Index vertex_count_ = 0;
  Index count_before_ = 0;
  std::vector<Entry> log_;
};

}  // namespace pbdsurg
