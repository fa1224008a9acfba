// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/edge_ownership.h"

#include <algorithm>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/coloring/constraint_vertices.h"

namespace pbdsurg {
namespace {

using TetEdges = std::span<const std::array<Index, 6>>;

void check_tet_edges(Index edge_count, TetEdges tet_edges) {
  if (edge_count < 0) {
    throw InvalidArgument("edge_count is " + std::to_string(edge_count) +
                          "; it cannot be negative");
  }
  std::vector<bool> has_tet(static_cast<std::size_t>(edge_count), false);
  for (std::size_t t = 0; t < tet_edges.size(); ++t) {
    const auto& edges = tet_edges[t];
    for (auto edge = edges.begin(); edge != edges.end(); ++edge) {
      if (*edge < 0 || *edge >= edge_count) {
        throw InvalidArgument("tetrahedron " + std::to_string(t) + " has edge " +
                              std::to_string(*edge) + "; ids must be in [0, " +
                              std::to_string(edge_count) + ")");
      }
      if (std::find(edges.begin(), edge, *edge) != edge) {
        throw InvalidArgument("tetrahedron " + std::to_string(t) + " has edge " +
                              std::to_string(*edge) + " twice; its edges must differ");
      }
      has_tet[*edge] = true;
    }
  }
  const auto alone = std::find(has_tet.begin(), has_tet.end(), false);
  if (alone != has_tet.end()) {
    throw InvalidArgument("edge " + std::to_string(alone - has_tet.begin()) +
                          " belongs to no tetrahedron; one must own it");
  }
}

// A tet can pass an edge that it owns on to another tet around that edge. Paths of such steps lead
// from tets that own too many edges to tets that have room for one more.
class Ownership {
 public:
  Ownership(Index edge_count, TetEdges tet_edges)
      : tet_edges_(tet_edges),
        edge_tets_(find_vertex_constraints({tet_edges, edge_count})),
        owner_(static_cast<std::size_t>(edge_count)),
        load_(tet_edges.size(), 0),
        distance_(tet_edges.size()) {
    for (Index edge = 0; edge < edge_count; ++edge) {
      const auto around = edge_tets_[edge];
      owner_[edge] = *std::min_element(around.begin(), around.end(),
                                       [&](Index a, Index b) { return load_[a] < load_[b]; });
      ++load_[owner_[edge]];
    }
  }

  [[nodiscard]] const std::vector<Index>& owner() const { return owner_; }
  [[nodiscard]] int max_load() const {
    return load_.empty() ? 0 : *std::max_element(load_.begin(), load_.end());
  }

  // Takes edges from tets with more than `limit` until none is left or no path leads on, which
  // proves that there is no such assignment. No load rises above the limit.
  void lower_to(int limit) {
    while (measure_distances(limit)) {
      next_ = edge_tets_.offsets;
      for (std::size_t i = 0; i < source_count_; ++i) {
        while (load_[reached_[i]] > limit && follow_path(reached_[i], limit)) {
        }
      }
    }
  }

 private:
  static constexpr Index kFar = kInvalidIndex;  // not reached, or known to lead nowhere

  // Steps from the nearest overloaded tet, up to the nearest tets with room; whether there are any.
  bool measure_distances(int limit) {
    std::fill(distance_.begin(), distance_.end(), kFar);
    reached_.clear();
    for (Index t = 0; t < static_cast<Index>(load_.size()); ++t) {
      if (load_[t] > limit) {
        distance_[t] = 0;
        reached_.push_back(t);
      }
    }
    source_count_ = reached_.size();
    for (std::size_t i = 0; i < reached_.size(); ++i) {
      const Index t = reached_[i];
      if (load_[t] < limit) {
        return true;
      }
      for (const Index edge : tet_edges_[t]) {
        if (owner_[edge] != t) {
          continue;
        }
        for (const Index other : edge_tets_[edge]) {
          if (distance_[other] == kFar) {
            distance_[other] = distance_[t] + 1;
            reached_.push_back(other);
          }
        }
      }
    }
    return false;
  }

  // Walks away from the overloaded tet, backwards out of dead ends, and passes edges on along the
  // path to the first tet with room.
  bool follow_path(Index source, int limit) {
    tets_.assign(1, source);
    edges_.clear();
    while (load_[tets_.back()] >= limit) {
      if (step_on(tets_.back())) {
        continue;
      }
      distance_[tets_.back()] = kFar;
      tets_.pop_back();
      if (tets_.empty()) {
        return false;
      }
      edges_.pop_back();
    }
    for (std::size_t i = 0; i < edges_.size(); ++i) {
      owner_[edges_[i]] = tets_[i + 1];
    }
    --load_[source];
    ++load_[tets_.back()];
    return true;
  }

  // A tet once passed over is never a way on again before distances change: next_ remembers.
  bool step_on(Index t) {
    for (const Index edge : tet_edges_[t]) {
      if (owner_[edge] != t) {
        continue;
      }
      for (Index& next = next_[edge]; next < edge_tets_.offsets[edge + 1]; ++next) {
        const Index other = edge_tets_.entries[next];
        if (distance_[other] == distance_[t] + 1) {
          tets_.push_back(other);
          edges_.push_back(edge);
          return true;
        }
      }
    }
    return false;
  }

  TetEdges tet_edges_;
  IndexLists edge_tets_;
  std::vector<Index> owner_;     // [edge_count]
  std::vector<int> load_;        // [tet_count] edges owned
  std::vector<Index> distance_;  // [tet_count]
  std::vector<Index> reached_;   // tets by distance; the overloaded ones come first
  std::size_t source_count_ = 0;
  std::vector<Index> next_;          // [edge_count + 1] the tet around an edge to look at next
  std::vector<Index> tets_, edges_;  // a path: edge i passes from tet i to tet i + 1
};

}  // namespace

EdgeOwnership assign_edges_to_tets(Index edge_count, TetEdges tet_edges) {
  check_tet_edges(edge_count, tet_edges);
  Ownership ownership(edge_count, tet_edges);
  const auto tet_count = static_cast<Index>(tet_edges.size());
  int most = ownership.max_load();
  while (std::int64_t{most - 1} * tet_count >= edge_count) {
    ownership.lower_to(most - 1);
    if (ownership.max_load() == most) {
      break;
    }
    --most;
  }

  EdgeOwnership result{ownership.owner(), {}, most};
  result.owned_edges.assign(tet_edges.size(), 0);
  for (Index t = 0; t < tet_count; ++t) {
    for (int i = 0; i < 6; ++i) {
      if (result.owner[tet_edges[t][i]] == t) {
        result.owned_edges[t] |= static_cast<std::uint8_t>(1 << i);
      }
    }
  }
  return result;
}

}  // namespace pbdsurg
