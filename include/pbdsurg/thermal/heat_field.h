// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Temperature and water of a body, heated from outside.

#include <array>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/mesh/topology.h"
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
/// Follows edits of its body: pass it to apply_edit() as a participant. Cost of a step, and of the
/// step after an edit once more: O(vertices + edges) of the body.
class HeatField final : public EditParticipant {
 public:
  static constexpr int kMostSubsteps = 16;  ///< per call of step()

  /// @param mesh       the body's rest mesh, whole: a field made after tetrahedra were removed does
  ///                   not know of that
  /// @param first_tet  the body's place in the scene's numbering, see Body
  /// @throws InvalidArgument  naming the property that is not positive, or the water fraction
  ///                          outside [0, 1]
  HeatField(const TetMesh& mesh, const TissueProperties& tissue, Index first_tet = 0);

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

  /// [edge_count] vertices of the body, sorted
  [[nodiscard]] std::span<const Edge> edges() const noexcept { return edges_; }

  /// Whether a vertex has ever reached the boiling temperature. @param vertex  of the body
  [[nodiscard]] bool has_boiled(Index vertex) const {
    return peaks_[vertex] >= kBoilingTemperature;
  }

  /// How many of a tetrahedron's vertices have boiled.
  /// @param tet  of the body
  [[nodiscard]] int boiling_vertices(Index tet) const;

  [[nodiscard]] const HeatLedger& ledger() const noexcept { return ledger_; }
  [[nodiscard]] Index limited_edge_count() const noexcept { return limited_edge_count_; }

  void validate(const Solver& solver, const TopologyEdit& edit) const override;
  void apply(const Solver& solver, const TopologyEdit& edit,
             const EditResult& result) noexcept override;
  void undo(const Solver& solver, const TopologyEdit& edit,
            const EditResult& result) noexcept override;

 private:
  void remove_tet(Index tet) noexcept;
  void sum_edge(Index edge) noexcept;
  void bound_step(double dt);
  void boil(Index vertex);
  void update_held() noexcept;
  [[nodiscard]] double latent_rise() const noexcept;

  TissueProperties tissue_;
  Index first_tet_;
  std::vector<Tet> tets_;
  std::vector<Edge> edges_;
  std::vector<std::array<Index, 6>> tet_edges_;          // [tet_count]
  std::vector<std::array<double, 6>> tet_conductances_;  // [tet_count] W/K, of each edge
  std::vector<double> tet_masses_;                       // [tet_count] kg
  std::vector<bool> alive_;                              // [tet_count]
  std::vector<Index> vertex_tets_;                       // [vertex_count] how many are alive
  IndexLists edge_tets_;                                 // [edge_count]

  std::vector<double> conductances_;  // [edge_count] W/K, sum over live tetrahedra
  std::vector<double> limited_;       // [edge_count] W/K, as used with the current substep
  std::vector<double> capacities_;    // [vertex_count] J/K of live tissue
  std::vector<double> temperatures_, peaks_, water_;  // [vertex_count]
  std::vector<double> flows_;                         // [vertex_count] W, scratch
  double bounded_dt_ = 0;  // the dt for which substeps_ and limited_ hold
  int substeps_ = 1;
  Index limited_edge_count_ = 0;
  HeatLedger ledger_;
};

}  // namespace pbdsurg
