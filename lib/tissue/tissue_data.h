// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a tissue holds, for the edits that change it.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <memory_resource>
#include <vector>

#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue_change.h"

#include "lib/tissue/follower_list.h"
#include "lib/tissue/vertex_lists.h"

namespace pbdsurg {

class Tissue;

using TetEdges = std::array<Index, 6>;

struct TissueData {
  Eigen::Vector3f gravity{0, 0, 0};
  UndoArray<Body> bodies;
  UndoArray<Index> tissue_counts;                          // [body] of its vertices with mass
  UndoArray<Index> later_vertex_bodies, later_tet_bodies;  // of what edits added, in its order

  UndoArray<Eigen::Vector3d> rest_positions;  // [vertex_count] m
  UndoArray<std::uint8_t> fixed;              // [vertex_count]
  UndoArray<double> masses;                   // [vertex_count] kg
  VertexLists vertex_tets, vertex_links;      // [vertex_count] of the living

  UndoArray<Tet> tets;                // [tet_count]
  UndoArray<TetEdges> tet_edges;      // [tet_count]
  UndoArray<std::uint8_t> tet_alive;  // [tet_count]
  UndoArray<double> tet_masses;       // [tet_count] kg
  UndoArray<float> stiffnesses;       // [tet_count] times that of the body's material
  UndoArray<Fibre> fibres;            // [tet_count]

  UndoArray<Triangle> triangles;           // [triangle_count] of sheets
  UndoArray<std::uint8_t> triangle_alive;  // [triangle_count]
  UndoArray<double> triangle_masses;       // [triangle_count] kg
  UndoArray<float> triangle_stiffnesses;   // [triangle_count] times that of the sheet's material
  VertexLists vertex_triangles;  // [vertex_count] of the living; empty where there are none

  UndoArray<Edge> edges;                // [edge_count]
  UndoArray<Index> edge_tets;           // [edge_count] live tetrahedra around each
  UndoArray<Link> links;                // [link_count]
  UndoArray<std::uint8_t> link_alive;   // [link_count]
  UndoArray<Hinge> hinges;              // [hinge_count]
  UndoArray<std::uint8_t> hinge_alive;  // [hinge_count]
  VertexLists vertex_hinges;            // [vertex_count] of the living; empty where there are none

  std::uint64_t identity = 0;
  std::uint64_t version = 0;
  std::uint64_t last_version = 0;  // ever given
  TissueChange change;             // the last
  bool can_undo = false;
  std::shared_ptr<FollowerList> followers = std::make_shared<FollowerList>();

  std::vector<Index> buffer;  // of what an edit needs for a while
  // for lists of the like: keeps what it has got, so that later edits ask for no memory
  std::unique_ptr<std::pmr::memory_resource> scratch =
      std::make_unique<std::pmr::unsynchronized_pool_resource>(
          std::pmr::pool_options{.largest_required_pool_block = std::size_t{1} << 20});

  [[nodiscard]] Index vertex_count() const noexcept { return rest_positions.size(); }

  /// Calls visit(array) for all that undo takes back.
  template <class Visit>
  void for_each_array(Visit visit) {
    visit(bodies), visit(tissue_counts), visit(later_vertex_bodies), visit(later_tet_bodies);
    visit(rest_positions), visit(fixed), visit(masses), visit(vertex_tets), visit(vertex_links);
    visit(tets), visit(tet_edges), visit(tet_alive), visit(tet_masses);
    visit(stiffnesses), visit(fibres);
    visit(triangles), visit(triangle_alive), visit(triangle_masses), visit(triangle_stiffnesses);
    visit(vertex_triangles);
    visit(edges), visit(edge_tets), visit(links), visit(link_alive);
    visit(hinges), visit(hinge_alive), visit(vertex_hinges);
  }

  [[nodiscard]] std::span<const Index> hinges_at(Index vertex) const noexcept {
    return hinges.size() == 0 ? std::span<const Index>() : vertex_hinges[vertex];
  }
  [[nodiscard]] std::span<const Index> triangles_at(Index vertex) const noexcept {
    return triangles.size() == 0 ? std::span<const Index>() : vertex_triangles[vertex];
  }
  /// Whether a live tetrahedron or triangle has a vertex: particles have mass alone.
  [[nodiscard]] bool is_corner(Index vertex) const noexcept {
    return !vertex_tets[vertex].empty() || !triangles_at(vertex).empty();
  }
  [[nodiscard]] Index body_of_vertex(Index vertex) const noexcept;
  [[nodiscard]] Index body_of_tet(Index tet) const noexcept;
  [[nodiscard]] Index body_of_triangle(Index triangle) const noexcept;
  [[nodiscard]] Index first_later_vertex(Index body) const noexcept;
  [[nodiscard]] Index first_later_tet(Index body) const noexcept;

  // What an edit does, step by step; consequences go to `change`.
  void set_mass(Index vertex, double mass);
  void set_tet(Index tet, const Tet& vertices, const TetEdges& edges_of_tet);
  void add_vertex(const NewVertex& vertex);
  Index add_edge(const Edge& ends);
  Index add_tet(const Tet& vertices, Index body, double mass, float stiffness, const Fibre& fibre);
  void add_triangle(const Triangle& vertices, double mass, float stiffness);
  void add_link(const Link& link);
  void add_hinge(const Hinge& hinge);
  void resize_vertex_lists();  // to the vertices that there are
};

/// Calls visit(vertex), visit(tet) for those of a body, dead ones, too; ids ascend. Cost: O(those
/// that it came with, and all that edits brought).
template <class Visit>
void for_each_vertex_of(const TissueData& data, Index body, Visit visit) {
  const Body& own = data.bodies[body];
  for (Index v = own.first_vertex; v < own.first_vertex + own.vertex_count; ++v) {
    visit(v);
  }
  for (Index v = data.first_later_vertex(body); v < data.vertex_count(); ++v) {
    if (data.body_of_vertex(v) == body) {
      visit(v);
    }
  }
}
template <class Visit>
void for_each_tet_of(const TissueData& data, Index body, Visit visit) {
  const Body& own = data.bodies[body];
  for (Index t = own.first_tet; t < own.first_tet + own.tet_count; ++t) {
    visit(t);
  }
  for (Index t = data.first_later_tet(body); t < data.tets.size(); ++t) {
    if (data.body_of_tet(t) == body) {
      visit(t);
    }
  }
}

/// Finds edges and adjacency of tetrahedra, triangles, links and hinges that live, all of them.
void connect(TissueData& data);

/// Another at each call.
[[nodiscard]] std::uint64_t next_tissue_identity() noexcept;

[[nodiscard]] TissueData& tissue_data(Tissue& tissue) noexcept;
[[nodiscard]] const TissueData& tissue_data(const Tissue& tissue) noexcept;
[[nodiscard]] std::unique_ptr<Tissue> make_tissue(std::unique_ptr<TissueData> data);

}  // namespace pbdsurg
