// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Temperature and water of a body, heated from outside.

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/followed_version.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/thermal/tissue.h"

namespace pbdsurg {

/// Heat delivered to one vertex.
struct HeatSource {
  Index vertex;  ///< of the body
  double power;  ///< W
};

/// Where the energy went since the start, J. What came in equals the sum of the other three, which
/// are counted separately.
struct HeatLedger {
  double in = 0;        ///< delivered by sources
  double sensible = 0;  ///< held as temperature above body temperature
  double latent = 0;    ///< held by living tissue as boiled-off water
  double removed = 0;   ///< taken away with removed tetrahedra
};

/// Heat conduction on the rest mesh with boiling, stepped explicitly.
///
/// Linear finite elements with lumped mass: dT_i/dt = sum_j k_ij (T_j - T_i) / M_i + q_i / M_i.
/// Edges whose assembled k_ij is negative, which obtuse tetrahedra cause, conduct nothing: less
/// accurate there, but no temperature leaves the range of those around it. A vertex at 100 degrees
/// stays there until its water has boiled away (excess-heat correction, exactly conservative);
/// perfusion and surface loss are neglected, which is justified for activations of seconds.
/// Explicit steps are subdivided for stability; where slivers would need more than kMostSubsteps,
/// conduction through their edges is limited instead: energy is still conserved, but heat spreads
/// more slowly there (limited_edge_count() says how many). Deterministic.
///
/// Follows edits of its body: pass it to apply_edit() as a participant. A new vertex starts with
/// the temperature, water and peak between those of the two that it lies between, by its share.
/// These are then what they were all along its edge, so tetrahedra that are divided hold as much
/// heat and steam as before (lumping is exact for what is linear within a tetrahedron), and no
/// temperature leaves the range of those around it. An undo gives removed tissue back as warm as
/// its vertices are then; what that brings in, if steps were taken since, is taken from
/// HeatLedger::removed.
///
/// Vertices and tetrahedra of the body have their own numbering here: those of the mesh, then new
/// ones as edits brought them. Cost of a step, and of the step after an edit once more: O(vertices
/// + edges) of the body; of an edit and its undo: O(changed).
class HeatField final : public EditParticipant {
 public:
  static constexpr int kMostSubsteps = 16;  ///< per call of step()

  /// @param mesh   the body's rest mesh, whole: a field made after an edit does not know of that
  /// @param place  the body's place in the scene's numbering, of which first_vertex and first_tet
  ///               are used
  /// @throws InvalidArgument  naming the property that is not positive, or the water fraction
  ///                          outside [0, 1]
  HeatField(const TetMesh& mesh, const TissueProperties& tissue, const Body& place = {});

  /// Of a body whose solver was edited, for example by the edit that brought the body.
  /// @param mesh  the body's rest mesh, of which nothing was changed
  /// @throws InvalidArgument  as above, or if there is no such body or it is not of this mesh
  HeatField(const TetMesh& mesh, const TissueProperties& tissue, const Solver& solver, Index body);

  /// Advances by dt with constant sources. Sources at vertices without tissue deliver nothing.
  /// @param dt  s, positive and finite
  /// @throws InvalidArgument  naming the source whose vertex is out of range or whose power is
  ///                          negative or not finite; then nothing has changed
  void step(double dt, std::span<const HeatSource> sources);

  /// [vertex_count] degrees Celsius
  [[nodiscard]] std::span<const double> temperatures() const noexcept { return temperatures_; }

  /// [vertex_count] degrees Celsius, the highest so far: unlike the temperature it never falls
  [[nodiscard]] std::span<const double> peak_temperatures() const noexcept { return peaks_; }

  /// [vertex_count] share of the original water that is left, 1 to 0, never rising
  [[nodiscard]] std::span<const double> water() const noexcept { return water_; }

  /// Whether any tetrahedron is left at a vertex. @param vertex  of the body
  [[nodiscard]] bool has_tissue(Index vertex) const { return capacities_[vertex] > 0; }

  /// [tet_count] vertices of the body, those of removed tetrahedra included
  [[nodiscard]] std::span<const Tet> tets() const noexcept { return tets_; }

  /// [edge_count] vertices of the body, smaller first; those without tissue any more included
  [[nodiscard]] std::span<const Edge> edges() const noexcept { return edges_; }

  /// [edge_count] W/K, of living tissue, before any limit for the sake of the time step
  [[nodiscard]] std::span<const double> conductances() const noexcept { return conductances_; }

  /// [vertex_count] J/K, of living tissue
  [[nodiscard]] std::span<const double> capacities() const noexcept { return capacities_; }

  /// [vertex_count] m, of the rest mesh, and where new vertices would lie in it
  [[nodiscard]] std::span<const Eigen::Vector3d> rest_positions() const noexcept {
    return rest_positions_;
  }

