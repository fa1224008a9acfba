// SPDX-License-Identifier: Apache-2.0
#include "lib/surgery/cut_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <utility>

#include "pbdsurg/mesh/topology.h"

#include "lib/surgery/cut_geometry.h"

namespace pbdsurg {
namespace {

using Eigen::Vector3d;

Edge edge_between(Index a, Index b) {
  return {std::min(a, b), std::max(a, b)};
}

class Division {
 public:
  Division(const CutNeighborhood& near, const CutSides& sides, const CutOptions& options)
      : near_(near),
        options_(options),
        geometry_(near, sides, result_.splits),
        vertex_count_(static_cast<Index>(near.positions.size())) {}

  CutPieces run() {
    if (options_.style == CutStyle::through_tets) {
      find_vertex_sides();
      find_split_edges();
      divide();
    } else {
      take_whole();
    }
    return std::move(result_);
  }

 private:
  void find_vertex_sides() {
    heights_.assign(near_.positions.size(), std::nan(""));
    signs_.assign(near_.positions.size(), 0);
    for (const Tet& tet : near_.tets) {
      for (const Index v : tet) {
        if (std::isnan(heights_[v])) {
          heights_[v] = geometry_.height(geometry_.position(v));
          signs_[v] = sign_of(heights_[v]);
        }
      }
    }
    for (const Index v : near_.front.vertices) {
      signs_[v] = 0;
    }
  }

  [[nodiscard]] bool is_crossed(Index a, Index b) const { return signs_[a] * signs_[b] < 0; }

  [[nodiscard]] bool is_mixed(const Tet& tet) const {
    return std::ranges::any_of(kTetEdges,
                               [&](const auto& e) { return is_crossed(tet[e[0]], tet[e[1]]); });
  }

  // Where the surface crosses an edge, as a share of its length.
  [[nodiscard]] double crossing(Index first, Index second) const {
    return heights_[first] / (heights_[first] - heights_[second]);
  }

  // Whether the middle of a mixed tetrahedron's section lies on the surface.
  [[nodiscard]] bool is_entered(const Tet& tet) const {
    if (!std::ranges::all_of(tet, [&](Index v) { return near_.is_reached[v]; })) {
      return false;
    }
    Vector3d section = Vector3d::Zero();  // sum of its corners
    int count = 0;
    for (const Index v : tet) {
      if (signs_[v] == 0) {
        section += geometry_.position(v);
        ++count;
      }
    }
    for (const auto& [i, j] : kTetEdges) {
      if (is_crossed(tet[i], tet[j])) {
        const Vector3d x = geometry_.position(tet[i]);
        section += x + crossing(tet[i], tet[j]) * (geometry_.position(tet[j]) - x);
        ++count;
      }
    }
    return geometry_.surface_is_at(section / count, geometry_.longest_edge(tet));
  }

  // Edges of cut tetrahedra from one side to the other, after vertices next to a crossing were
  // taken to lie on the surface.
  void find_split_edges() {
    std::vector<bool> is_snapped(near_.positions.size(), false);
    is_cut_.assign(near_.tets.size(), false);
    for (std::size_t i = 0; i < near_.tets.size(); ++i) {
      const Tet& tet = near_.tets[i];
      is_cut_[i] = is_mixed(tet) && is_entered(tet);
      if (!is_cut_[i]) {
        continue;
      }
      for (const auto& [j, k] : kTetEdges) {
        if (is_crossed(tet[j], tet[k])) {
          const double share = crossing(tet[j], tet[k]);
          if (share < options_.snap) {
            is_snapped[tet[j]] = true;
          } else if (share > 1 - options_.snap) {
            is_snapped[tet[k]] = true;
          }
        }
      }
    }
    for (std::size_t v = 0; v < is_snapped.size(); ++v) {
      if (is_snapped[v]) {
        signs_[v] = 0;
      }
    }
    for (std::size_t i = 0; i < near_.tets.size(); ++i) {
      const Tet& tet = near_.tets[i];
      is_cut_[i] = is_cut_[i] && is_mixed(tet);
      for (const auto& [j, k] : kTetEdges) {
        if (is_cut_[i] && is_crossed(tet[j], tet[k])) {
          result_.split_edges.push_back(edge_between(tet[j], tet[k]));
        }
      }
    }
    std::sort(result_.split_edges.begin(), result_.split_edges.end());
    result_.split_edges.erase(std::unique(result_.split_edges.begin(), result_.split_edges.end()),
                              result_.split_edges.end());
    for (const Edge& edge : result_.split_edges) {
      const double share = crossing(edge[0], edge[1]);
      result_.splits.push_back({edge[0], edge[1], static_cast<float>(share)});
    }
  }

