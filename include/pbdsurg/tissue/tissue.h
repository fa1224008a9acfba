// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Living tissue: bodies, tetrahedra, triangles, edges, links and hinges, and the edits that change
/// them.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/follower.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue_change.h"
#include "pbdsurg/tissue/topology_edit.h"

namespace pbdsurg {

struct TissueData;

/// Tissue::version() with the tissue that it is of.
struct TissueVersion {
  std::uint64_t tissue = 0;  ///< differs between all tissues of a process; zero: none
  std::uint64_t number = 0;  ///< Tissue::version()

  /// Whether both are of one topology of one tissue.
  friend bool operator==(const TissueVersion&, const TissueVersion&) = default;
};

/// What there is of a scene, the only owner of its topology. It knows neither motion nor forces: a
/// Solver, a HeatField and views follow it. Ids are stable: what is removed keeps its id.
///
/// An edit changes the tissue first and each follower once afterwards, or nothing at all. One edit
/// can be undone, the last.
///
/// A removed tetrahedron takes with it its share of mass, the edges that it was the last to use,
/// links to a vertex that it was the last to use, and hinges of its triangles; so does a removed
/// triangle of a sheet, which has no edges of its own. Where tetrahedra give way to others, mass
/// and rest volume stay. A hinge follows its two triangles, through parting and splitting, for as
/// long as they are there and share its edge. A body that goes keeps its number and its name.
///
/// Not thread-safe; a Solver on a device may step meanwhile, see Solver::start_step(). It must
/// outlive its followers, and stays where it is in memory.
class PBDSURG_API Tissue {
 public:
  /// All of a scene, alive and at rest.
  explicit Tissue(const Scene& scene);
  ~Tissue();
  Tissue(const Tissue&) = delete;
  Tissue& operator=(const Tissue&) = delete;

  /// @name Edits
  /// @{

  /// Changes the topology.
  ///
  /// Cost: proportional to the change; for bodies that come, to their size and the number of
  /// bodies; for one that goes, to its size and all that edits brought so far. Followers add
  /// theirs. An edit that changes no more than one before it allocates nothing, but for what it
  /// adds.
  /// @return  what it did, consequences included; valid until the next edit
  /// @throws InvalidArgument  naming the first id that is out of range, dead or listed twice, or
  /// the
  ///                          value out of range, and whatever a follower throws to refuse it; then
  ///                          nothing has changed
  const TissueChange& apply(const TopologyEdit& edit);

  /// Takes back the last edit: topology, masses, and all that followers hold. Cost: that of the
  /// edit.
  /// @throws InvalidArgument  if there was none since the last undo or compaction, or a follower
  ///                          came since, and whatever a follower throws to refuse it; then nothing
  ///                          has changed
  void undo();

  /// The last edit, also once it was undone.
  [[nodiscard]] const TissueChange& last_change() const noexcept;

  /// Registers a follower of all later edits. It may come at any time, but within an edit. What
  /// followed another tissue leaves that.
  void add_follower(Follower& follower, FollowerRank rank = FollowerRank::user) const;

  /// Refuses what reads the tissue by ids that may be old.
  /// @param who  "a live surface"
  /// @throws InvalidArgument  if it does not follow the tissue: it is a copy, or was moved from
  void check_follower(const Follower& follower, const char* who) const;

  /// Counts edits: each gives a number that there never was. undo() goes back to the one before.
  [[nodiscard]] std::uint64_t version() const noexcept;
  /// version(), and of which tissue.
  [[nodiscard]] TissueVersion identified_version() const noexcept;

  /// @}

  /// @name Bodies
  /// Functions that take an id throw InvalidArgument, naming the one out of range; so do those
  /// below.
  /// @{

  /// [body_count] all that there ever were: the scene's, then those that edits brought.
  [[nodiscard]] std::span<const Body> bodies() const noexcept;

  /// @throws InvalidArgument  naming the index and how many bodies there are
  [[nodiscard]] const Body& body(Index index) const;

  /// Whether any of its vertices has tissue: not of one that was removed, or has gone bit by bit.
  /// @throws InvalidArgument  as body()
  [[nodiscard]] bool is_body_alive(Index body) const;

  /// The body of a vertex. What a body came with has the ids that bodies() says; what edits split
  /// off it has ids behind, among those of others.
  [[nodiscard]] Index body_of_vertex(Index vertex) const;
  /// The body of a tetrahedron, likewise.
  [[nodiscard]] Index body_of_tet(Index tet) const;

  /// The sheet of a triangle. Edits bring triangles with new bodies alone, so those of a body are
  /// the ones that bodies() says.
  [[nodiscard]] Index body_of_triangle(Index triangle) const;

  /// The id from which on vertices may be a body's that it did not come with.
  [[nodiscard]] Index first_later_vertex(Index body) const;
  /// The same of tetrahedra.
  [[nodiscard]] Index first_later_tet(Index body) const;

