// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random edits that part and split tissue, and solvers of their results built from scratch.

#include <Eigen/Core>
#include <algorithm>
#include <cstdint>
#include <utility>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/mesh/topology.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg::testing {

/// A scene of one body after edits, as its mesh says: what was removed stays in it until a solver
/// is made.
class EditedBody {
 public:
  explicit EditedBody(const TetMesh& mesh, std::vector<bool> fixed)
      : points_(mesh.positions().begin(), mesh.positions().end()),
        tets_(mesh.tets().begin(), mesh.tets().end()),
        alive_(tets_.size(), true),
        fixed_(std::move(fixed)) {}

  [[nodiscard]] Solver make_solver() const {
    Scene scene = make_scene();
    Solver solver(scene, {.executor = executor::serial()});
    TopologyEdit gone;
    for (std::size_t t = 0; t < tets_.size(); ++t) {
      if (!alive_[t]) {
        gone.remove_tets.push_back(static_cast<Index>(t));
      }
    }
    solver.tissue().apply(gone);
    return solver;
  }

  [[nodiscard]] Scene make_scene() const {
    Scene scene;
    scene.add_body("body", TetMesh(points_, tets_));
    for (std::size_t v = 0; v < fixed_.size(); ++v) {
      if (fixed_[v]) {
        scene.fix_vertices(0, std::vector<Index>{static_cast<Index>(v)});
      }
    }
    return scene;
  }

  /// Removes some tetrahedra, parts others at a few vertices or cuts out a ball of them, and splits
  /// all around a few edges.
  [[nodiscard]] TopologyEdit random_edit(std::uint64_t seed) const {
    TopologyEdit edit;
    std::vector<bool> taken(tets_.size());
    for (std::size_t t = 0; t < tets_.size(); ++t) {
      taken[t] = !alive_[t];
      if (alive_[t] && random_bits(seed, 1, t) % 50 == 0) {
        edit.remove_tets.push_back(static_cast<Index>(t));
        taken[t] = true;
      }
    }
    const IndexLists at = find_vertex_tets(static_cast<Index>(points_.size()), tets_);
    const auto pick_vertex = [&](std::uint64_t i) {
      return static_cast<Index>(random_bits(seed, 2, i) % points_.size());
    };
    const auto add_vertex = [&](Index first, Index second) {
      edit.new_vertices.push_back({first, second, first == second ? 0.0F : 0.5F});
      return static_cast<Index>(points_.size() + edit.new_vertices.size() - 1);
    };
    const auto part = [&](Index from, auto&& moves) {
      Index to = kInvalidIndex;
      for (const Index t : at[from]) {
        if (!taken[t] && moves(t)) {
          to = to == kInvalidIndex ? add_vertex(from, from) : to;
          edit.corner_moves.push_back({t, from, to});
        }
      }
    };
    const Eigen::Vector3d& center = points_[pick_vertex(9)];
    const double radius = 1.2 * (points_[tets_[0][1]] - points_[tets_[0][0]]).norm();
    for (Index v = 0; v < static_cast<Index>(points_.size()); ++v) {
      if (seed % 2 == 0) {
        part(v, [&](Index t) { return (points_[tets_[t][0]] - center).norm() < radius; });
      } else if (random_bits(seed, 3, static_cast<std::uint64_t>(v)) % 8 == 0) {
        part(v,
             [&](Index t) { return random_bits(seed, 4, static_cast<std::uint64_t>(t)) % 2 == 0; });
      }
    }
    for (const CornerMove& move : edit.corner_moves) {
      taken[move.tet] = true;
    }
    for (std::uint64_t i = 0; i < 3; ++i) {
      const Index a = pick_vertex(i);
      Index b = kInvalidIndex;
      std::vector<Index> parents;
      for (const Index t : at[a]) {
        const Tet& tet = tets_[t];
        if (!taken[t] && b == kInvalidIndex) {
          b = tet[0] == a ? tet[1] : tet[0];
        }
        if (!taken[t] && std::find(tet.begin(), tet.end(), b) != tet.end()) {
          parents.push_back(t);
        }
      }
      if (parents.empty()) {
        continue;
      }
      const Index middle = add_vertex(a, b);
      for (const Index t : parents) {
        taken[t] = true;
        for (const Index replaced : {a, b}) {
          Tet child = tets_[t];
          std::replace(child.begin(), child.end(), replaced, middle);
          edit.new_tets.push_back({t, child});
        }
      }
    }
    return edit;
  }

  /// Follows an edit.
  void apply(const TopologyEdit& edit) {
    for (const NewVertex& vertex : edit.new_vertices) {
      const Eigen::Vector3d along = points_[vertex.second] - points_[vertex.first];
      points_.push_back(points_[vertex.first] + static_cast<double>(vertex.share) * along);
      fixed_.push_back(fixed_[vertex.first] && fixed_[vertex.second]);
    }
    for (const CornerMove& move : edit.corner_moves) {
      Tet& tet = tets_[move.tet];
      std::replace(tet.begin(), tet.end(), move.from, move.to);
    }
    for (const Index t : edit.remove_tets) {
      alive_[t] = false;
    }
    for (const NewTet& tet : edit.new_tets) {
      alive_[tet.parent] = false;
      tets_.push_back(tet.vertices);
      alive_.push_back(true);
    }
  }

 private:
  std::vector<Eigen::Vector3d> points_;
  std::vector<Tet> tets_;
  std::vector<bool> alive_;
  std::vector<bool> fixed_;
};

}  // namespace pbdsurg::testing