  /// Between the body's numbering and the scene's; kInvalidIndex for what is not of the body.
  [[nodiscard]] Index scene_vertex(Index vertex) const { return vertex_ids_.scene_id(vertex); }
  [[nodiscard]] Index scene_tet(Index tet) const { return tet_ids_.scene_id(tet); }
  [[nodiscard]] Index find_vertex(Index scene_vertex) const {
    return vertex_ids_.find(scene_vertex);
  }
  [[nodiscard]] Index find_tet(Index scene_tet) const { return tet_ids_.find(scene_tet); }

  /// Whether a vertex has ever reached the boiling temperature. @param vertex  of the body
  [[nodiscard]] bool has_boiled(Index vertex) const {
    return peaks_[vertex] >= kBoilingTemperature;
  }

  /// How many of a tetrahedron's vertices have boiled.
  /// @param tet  of the body
  [[nodiscard]] int boiling_vertices(Index tet) const;

  /// J delivered by sources so far.
  [[nodiscard]] double energy_in() const noexcept { return in_; }

  /// Where that energy is. Cost: O(vertices).
  [[nodiscard]] HeatLedger ledger() const noexcept;
  [[nodiscard]] Index limited_edge_count() const noexcept { return limited_edge_count_; }

  void validate(const Solver& solver, const TopologyEdit& edit) const override;
  void apply(const Solver& solver, const TopologyEdit& edit,
             const EditResult& result) noexcept override;
  void undo(const Solver& solver, const TopologyEdit& edit,
            const EditResult& result) noexcept override;

 private:
  // Ids of the scene: at first a range, then some of those that edits brought, ascending.
  struct SceneIds {
    Index first = 0;
    Index count = 0;
    std::vector<Index> added{};

    [[nodiscard]] Index scene_id(Index own) const {
      return own < count ? first + own : added[own - count];
    }
    [[nodiscard]] Index find(Index scene_id) const;
    [[nodiscard]] std::size_t size() const {
      return static_cast<std::size_t>(count) + added.size();
    }
  };

  void link_tet(Index tet) noexcept;
  void unlink_tet(Index tet) noexcept;
  void add_vertex(Index scene_vertex, Index first, Index second, double share);
  void add_tet(Index scene_tet, const Tet& vertices);
  void find_tet_edges(Index tet);
  [[nodiscard]] Index find_or_add_edge(Index a, Index b);
  void replace_corner(Index tet, Index from, Index to) noexcept;
  void sum_tet(Index tet) noexcept;
  void sum_vertex(Index vertex) noexcept;
  void sum_edge(Index edge) noexcept;
  void resize(std::size_t vertex_count, std::size_t tet_count, std::size_t edge_count);
  void bound_step(double dt);
  void boil(Index vertex);
  [[nodiscard]] double heat_of(Index tet) const noexcept;
  [[nodiscard]] double latent_rise() const noexcept;
  template <class Visit>
  void visit_tets(Index vertex, Visit visit) const;

  FollowedVersion followed_;
  TissueProperties tissue_;
  SceneIds vertex_ids_, tet_ids_;
  std::vector<Eigen::Vector3d> rest_positions_;          // [vertex_count] m
  std::vector<Tet> tets_;                                // [tet_count]
  std::vector<Edge> edges_;                              // [edge_count]
  std::vector<std::array<Index, 6>> tet_edges_;          // [tet_count]
  std::vector<std::array<double, 6>> tet_conductances_;  // [tet_count] W/K, of each edge
  std::vector<double> tet_masses_;                       // [tet_count] kg
  // The live tetrahedra at each vertex, ascending, so that sums over them depend on what lives
  // alone and not on how it came to be: corner 4 t + k is followed by next_corners_[t][k].
  std::vector<Index> first_corners_;                // [vertex_count]
  std::vector<std::array<Index, 4>> next_corners_;  // [tet_count]

  std::vector<double> conductances_;  // [edge_count] W/K, sum over live tetrahedra
  std::vector<double> limited_;       // [edge_count] W/K, as used with the current substep
  std::vector<double> capacities_;    // [vertex_count] J/K of live tissue
  std::vector<double> temperatures_, peaks_, water_;  // [vertex_count]
  std::vector<double> flows_;                         // [vertex_count] W, scratch
  double bounded_dt_ = 0;  // the dt for which substeps_ and limited_ hold
  int substeps_ = 1;
  Index limited_edge_count_ = 0;
  double in_ = 0, removed_ = 0;  // J, of the ledger

  // for the undo of the last edit
  double removed_before_ = 0;  // J
  std::size_t vertices_before_ = 0, tets_before_ = 0, edges_before_ = 0;
  std::vector<std::array<Index, 6>> moved_edges_;  // of the tetrahedron of each corner move
  bool has_stepped_ = false;                       // since that edit
};

}  // namespace pbdsurg
