// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/coloring.h"

#include <algorithm>
#include <bit>
#include <cstdint>
#include <string>

#include "pbdsurg/core/error.h"

namespace pbdsurg {
namespace {

void check_constraints(const ConstraintVertices& constraints) {
  if (constraints.arity < 1 || constraints.vertex_count < 0 ||
      constraints.vertices.size() % static_cast<std::size_t>(constraints.arity) != 0) {
    throw InvalidArgument(std::to_string(constraints.vertices.size()) +
                          " ids do not make constraints of " + std::to_string(constraints.arity) +
                          " vertices each, out of " + std::to_string(constraints.vertex_count));
  }
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    const std::span<const Index> vertices = constraints[c];
    for (std::size_t i = 0; i < vertices.size(); ++i) {
      if (vertices[i] < 0 || vertices[i] >= constraints.vertex_count) {
        throw InvalidArgument("constraint " + std::to_string(c) + " refers to vertex " +
                              std::to_string(vertices[i]) + "; ids must be in [0, " +
                              std::to_string(constraints.vertex_count) + ")");
      }
      if (std::find(vertices.begin(), vertices.begin() + i, vertices[i]) != vertices.begin() + i) {
        throw InvalidArgument("constraint " + std::to_string(c) + " lists vertex " +
                              std::to_string(vertices[i]) + " twice; its vertices must differ");
      }
    }
  }
}

// The colours seen at each vertex, as rows of 64-bit words that widen when a colour does not fit.
class ColorMasks {
 public:
  explicit ColorMasks(Index vertex_count)
      : vertex_count_(vertex_count), masks_(static_cast<std::size_t>(vertex_count), 0) {}

  Index take_lowest_free(std::span<const Index> vertices) {
    for (std::size_t word = 0;; ++word) {
      if (word == words_) {
        widen();
      }
      std::uint64_t used = 0;
      for (const Index v : vertices) {
        used |= masks_[v * words_ + word];
      }
      if (used != ~std::uint64_t{0}) {
        const int bit = std::countr_one(used);
        for (const Index v : vertices) {
          masks_[v * words_ + word] |= std::uint64_t{1} << bit;
        }
        return static_cast<Index>(64 * word) + bit;
      }
    }
  }

 private:
  void widen() {
    std::vector<std::uint64_t> wider(static_cast<std::size_t>(vertex_count_) * (words_ + 1), 0);
    for (std::size_t v = 0; v < static_cast<std::size_t>(vertex_count_); ++v) {
      std::copy_n(masks_.begin() + v * words_, words_, wider.begin() + v * (words_ + 1));
    }
    masks_ = std::move(wider);
    ++words_;
  }

  Index vertex_count_;
  std::size_t words_ = 1;
  std::vector<std::uint64_t> masks_;  // [vertex_count * words]
};

}  // namespace

Index clique_bound(const ConstraintVertices& constraints) {
  check_constraints(constraints);
  std::vector<Index> valence(static_cast<std::size_t>(constraints.vertex_count), 0);
  for (const Index v : constraints.vertices) {
    ++valence[v];
  }
  return valence.empty() ? 0 : *std::max_element(valence.begin(), valence.end());
}

Coloring color_greedy(const ConstraintVertices& constraints) {
  check_constraints(constraints);
  Coloring coloring;
  coloring.color_of.resize(static_cast<std::size_t>(constraints.constraint_count()));
  ColorMasks masks(constraints.vertex_count);
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    coloring.color_of[c] = masks.take_lowest_free(constraints[c]);
    coloring.color_count = std::max(coloring.color_count, coloring.color_of[c] + 1);
  }
  return coloring;
}

std::optional<ColorConflict> find_conflict(const Coloring& coloring,
                                           const ConstraintVertices& constraints) {
  check_constraints(constraints);
  if (coloring.color_of.size() != static_cast<std::size_t>(constraints.constraint_count())) {
    throw InvalidArgument("a colouring of " + std::to_string(coloring.color_of.size()) +
                          " constraints does not fit " +
                          std::to_string(constraints.constraint_count()) + " constraints");
  }
  if (coloring.color_count < 0) {
    throw InvalidArgument("a colouring has " + std::to_string(coloring.color_count) + " colours");
  }
  // constraints of each colour in ascending order, then the last one seen at each vertex
  std::vector<std::vector<Index>> members(static_cast<std::size_t>(coloring.color_count));
  for (Index c = 0; c < constraints.constraint_count(); ++c) {
    const Index color = coloring.color_of[c];
    if (color < 0 || color >= coloring.color_count) {
      throw InvalidArgument("constraint " + std::to_string(c) + " has colour " +
                            std::to_string(color) + "; colours must be in [0, " +
                            std::to_string(coloring.color_count) + ")");
    }
    members[color].push_back(c);
  }
  struct Visit {
    Index color = kInvalidIndex;
    Index constraint = kInvalidIndex;
  };
  std::vector<Visit> last(static_cast<std::size_t>(constraints.vertex_count));
  for (Index color = 0; color < coloring.color_count; ++color) {
    for (const Index c : members[color]) {
      for (const Index v : constraints[c]) {
        if (last[v].color == color) {
          return ColorConflict{color, last[v].constraint, c, v};
        }
        last[v] = {color, c};
      }
    }
  }
  return std::nullopt;
}

}  // namespace pbdsurg
