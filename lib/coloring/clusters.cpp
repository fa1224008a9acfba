// SPDX-License-Identifier: Apache-2.0
#include "pbdsurg/coloring/clusters.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"

#include "lib/coloring/constraint_access.h"

namespace pbdsurg {
namespace {

template <class Access>
class Growth {
 public:
  Growth(const Access& constraints, const IndexLists& vertex_constraints)
      : constraints_(constraints),
        vertex_constraints_(vertex_constraints),
        taken_(static_cast<std::size_t>(constraints.count), false),
        shared_(static_cast<std::size_t>(constraints.count), 0),
        free_(static_cast<std::size_t>(vertex_constraints.list_count())),
        last_cluster_(free_.size(), kInvalidIndex) {
    std::adjacent_difference(vertex_constraints.offsets.begin() + 1,
                             vertex_constraints.offsets.end(), free_.begin());
  }

  ConstraintClusters run(Index size) {
    for (Index c = 0; c < constraints_.count; ++c) {
      for (Index seed = taken_[c] ? kInvalidIndex : c; seed != kInvalidIndex;) {
        seed = grow(seed, size);
      }
    }
    return std::move(clusters_);
  }

 private:
  // Returns a constraint beside the cluster to start the next one at, if there is one left.
  Index grow(Index seed, Index size) {
    candidates_.clear();
    add(seed);
    for (Index count = 1; count < size && !candidates_.empty(); ++count) {
      const auto best = find_best();
      const Index c = *best;
      *best = candidates_.back();
      candidates_.pop_back();
      add(c);
    }
    close_cluster();
    return candidates_.empty() ? kInvalidIndex : *find_best();
  }

  void add(Index c) {
    const Index cluster = clusters_.members.list_count();
    taken_[c] = true;
    shared_[c] = 0;
    clusters_.members.entries.push_back(c);
    for (const Index v : constraints_[c]) {
      --free_[v];
      if (last_cluster_[v] == cluster) {
        continue;
      }
      last_cluster_[v] = cluster;
      clusters_.vertices.entries.push_back(v);
      for (const Index other : vertex_constraints_[v]) {
        if (!taken_[other] && shared_[other]++ == 0) {
          candidates_.push_back(other);
        }
      }
    }
  }

  void close_cluster() {
    IndexLists& members = clusters_.members;
    members.offsets.push_back(static_cast<Index>(members.entries.size()));
    IndexLists& vertices = clusters_.vertices;
    std::sort(vertices.entries.begin() + vertices.offsets.back(), vertices.entries.end());
    vertices.offsets.push_back(static_cast<Index>(vertices.entries.size()));
    for (const Index c : candidates_) {
      shared_[c] = 0;
    }
  }

  // Adds the fewest vertices; then has the fewest free constraints around it: those that wait
  // longest find nobody left to join.
  std::vector<Index>::iterator find_best() {
    return std::min_element(candidates_.begin(), candidates_.end(), [&](Index a, Index b) {
      const auto ids_a = constraints_[a];
      const auto ids_b = constraints_[b];
      const Index added_a = ids_a.size() - shared_[a];
      const Index added_b = ids_b.size() - shared_[b];
      if (added_a != added_b) {
        return added_a < added_b;
      }
      const Index free_a = count_free(ids_a);
      const Index free_b = count_free(ids_b);
      return free_a != free_b ? free_a < free_b : a < b;
    });
  }

  template <class Ids>
  [[nodiscard]] Index count_free(const Ids& ids) const {
    Index count = 0;
    for (const Index v : ids) {
      count += free_[v];
    }
    return count;
  }

  const Access& constraints_;
  const IndexLists& vertex_constraints_;
  std::vector<bool> taken_;          // [constraint_count] is in a cluster
  std::vector<Index> shared_;        // [constraint_count] vertices in the growing cluster
  std::vector<Index> free_;          // [vertex_count] constraints not taken yet
  std::vector<Index> last_cluster_;  // [vertex_count] the last cluster that has the vertex
  std::vector<Index> candidates_;    // not taken, with a vertex in the cluster
  ConstraintClusters clusters_;
};

}  // namespace

ConstraintClusters cluster_constraints(const ConstraintVertices& constraints, Index size) {
  if (size < 1) {
    throw InvalidArgument("a cluster of " + std::to_string(size) +
                          " constraints; it takes at least one");
  }
  const IndexLists vertex_constraints = find_vertex_constraints(constraints);
  ConstraintClusters clusters;
  with_arity(constraints,
             [&](const auto& access) { clusters = Growth(access, vertex_constraints).run(size); });
  return clusters;
}

}  // namespace pbdsurg