  // No piece of a cut tetrahedron has vertices on both sides, and each has one off the surface.
  [[nodiscard]] int side_of(const Tet& corners) const {
    bool above = false, below = false;
    double height = 0;
    for (const Index v : corners) {
      if (v < vertex_count_) {
        above |= signs_[v] > 0;
        below |= signs_[v] < 0;
        height += heights_[v];
      }
    }
    return above && below ? 0 : (above ? 1 : (below ? -1 : sign_of(height)));
  }

  void divide() {
    std::vector<Tet> children;
    for (std::size_t i = 0; i < near_.tets.size(); ++i) {
      const Tet& tet = near_.tets[i];
      children.assign(1, tet);
      if (is_mixed(tet)) {
        bisect_edges(tet, children);
      }
      const bool is_divided = children.size() > 1;
      for (const Tet& child : children) {
        const int side = is_divided && !is_cut_[i] ? 0 : side_of(child);
        result_.pieces.push_back({child, static_cast<Index>(i), is_divided, side});
      }
    }
  }

  // Bisects those edges of a tetrahedron that split, in the order of their vertices.
  void bisect_edges(const Tet& tet, std::vector<Tet>& children) const {
    std::array<Edge, 6> edges;
    for (std::size_t e = 0; e < 6; ++e) {
      edges[e] = edge_between(tet[kTetEdges[e][0]], tet[kTetEdges[e][1]]);
    }
    std::sort(edges.begin(), edges.end());
    for (const Edge& edge : edges) {
      const auto place =
          std::lower_bound(result_.split_edges.begin(), result_.split_edges.end(), edge);
      if (place != result_.split_edges.end() && *place == edge) {
        bisect(children, edge,
               vertex_count_ + static_cast<Index>(place - result_.split_edges.begin()));
      }
    }
  }

  static void bisect(std::vector<Tet>& tets, const Edge& edge, Index middle) {
    for (std::size_t i = 0, count = tets.size(); i < count; ++i) {
      const auto first = std::ranges::find(tets[i], edge[0]) - tets[i].begin();
      const auto second = std::ranges::find(tets[i], edge[1]) - tets[i].begin();
      if (first < 4 && second < 4) {
        tets.push_back(tets[i]);
        tets[i][second] = middle;
        tets.back()[first] = middle;
      }
    }
  }

  void take_whole() {
    for (Index t = 0; t < static_cast<Index>(near_.tets.size()); ++t) {
      const Tet& tet = near_.tets[t];
      const std::array<Vector3d, 4> x{geometry_.position(tet[0]), geometry_.position(tet[1]),
                                      geometry_.position(tet[2]), geometry_.position(tet[3])};
      result_.pieces.push_back({tet, t, false, sign_of(geometry_.height(mean(x)))});
    }
  }

  const CutNeighborhood& near_;
  const CutOptions& options_;
  CutPieces result_;
  CutGeometry geometry_;
  Index vertex_count_;

  std::vector<double> heights_;  // [vertex_count] m
  std::vector<int> signs_;       // [vertex_count] of heights, 0 for snapped vertices
  std::vector<bool> is_cut_;     // [tets]
};

}  // namespace

CutPieces make_cut_pieces(const CutNeighborhood& near, const CutSides& sides,
                          const CutOptions& options) {
  return Division(near, sides, options).run();
}

}  // namespace pbdsurg
