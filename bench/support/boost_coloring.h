// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The yardstick: Boost Graph's sequential first fit, which needs the conflict graph.

#include <algorithm>
#include <utility>
#include <vector>

#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <boost/graph/sequential_vertex_coloring.hpp>

#include "pbdsurg/coloring/coloring.h"

namespace pbdsurg::bench {

class BoostColoring {
 public:
  /// Builds the conflict graph, in the form that Boost reads fastest.
  explicit BoostColoring(const ConstraintVertices& constraints) : graph_(make_graph(constraints)) {}

  [[nodiscard]] Coloring color() const {
    Coloring coloring;
    coloring.color_of.resize(boost::num_vertices(graph_));
    const auto index = boost::get(boost::vertex_index, graph_);
    coloring.color_count = static_cast<Index>(boost::sequential_vertex_coloring(
        graph_, boost::make_iterator_property_map(coloring.color_of.begin(), index)));
    return coloring;
  }

 private:
  using Graph =
      boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, boost::no_property,
                                         boost::no_property, Index, Index>;

  static Graph make_graph(const ConstraintVertices& constraints) {
    const IndexLists lists = find_vertex_constraints(constraints);
    std::vector<std::pair<Index, Index>> conflicts;
    std::vector<Index> near;
    for (Index c = 0; c < constraints.constraint_count(); ++c) {
      near.clear();
      for (const Index v : constraints[c]) {
        near.insert(near.end(), lists[v].begin(), lists[v].end());
      }
      std::sort(near.begin(), near.end());
      near.erase(std::unique(near.begin(), near.end()), near.end());
      for (const Index other : near) {
        if (other != c) {
          conflicts.emplace_back(c, other);
        }
      }
    }
    return {boost::edges_are_sorted, conflicts.begin(), conflicts.end(),
            constraints.constraint_count()};
  }

  Graph graph_;
};

}  // namespace pbdsurg::bench