  /// Vertices of a body, those without tissue included, ascending. Cost: O(those that it came with,
  /// and all that edits brought).
  [[nodiscard]] std::vector<Index> vertices_of(Index body) const;
  /// Tetrahedra of a body, removed ones included, likewise.
  [[nodiscard]] std::vector<Index> tets_of(Index body) const;

  /// @}

  /// @name Vertices
  /// @{

  /// All that there ever were.
  [[nodiscard]] Index vertex_count() const noexcept;

  /// [vertex_count] m, of the scene; new vertices lie between where these do.
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions() const noexcept;

  /// [vertex_count] kg: a quarter of each live tetrahedron at a vertex, a third of each triangle,
  /// or a particle's own.
  [[nodiscard]] std::span<const double> masses() const noexcept;

  /// Whether a vertex has mass: a particle, or a corner of a live tetrahedron or triangle.
  [[nodiscard]] bool has_tissue(Index vertex) const;

  /// Whether it cannot move: the scene or an edit fixed it, or it came between two that were fixed.
  [[nodiscard]] bool is_fixed(Index vertex) const;

  /// Live tetrahedra at a vertex, ascending. Valid until the next edit.
  [[nodiscard]] std::span<const Index> tets_at(Index vertex) const;
  /// Live triangles of sheets, likewise.
  [[nodiscard]] std::span<const Index> triangles_at(Index vertex) const;
  /// Live links, likewise.
  [[nodiscard]] std::span<const Index> links_at(Index vertex) const;
  /// Live hinges, likewise.
  [[nodiscard]] std::span<const Index> hinges_at(Index vertex) const;

  /// @}

  /// @name Tetrahedra, triangles, edges, links, hinges
  /// @{

  /// [tet_count] corners of every tetrahedron there ever was.
  [[nodiscard]] std::span<const Tet> tets() const noexcept;

  /// [tet_count] edges of each, in the order of kTetEdges.
  [[nodiscard]] std::span<const std::array<Index, 6>> tet_edges() const noexcept;
  /// Those of one.
  [[nodiscard]] std::span<const Index, 6> tet_edges(Index tet) const;

  /// kg
  [[nodiscard]] double tet_mass(Index tet) const;

  /// How many times as stiff as the material of its body a tetrahedron is.
  [[nodiscard]] float stiffness(Index tet) const;

  /// The fibres of a tetrahedron; of no stiffness where it has none.
  [[nodiscard]] const Fibre& fibre(Index tet) const;

  /// [triangle_count] corners of every triangle of a sheet there ever was.
  [[nodiscard]] std::span<const Triangle> triangles() const noexcept;

  /// kg
  [[nodiscard]] double triangle_mass(Index triangle) const;

  /// How many times as stiff as the material of its sheet a triangle is.
  [[nodiscard]] float triangle_stiffness(Index triangle) const;

  /// [edge_count] of tetrahedra: vertices of every edge there ever was, smaller first. Sorted until
  /// an edit adds vertices.
  [[nodiscard]] std::span<const Edge> edges() const noexcept;

  /// [edge_count] how many live tetrahedra are around each.
  [[nodiscard]] std::span<const Index> edge_tets() const noexcept;

  /// [link_count] as given to the scene and to edits, with ends and rest lengths as they are now.
  [[nodiscard]] std::span<const Link> links() const noexcept;

  /// [hinge_count] as they are now, or were last: parting gives them copies of vertices.
  [[nodiscard]] std::span<const Hinge> hinges() const noexcept;

  /// Whether a tetrahedron has not been removed.
  [[nodiscard]] bool is_tet_alive(Index tet) const;
  /// Whether a triangle of a sheet has not been removed.
  [[nodiscard]] bool is_triangle_alive(Index triangle) const;
  /// Whether a live tetrahedron is around an edge.
  [[nodiscard]] bool is_edge_alive(Index edge) const;
  /// Whether a link has neither been removed nor lost an end.
  [[nodiscard]] bool is_link_alive(Index link) const;
  /// Whether a hinge has both its triangles and their common edge.
  [[nodiscard]] bool is_hinge_alive(Index hinge) const;

  /// m/s^2, of the scene; a solver may have another by now
  [[nodiscard]] const Eigen::Vector3f& gravity() const noexcept;

  /// @}

  /// @name Memory
  /// @{

  /// Makes room for so many more of each, so that edits that bring them allocate nothing.
  void reserve(std::size_t vertices, std::size_t tets, std::size_t edges, std::size_t links);

  /// Bytes in use, without followers and without what allocators add.
  [[nodiscard]] std::size_t memory_bytes() const noexcept;

  /// @}

 private:
  friend TissueData& tissue_data(Tissue& tissue) noexcept;
  friend const TissueData& tissue_data(const Tissue& tissue) noexcept;

  explicit Tissue(std::unique_ptr<TissueData> data) noexcept;
  friend std::unique_ptr<Tissue> make_tissue(std::unique_ptr<TissueData> data);

  std::unique_ptr<TissueData> data_;
};

}  // namespace pbdsurg
