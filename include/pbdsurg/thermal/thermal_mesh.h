// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The living tissue that conducts heat and current, kept up to date through edits.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/core/error.h"
#include "pbdsurg/core/export.h"
#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/followed_version.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/thermal_properties.h"

namespace pbdsurg {

struct Renumbering;

/// A body of a solver that conducts.
struct ThermalBody {
  Index body;           ///< of the solver
  const TetMesh* mesh;  ///< its rest mesh; used during construction only
  ThermalProperties tissue;
};

/// The rest tetrahedra of all conducting bodies of a scene: which are alive, what linear finite
/// elements need of each, and which of them meet at a vertex. In the scene's numbering, that of
/// the solver; vertices and tetrahedra of other bodies are there, too, without tissue.
///
/// Follows edits as a participant. An edit and its undo cost O(changed) and write flags and short
/// lists alone: sums over the tetrahedra at a vertex are taken when they are asked for. What
/// is asked of one vertex or tetrahedron serves inner loops, where ids are not checked.
class PBDSURG_API ThermalMesh final : public EditParticipant {
 public:
  /// One body by itself, with the ids of its mesh.
  /// @throws InvalidArgument  naming the property of the tissue that is out of range
  ThermalMesh(const TetMesh& mesh, const ThermalProperties& tissue);

  /// The same in layers. Tissue between layers has the water and the laws of state of the
  /// tetrahedron with the smallest id; mass and conductivity are those of each tetrahedron.
  /// @param tet_tissues  [tet_count] which of the tissues each tetrahedron is of
  /// @throws InvalidArgument  naming the tetrahedron whose tissue is out of range, or as above
  ThermalMesh(const TetMesh& mesh, std::span<const ThermalProperties> tissues,
              std::span<const Index> tet_tissues);

  /// Bodies of a scene. Tetrahedra that are gone already are left out. Cost: O(V + T).
  /// @throws InvalidArgument  naming the body that is not there or is given twice, whose mesh is
  ///                          missing or not of its size, or whose tissue is out of range, or if
  ///                          edits brought new vertices or tetrahedra already
  ThermalMesh(const Solver& solver, std::span<const ThermalBody> bodies);

  [[nodiscard]] Index vertex_count() const noexcept { return static_cast<Index>(points_.size()); }
  [[nodiscard]] Index tet_count() const noexcept { return static_cast<Index>(tets_.size()); }

  /// [vertex_count] m, of the rest meshes, and where new vertices would lie in them; zero for what
  /// is not of a conducting body
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions() const noexcept { return points_; }

  /// [tet_count] corners, those of removed tetrahedra included
  [[nodiscard]] std::span<const Tet> tets() const noexcept { return tets_; }

  /// Makes all of it of one tissue.
  /// @throws InvalidArgument  naming the property that is out of range
  void set_tissue(const ThermalProperties& tissue);

  /// Whether a tetrahedron is of a conducting body and lives.
  [[nodiscard]] bool is_alive(Index tet) const {
    return alive_[static_cast<std::size_t>(tet)] != 0;
  }

  /// [tissue_count] in the order in which bodies or layers were given
  [[nodiscard]] std::span<const ThermalProperties> tissues() const noexcept { return tissues_; }

  /// Which of tissues() a vertex or a tetrahedron is of, removed ones included; kInvalidIndex for
  /// those of other bodies.
  [[nodiscard]] Index tissue_of_vertex(Index vertex) const {
    return vertex_tissues_[static_cast<std::size_t>(vertex)];
  }
  [[nodiscard]] Index tissue_of_tet(Index tet) const {
    return tet_tissues_[static_cast<std::size_t>(tet)];
  }

  /// m^3, of the rest shape
  [[nodiscard]] double volume(Index tet) const { return volumes_[static_cast<std::size_t>(tet)]; }

  /// -V grad N_i . grad N_j of the edges in the order of kTetEdges, m: times a conductivity, the
  /// conductance of each edge, which may be negative at obtuse angles. Those of a sliver, whose
  /// volume is less than kLeastVolume times its longest edge cubed, are of one with that volume.
  [[nodiscard]] const std::array<double, 6>& edge_coefficients(Index tet) const {
    return coefficients_[static_cast<std::size_t>(tet)];
  }
  static constexpr double kLeastVolume = 1e-6;

  /// How many tetrahedra conduct less than they would for being slivers; removed ones count, until
  /// a compaction.
  [[nodiscard]] Index sliver_count() const noexcept { return sliver_count_; }

  /// Calls visit(tet) for each live tetrahedron at a vertex, ascending: sums in this order depend
  /// on what lives alone, and not on how it came to be.
  template <class Visit>
  void for_each_tet(Index vertex, Visit visit) const {
    for_each_corner(vertex, [&](Index tet, int) { visit(tet); });
  }

