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
#include "pbdsurg/heat/elements.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/thermal_properties.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// A body of living tissue that conducts.
struct ThermalBody {
  Index body;                    ///< of the tissue
  ThermalProperties properties;  ///< of all its tetrahedra or triangles
};

/// What linear finite elements need of each element of conducting bodies, at rest; which live, and
/// which meet at a vertex, the tissue says. An element is a tetrahedron, or a triangle of a sheet
/// (heat/elements.h). Ids are the tissue's; vertices and elements of other bodies are there, too,
/// and do not conduct. A sheet conducts in its plane, as all of its thickness.
///
/// An edit and its undo cost O(changed): sums over the elements at a vertex are taken when they
/// are asked for. What is asked of one vertex or element serves inner loops, where ids are not
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
  [[nodiscard]] Index tet_count() const noexcept { return tets_.tissues.size(); }
  /// Of sheets of the tissue, likewise.
  [[nodiscard]] Index triangle_count() const noexcept { return triangles_.tissues.size(); }

  /// [vertex_count] m
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions() const noexcept {
    return tissue_ == nullptr ? std::span<const Eigen::Vector3d>() : tissue_->rest_positions();
  }

  /// [tet_count] corners, those of removed tetrahedra included, as the tissue has them.
  [[nodiscard]] std::span<const Tet> tets() const noexcept {
    return tissue_ == nullptr ? std::span<const Tet>() : tissue_->tets();
  }

  /// Vertices of an element, valid until the next edit.
  [[nodiscard]] std::span<const Index> corners(Index element) const {
    return is_triangle(element) ? std::span<const Index>(tissue_->triangles()[place(element)])
                                : std::span<const Index>(tissue_->tets()[place(element)]);
  }

  /// Makes all of it of one tissue.
  /// @throws InvalidArgument  naming the property that is out of range
  void set_tissue(const ThermalProperties& tissue);

  /// Whether an element is of a conducting body and lives.
  [[nodiscard]] bool is_alive(Index element) const {
    return tissue_of_element(element) != kInvalidIndex &&
           (is_triangle(element) ? tissue_->is_triangle_alive(triangle_of_element(element))
                                 : tissue_->is_tet_alive(element));
  }

  /// [tissue_count] in the order in which bodies or layers were given
  [[nodiscard]] std::span<const ThermalProperties> tissues() const noexcept { return tissues_; }

  /// Which of tissues() a vertex is of, removed ones included; kInvalidIndex for those of other
  /// bodies.
  [[nodiscard]] Index tissue_of_vertex(Index vertex) const { return vertex_tissues_[vertex]; }
  /// The same of an element.
  [[nodiscard]] Index tissue_of_element(Index element) const {
    return of(element).tissues[local(element)];
  }

  /// m^3, of the rest shape; of a triangle with its sheet's thickness
  [[nodiscard]] double volume(Index element) const { return of(element).volumes[local(element)]; }

  /// -V grad N_i . grad N_j of the edges in the order of kTetEdges, m: times a conductivity, the
  /// conductance of each edge, which may be negative at obtuse angles. Those of a sliver, whose
  /// volume is less than kLeastVolume times its longest edge cubed, are of one with that volume. Of
  /// a triangle, whose area and the square count likewise, edges to a fourth corner have none.
  [[nodiscard]] const std::array<double, 6>& edge_coefficients(Index element) const {
    return of(element).coefficients[local(element)];
  }
  /// Of a tetrahedron that is no sliver, over the cube of its longest edge.
  static constexpr double kLeastVolume = 1e-6;

  /// How many elements conduct less than they would for being slivers; removed ones count, until
  /// a compaction.
  [[nodiscard]] Index sliver_count() const noexcept { return sliver_count_; }

  /// Calls visit(element) for each live element at a vertex, in the order of the tissue's ids: sums
  /// in this order depend on what lives alone, and not on how it came to be.
  template <class Visit>
  void for_each_element(Index vertex, Visit visit) const {
    if (vertex_tissues_[vertex] != kInvalidIndex) {
      for (const Index tet : tissue_->tets_at(vertex)) {
        visit(tet);
      }
      for (const Index triangle : tissue_->triangles_at(vertex)) {
        visit(element_of_triangle(triangle));
      }
    }
  }

  /// The same with visit(element, k) where the vertex is corner k.
  template <class Visit>
  void for_each_corner(Index vertex, Visit visit) const {
    for_each_element(vertex, [&](Index element) {
      const std::span<const Index> all = corners(element);
      visit(element, static_cast<int>(std::find(all.begin(), all.end(), vertex) - all.begin()));
    });
  }

  /// A vertex's share of the live elements around it, a quarter of each tetrahedron or a third of
  /// each triangle, m^3; zero without tissue. Cost: O(elements at the vertex), n below.
  [[nodiscard]] double volume_share(Index vertex) const noexcept;

  /// The same as mass, kg.
  [[nodiscard]] double mass(Index vertex) const noexcept;

  /// Whether any live element is at a vertex. Cost: O(1).
  [[nodiscard]] bool has_tissue(Index vertex) const noexcept;

  /// A third of the area of each triangle of the live surface at a vertex, m^2; of a sheet both
  /// sides, and not its rim. Cost: O(n^2).
  [[nodiscard]] double surface_share(Index vertex) const noexcept;

  /// Names the topology of live tissue: each edit that touches some gives it a number that it never
  /// had, others leave it, and an undo goes back to the one before.
  [[nodiscard]] std::uint64_t version() const noexcept { return version_; }

  /// Counts compactions, and edits and undos that brought or joined living tissue: between two
  /// calls that give the same number, elements have gone and nothing else has changed.
  [[nodiscard]] std::uint64_t growth() const noexcept { return growth_; }

  /// Vertices at which the last edit or undo changed elements, each once; those that an undo did
  /// away with are left out. Valid until the next.
  [[nodiscard]] std::span<const Index> touched() const noexcept { return touched_; }

  /// Refuses to go on where the tissue is no longer what this is of.
  /// @param who  "a heat field"
  /// @throws InvalidArgument  if this was moved from, or is a copy and an edit or a compaction came
  ///                          since
  void check_current(const char* who) const;

  /// Whether any of the bodies is a sheet.
  [[nodiscard]] bool has_sheets() const noexcept { return has_sheets_; }

  /// Whether it is of a mesh by itself, which nothing edits.
  [[nodiscard]] bool is_by_itself() const noexcept { return tissue_.use_count() > 0; }

  /// @throws InvalidArgument  if this was moved from
  [[nodiscard]] const Tissue& tissue() const;

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  struct Elements {
    UndoArray<Index> tissues;                       // [count] kInvalidIndex: does not conduct
    UndoArray<double> volumes;                      // [count] m^3
    UndoArray<std::array<double, 6>> coefficients;  // [count] m

    void resize(std::size_t count);
    void begin_edit();
    void undo();
  };

  [[nodiscard]] static Index local(Index element) noexcept {
    return is_triangle(element) ? triangle_of_element(element) : element;
  }
  [[nodiscard]] static std::size_t place(Index element) noexcept {
    return static_cast<std::size_t>(local(element));
  }
  [[nodiscard]] const Elements& of(Index element) const noexcept {
    return is_triangle(element) ? triangles_ : tets_;
  }
  [[nodiscard]] Elements& of(Index element) noexcept {
    return is_triangle(element) ? triangles_ : tets_;
  }
  void resize();
  void add_element(Index element, Index tissue) noexcept;
  [[nodiscard]] double longest_edge(Index element) const noexcept;
  [[nodiscard]] bool is_sliver(Index element) const noexcept;
  void measure_tet(Index tet, double longest) noexcept;
  void measure_triangle(Index triangle, double longest) noexcept;
  void begin_change();
  void touch(std::span<const Index> vertices);
  bool touch_changed(const TissueChange& change);

  std::shared_ptr<const Tissue> tissue_;    // owned where nothing edits it; null once moved from
  std::uint64_t seen_version_ = 0;          // of the tissue
  std::vector<ThermalProperties> tissues_;  // [tissue_count]
  UndoArray<Index> vertex_tissues_;         // [vertex_count]
  Elements tets_, triangles_;               // of the tissue
  bool has_sheets_ = false;
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
