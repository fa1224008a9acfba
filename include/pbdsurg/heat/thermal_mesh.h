// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The living tissue that conducts heat and current, kept up to date through edits.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/base/undo_array.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/thermal_properties.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// A body of living tissue that conducts.
struct ThermalBody {
  Index body;                    ///< of the tissue
  ThermalProperties properties;  ///< of all its tetrahedra
};

/// What linear finite elements need of each tetrahedron of conducting bodies, at rest; which live,
/// and which meet at a vertex, the tissue says. Ids are the tissue's; vertices and tetrahedra of
/// other bodies are there, too, and do not conduct.
///
/// An edit and its undo cost O(changed): sums over the tetrahedra at a vertex are taken when they
/// are asked for. What is asked of one vertex or tetrahedron serves inner loops, where ids are not
/// checked. A copy does not follow edits: it is of use until the next.
class PBDSURG_API ThermalMesh final : public Follower {
 public:
  /// One body by itself, with the ids of its mesh, in tissue of its own that nothing edits.
  /// @throws InvalidArgument  naming the property of the tissue that is out of range
  ThermalMesh(const TetMesh& mesh, const ThermalProperties& properties);

  /// The same in layers. Tissue between layers has the water and the laws of state of the
  /// tetrahedron with the smallest id; mass and conductivity are those of each tetrahedron.
  /// @param tet_layers  [tet_count] which of the layers each tetrahedron is of
  /// @throws InvalidArgument  naming the tetrahedron whose layer is out of range, or as above
  ThermalMesh(const TetMesh& mesh, std::span<const ThermalProperties> layers,
              std::span<const Index> tet_layers);

  /// Bodies of living tissue, at any time. Follows its edits. Cost: O(V + T).
  /// @param tissue  must outlive this
  /// @throws InvalidArgument  naming the body that is not there or is given twice, or whose
  ///                          properties are out of range
  ThermalMesh(const Tissue& tissue, std::span<const ThermalBody> bodies);

  /// Of the tissue, vertices of other bodies included.
  [[nodiscard]] Index vertex_count() const noexcept {
    return tissue_ == nullptr ? 0 : tissue_->vertex_count();
  }
  /// Of the tissue, removed ones and those of other bodies included.
  [[nodiscard]] Index tet_count() const noexcept { return tet_tissues_.size(); }

  /// [vertex_count] m
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions() const noexcept {
    return tissue_ == nullptr ? std::span<const Eigen::Vector3d>() : tissue_->rest_positions();
  }

  /// [tet_count] corners, those of removed tetrahedra included, as the tissue has them.
  [[nodiscard]] std::span<const Tet> tets() const noexcept {
    return tissue_ == nullptr ? std::span<const Tet>() : tissue_->tets();
  }

  /// Makes all of it of one tissue.
  /// @throws InvalidArgument  naming the property that is out of range
  void set_tissue(const ThermalProperties& tissue);

  /// Whether a tetrahedron is of a conducting body and lives.
  [[nodiscard]] bool is_alive(Index tet) const {
    return tet_tissues_[tet] != kInvalidIndex && tissue_->is_tet_alive(tet);
  }

  /// [tissue_count] in the order in which bodies or layers were given
  [[nodiscard]] std::span<const ThermalProperties> tissues() const noexcept { return tissues_; }

  /// Which of tissues() a vertex is of, removed ones included; kInvalidIndex for those of other
  /// bodies.
  [[nodiscard]] Index tissue_of_vertex(Index vertex) const { return vertex_tissues_[vertex]; }
  /// The same of a tetrahedron.
  [[nodiscard]] Index tissue_of_tet(Index tet) const { return tet_tissues_[tet]; }

  /// m^3, of the rest shape
  [[nodiscard]] double volume(Index tet) const { return volumes_[tet]; }

  /// -V grad N_i . grad N_j of the edges in the order of kTetEdges, m: times a conductivity, the
  /// conductance of each edge, which may be negative at obtuse angles. Those of a sliver, whose
  /// volume is less than kLeastVolume times its longest edge cubed, are of one with that volume.
  [[nodiscard]] const std::array<double, 6>& edge_coefficients(Index tet) const {
    return coefficients_[tet];
  }
  /// Of a tetrahedron that is no sliver, over the cube of its longest edge.
  static constexpr double kLeastVolume = 1e-6;

  /// How many tetrahedra conduct less than they would for being slivers; removed ones count, until
  /// a compaction.
  [[nodiscard]] Index sliver_count() const noexcept { return sliver_count_; }

  /// Calls visit(tet) for each live tetrahedron at a vertex, ascending: sums in this order depend
  /// on what lives alone, and not on how it came to be.
  template <class Visit>
  void for_each_tet(Index vertex, Visit visit) const {
    if (vertex_tissues_[vertex] != kInvalidIndex) {
      for (const Index tet : tissue_->tets_at(vertex)) {
        visit(tet);
      }
    }
  }

  /// The same with visit(tet, k) where the vertex is corner k.
  template <class Visit>
  void for_each_corner(Index vertex, Visit visit) const {
    const std::span<const Tet> all = tissue_->tets();
    for_each_tet(vertex, [&](Index tet) {
      const Tet& corners = all[static_cast<std::size_t>(tet)];
      const auto corner = std::find(corners.begin(), corners.end(), vertex) - corners.begin();
      visit(tet, static_cast<int>(corner));
    });
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

  /// Refuses to go on where the tissue is no longer what this is of.
  /// @param who  "a heat field"
  /// @throws InvalidArgument  if this was moved from, or is a copy and an edit or a compaction came
  ///                          since
  void check_current(const char* who) const;

  /// Whether it is of a mesh by itself, which nothing edits.
  [[nodiscard]] bool is_by_itself() const noexcept { return tissue_.use_count() > 0; }

  /// @throws InvalidArgument  if this was moved from
  [[nodiscard]] const Tissue& tissue() const;

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  void set_up(std::span<const ThermalBody> bodies);
  void resize();
  [[nodiscard]] double longest_edge(Index tet) const noexcept;
  [[nodiscard]] bool is_sliver(Index tet) const noexcept;
  void measure(Index tet) noexcept;
  void begin_change();
  void touch(const Tet& vertices);

  std::shared_ptr<const Tissue> tissue_;    // owned where nothing edits it; null once moved from
  std::uint64_t seen_version_ = 0;          // of the tissue
  std::vector<ThermalProperties> tissues_;  // [tissue_count]
  UndoArray<Index> vertex_tissues_;         // [vertex_count]
  UndoArray<Index> tet_tissues_;            // [tet_count]
  UndoArray<double> volumes_;               // [tet_count] m^3
  UndoArray<std::array<double, 6>> coefficients_;  // [tet_count] m
  Index sliver_count_ = 0;
  std::uint64_t version_ = 0, newest_version_ = 0, growth_ = 0;

  std::vector<Index> touched_;
  std::uint64_t change_ = 0;               // counts edits and undos
  std::vector<std::uint64_t> touched_at_;  // [vertex_count] the change that touched it last

  // for the undo of the last edit
  Index slivers_before_ = 0;
  std::uint64_t version_before_ = 0;
};

}  // namespace pbdsurg