  /// The same with visit(tet, k) where the vertex is corner k.
  template <class Visit>
  void for_each_corner(Index vertex, Visit visit) const {
    for (Index corner = first_corners_[static_cast<std::size_t>(vertex)];
         corner != kInvalidIndex;) {
      const Index tet = corner / 4;
      const int k = corner % 4;
      if (is_alive(tet)) {
        visit(tet, k);
      }
      corner = next_corners_[static_cast<std::size_t>(tet)][static_cast<std::size_t>(k)];
    }
  }

  /// A vertex's share of the live tetrahedra around it, a quarter of each, m^3; zero without
  /// tissue. Cost: O(tetrahedra at the vertex), n below.
  [[nodiscard]] double volume_share(Index vertex) const noexcept;

  /// The same as mass, kg.
  [[nodiscard]] double mass(Index vertex) const noexcept;

  /// Whether any live tetrahedron is at a vertex. Cost: O(n), O(1) where none has gone.
  [[nodiscard]] bool has_tissue(Index vertex) const noexcept;

  /// A third of the area of each triangle of the live surface at a vertex, m^2. Cost: O(n^2).
  [[nodiscard]] double surface_share(Index vertex) const noexcept;

  /// Names the topology of live tissue: each edit that touches some gives it a number that it never
  /// had, others leave it, and an undo goes back to the one before.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_; }

  /// Counts compactions, and edits and undos that brought or joined living tissue: between two
  /// calls that give the same number, tetrahedra have gone and nothing else has changed.
  [[nodiscard]] std::uint64_t growth() const noexcept { return growth_; }

  /// Vertices at which the last edit or undo changed tetrahedra, each once; those that an undo did
  /// away with are left out. Valid until the next.
  [[nodiscard]] std::span<const Index> touched() const noexcept { return touched_; }

  /// Goes along with a compaction of the solver: what lives has new ids, and keeps all that it has,
  /// bit for bit. Counts as a change of topology. Cost: O(V + T).
  /// @throws InvalidArgument  if this had missed an edit before, or the solver is not what the
  ///                          compaction made of the one that this followed, or has tetrahedra with
  ///                          other corners than the mesh that was given; then nothing changes
  void renumber(const Solver& solver, const Renumbering& ids);

  /// How many compactions this has gone along with: who keeps ids of it sees that they are old.
  [[nodiscard]] int renumberings() const noexcept { return renumberings_; }

  void validate(const Solver& solver, const TopologyEdit& edit) const override;
  void apply(const Solver& solver, const TopologyEdit& edit,
             const EditResult& result) noexcept override;
  void undo(const Solver& solver, const TopologyEdit& edit,
            const EditResult& result) noexcept override;

 private:
  void add_body(const TetMesh& mesh, Index first_vertex, Index first_tet, Index tissue);
  void link_all();
  void check_corners(const Solver& solver, const Renumbering& ids) const;
  void resize(std::size_t vertex_count, std::size_t tet_count);
  [[nodiscard]] double longest_edge(Index tet) const noexcept;
  [[nodiscard]] bool is_sliver(Index tet) const noexcept;
  void measure(Index tet) noexcept;
  void link(Index corner) noexcept;
  void unlink(Index corner) noexcept;
  void move_corner(Index tet, Index from, Index to) noexcept;
  void touch(Index tet);

  FollowedVersion followed_;
  std::vector<ThermalProperties> tissues_;           // [tissue_count]
  std::vector<Eigen::Vector3d> points_;              // [vertex_count] m
  std::vector<Index> vertex_tissues_;                // [vertex_count]
  std::vector<Tet> tets_;                            // [tet_count]
  std::vector<std::uint8_t> alive_;                  // [tet_count]
  std::vector<Index> tet_tissues_;                   // [tet_count]
  std::vector<double> volumes_;                      // [tet_count] m^3
  std::vector<std::array<double, 6>> coefficients_;  // [tet_count] m
  // Lists of the tetrahedra that have a vertex, dead ones included, ascending: corner 4 t + k is
  // followed by next_corners_[t][k].
  std::vector<Index> first_corners_;                // [vertex_count]
  std::vector<std::array<Index, 4>> next_corners_;  // [tet_count]
  Index sliver_count_ = 0;
  std::uint64_t version_ = 0, newest_version_ = 0, growth_ = 0;
  int renumberings_ = 0;

  std::vector<Index> touched_;
  std::uint64_t change_ = 0;               // counts edits and undos
  std::vector<std::uint64_t> touched_at_;  // [vertex_count] the change that touched it last

  // for the undo of the last edit
  std::size_t vertices_before_ = 0, tets_before_ = 0;
  Index slivers_before_ = 0;
  std::uint64_t version_before_ = 0;
};

}  // namespace pbdsurg
