// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a DynamicColoring keeps of constraints and vertices, changed in time proportional to the
/// change.

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/bits.h"
#include "pbdsurg/base/types.h"

#include "lib/base/list_pool.h"
#include "lib/coloring/color_masks.h"

namespace pbdsurg {

/// The vertices of each constraint, by id.
class ConstraintStore {
 public:
  explicit ConstraintStore(int arity) : arity_(arity) {}

  [[nodiscard]] int arity() const noexcept { return arity_; }
  [[nodiscard]] std::span<const Index> operator[](Index id) const noexcept {
    return arity_ == 0 ? varying_[id] : std::span(fixed_).subspan(begin(id), arity_);
  }

  void resize(std::size_t count) {
    if (arity_ == 0) {
      varying_.resize(count);
    } else {
      fixed_.resize(count * arity_);
    }
  }
  void assign(Index id, std::span<const Index> vertices) {
    if (arity_ == 0) {
      varying_.assign(id, vertices);
    } else {
      std::copy(vertices.begin(), vertices.end(),
                fixed_.begin() + static_cast<std::ptrdiff_t>(begin(id)));
    }
  }
  void clear(Index id) {
    if (arity_ == 0) {
      varying_.clear(id);
    }
  }

 private:
  [[nodiscard]] std::size_t begin(Index id) const noexcept {
    return static_cast<std::size_t>(id) * arity_;
  }

  int arity_;
  std::vector<Index> fixed_;
  ListPool varying_;
};

/// The colours at each vertex and the constraint that holds each: a mask, and a list in the order
/// of the colours, so that a holder stands where as many bits lie below its colour.
class VertexColors {
 public:
  [[nodiscard]] Index vertex_count() const noexcept { return vertex_count_; }
  void add_vertices(Index count) {
    vertex_count_ += count;
    bits_.resize(static_cast<std::size_t>(vertex_count_) * words_, 0);
    holders_.resize(static_cast<std::size_t>(vertex_count_));
  }

  void clear() {
    std::fill(bits_.begin(), bits_.end(), 0);
    for (Index v = 0; v < vertex_count_; ++v) {
      holders_.clear(v);
    }
  }

  // Makes room for colours below color_count.
  void widen(Index color_count) {
    const int needed = (color_count + 63) / 64;
    if (needed <= words_) {
      return;
    }
    const int wider = std::max(needed, words_ + (words_ + 1) / 2);
    std::vector<std::uint64_t> bits(static_cast<std::size_t>(vertex_count_) * wider, 0);
    for (std::size_t v = 0; v < static_cast<std::size_t>(vertex_count_); ++v) {
      std::copy_n(bits_.data() + v * words_, words_, bits.data() + v * wider);
    }
    bits_ = std::move(bits);
    words_ = wider;
  }

  [[nodiscard]] ColorMasks masks() noexcept { return {bits_.data(), words_}; }
  [[nodiscard]] std::span<const Index> holders(Index vertex) const noexcept {
    return holders_[vertex];
  }

  void fetch(Index vertex) noexcept {
    __builtin_prefetch(&masks().word(vertex, 0));
    __builtin_prefetch(holders_[vertex].data());
  }
  void reserve(Index vertex, Index constraints) {
    holders_.reserve(vertex, static_cast<std::size_t>(constraints));
  }
  void put(Index vertex, Index color, Index id) {
    holders_.insert(vertex, colors_below(vertex, color), id);
    masks().word(vertex, color >> 6) |= std::uint64_t{1} << (color & 63);
  }
  void take(Index vertex, Index color) {
    holders_.erase(vertex, colors_below(vertex, color));
    masks().word(vertex, color >> 6) &= ~(std::uint64_t{1} << (color & 63));
  }

 private:
  [[nodiscard]] Index colors_below(Index vertex, Index color) noexcept {
    Index count = count_bits(masks().word(vertex, color >> 6) & low_bits(color & 63));
    for (int i = 0; i < color >> 6; ++i) {
      count += count_bits(masks().word(vertex, i));
    }
    return count;
  }

  Index vertex_count_ = 0;
  int words_ = 1;
  std::vector<std::uint64_t> bits_;  // [vertex_count * words]
  ListPool holders_;                 // [vertex_count]
};

/// How many constraints each vertex has, and the most that any has.
class Valences {
 public:
  void add_vertices(Index count) { of_vertex_.resize(of_vertex_.size() + count, 0); }

  void add(std::span<const Index> vertices) {
    for (const Index v : vertices) {
      const Index valence = ++of_vertex_[v];
      if (static_cast<std::size_t>(valence) >= vertices_of_.size()) {
        vertices_of_.resize(static_cast<std::size_t>(valence) + 1, 0);
      }
      --vertices_of_[valence - 1];
      ++vertices_of_[valence];
      most_ = std::max(most_, valence);
    }
  }
  void subtract(std::span<const Index> vertices) {
    for (const Index v : vertices) {
      const Index valence = of_vertex_[v]--;
      --vertices_of_[valence];
      ++vertices_of_[valence - 1];
      if (vertices_of_[most_] == 0) {
        --most_;  // there now is one more of these
      }
    }
  }

  [[nodiscard]] Index operator[](Index vertex) const noexcept { return of_vertex_[vertex]; }
  [[nodiscard]] Index most() const noexcept { return most_; }
  [[nodiscard]] Index most(std::span<const Index> vertices) const noexcept {
    Index most = 0;
    for (const Index v : vertices) {
      most = std::max(most, of_vertex_[v]);
    }
    return most;
  }

 private:
  std::vector<Index> of_vertex_;
  std::vector<Index> vertices_of_{0};  // [most + 1] vertices of each valence but 0
  Index most_ = 0;
};

}  // namespace pbdsurg
