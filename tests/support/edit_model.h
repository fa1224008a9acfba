// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What the growing part of an edit means, on plain arrays: vertices split, corners moved,
/// tetrahedra divided. Says what an edit does wrong.

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <string>
#include <vector>

#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

class EditModel {
 public:
  explicit EditModel(const TetMesh& mesh)
      : positions(mesh.positions().begin(), mesh.positions().end()),
        tets(mesh.tets().begin(), mesh.tets().end()),
        alive(tets.size(), true) {}

  std::vector<Eigen::Vector3d> positions;  // m
  std::vector<Tet> tets;
  std::vector<bool> alive;
  std::vector<Link> links{};

  [[nodiscard]] std::vector<Tet> live_tets() const {
    std::vector<Tet> live;
    for (std::size_t t = 0; t < tets.size(); ++t) {
      if (alive[t]) {
        live.push_back(tets[t]);
      }
    }
    return live;
  }

  [[nodiscard]] double volume() const {
    double sum = 0;
    for (const Tet& tet : live_tets()) {
      sum += tet_volume(positions, tet);
    }
    return sum;
  }

  [[nodiscard]] double boundary_area() const { return area_of(find_boundary(live_tets())); }

  /// Applies an edit.
  /// @return  what is wrong with it, empty if nothing is
  std::string apply(const TopologyEdit& edit) {
    const double area = boundary_area();
    const Index first_new = static_cast<Index>(positions.size());
    std::set<Edge> edges;
    for (const Edge& edge : find_edges(live_tets())) {
      edges.insert(edge);
    }
    for (const NewVertex& v : edit.new_vertices) {
      if (v.first < 0 || v.second < 0 || std::max(v.first, v.second) >= first_new) {
        return "a new vertex lies between vertices that are not there";
      }
      if (v.first != v.second && edges.count({v.first, v.second}) == 0) {
        return "a new vertex lies on no edge";
      }
      if (!(v.share >= 0 && v.share <= 1)) {
        return "a new vertex lies beyond its edge";
      }
      positions.push_back(positions[v.first] +
                          v.share * (positions[v.second] - positions[v.first]));
    }
    const auto is_copy = [&](Index v, Index of) {
      return v >= first_new && v < static_cast<Index>(positions.size()) &&
             edit.new_vertices[v - first_new].first == of &&
             edit.new_vertices[v - first_new].second == of;
    };

    std::set<Index> moved;
    for (const CornerMove& move : edit.corner_moves) {
      moved.insert(move.tet);
      const auto corner = std::find(tets[move.tet].begin(), tets[move.tet].end(), move.from);
      if (!alive[move.tet] || corner == tets[move.tet].end() || !is_copy(move.to, move.from)) {
        return "a corner moves from where it is not, or to what is no copy";
      }
      *corner = move.to;
    }
    for (const LinkMove& move : edit.link_moves) {
      Index& end =
          links[move.link].first == move.from ? links[move.link].first : links[move.link].second;
      if (end != move.from || !is_copy(move.to, move.from)) {
        return "a link moves from where it is not, or to what is no copy";
      }
      end = move.to;
    }

    std::map<Index, double> filled;
    const std::size_t tet_count = tets.size();
    for (const NewTet& child : edit.new_tets) {
      if (child.parent < 0 || child.parent >= static_cast<Index>(tet_count) ||
          !alive[child.parent] || moved.count(child.parent) > 0) {
        return "a new tetrahedron has a parent that is dead or moved";
      }
      Eigen::Matrix4d weights = Eigen::Matrix4d::Zero();  // of the parent's corners, by column
      for (int i = 0; i < 4; ++i) {
        const Index v = child.vertices[i];
        const NewVertex at = v < first_new ? NewVertex{v, v} : edit.new_vertices[v - first_new];
        const Tet& parent = tets[child.parent];
        const auto first = std::find(parent.begin(), parent.end(), at.first) - parent.begin();
        const auto second = std::find(parent.begin(), parent.end(), at.second) - parent.begin();
        if (first == 4 || second == 4) {
          return "a new tetrahedron reaches out of its parent";
        }
        weights(first, i) += 1 - at.share;
        weights(second, i) += at.share;
      }
      if (!(weights.determinant() > 0)) {
        return "a new tetrahedron is flat or inverted";
      }
      least_share = std::min(least_share, weights.determinant());
      filled[child.parent] += weights.determinant();
      tets.push_back(child.vertices);
      alive.push_back(true);
    }
    for (const auto& [parent, share] : filled) {
      if (std::abs(share - 1) > 1e-6) {
        return "new tetrahedra do not fill their parent";
      }
      alive[parent] = false;
    }

    // sewn up again where it parted, the mesh must have the surface that it had: a vertex of one
    // tetrahedron within the face of another would leave triangles over
    std::map<std::pair<Index, Index>, Index> places;
    std::vector<Tet> sewn = live_tets();
    for (Tet& tet : sewn) {
      for (Index& v : tet) {
        if (v >= first_new) {
          const NewVertex& at = edit.new_vertices[v - first_new];
          v = at.first == at.second
                  ? at.first
                  : places.emplace(std::pair(at.first, at.second), v).first->second;
        }
      }
    }
    if (std::abs(area_of(find_boundary(sewn)) - area) > 1e-6 * area) {
      return "tetrahedra do not agree on their faces";
    }
    return "";
  }

  double least_share = 1;  ///< of a parent's volume, over all children there were

  /// Whether a vertex joins tetrahedra that share no faces around it.
  [[nodiscard]] bool is_pinched() const {
    const std::vector<Tet> live = live_tets();
    const IndexLists around = find_vertex_tets(static_cast<Index>(positions.size()), live);
    for (Index v = 0; v < around.list_count(); ++v) {
      // what is left of tetrahedra without v are triangles; they must hang together by edges
      std::map<Edge, std::vector<Index>> joints;
      for (Index i = 0; i < static_cast<Index>(around[v].size()); ++i) {
        for (const auto& [j, k] : kTetEdges) {
          const Tet& tet = live[around[v][i]];
          if (tet[j] != v && tet[k] != v) {
            joints[{std::min(tet[j], tet[k]), std::max(tet[j], tet[k])}].push_back(i);
          }
        }
      }
      std::vector<std::array<Index, 2>> pairs;
      for (const auto& [edge, triangles] : joints) {
        for (const Index triangle : triangles) {
          pairs.push_back({triangles[0], triangle});
        }
      }
      std::vector<Index> root(around[v].size());
      for (Index i = 0; i < static_cast<Index>(root.size()); ++i) {
        root[i] = i;
      }
      for (std::size_t round = 0; round < root.size(); ++round) {
        for (const auto& [a, b] : pairs) {
          root[a] = root[b] = std::min(root[a], root[b]);
        }
      }
      if (std::any_of(root.begin(), root.end(), [](Index r) { return r != 0; })) {
        return true;
      }
    }
    return false;
  }

 private:
  [[nodiscard]] double area_of(const std::vector<BoundaryTriangle>& triangles) const {
    double sum = 0;
    for (const BoundaryTriangle& triangle : triangles) {
      const auto& [a, b, c] = triangle.vertices;
      sum += 0.5 * (positions[b] - positions[a]).cross(positions[c] - positions[a]).norm();
    }
    return sum;
  }
};

}  // namespace pbdsurg::testing
