// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Temperature and state of living tissue, heated from outside.

#include <cmath>
#include <cstddef>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"
#include "pbdsurg/heat/thermal_model.h"
#include "pbdsurg/mesh/tet_mesh.h"
#include "pbdsurg/tissue/thermal_properties.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

class HeatRegion;

/// Heat delivered to one vertex.
struct HeatSource {
  Index vertex;  ///< of HeatField::mesh()
  double power;  ///< W
};

/// Heat delivered evenly within one tetrahedron.
struct TetHeatSource {
  Index tet;     ///< of HeatField::mesh()
  double power;  ///< W
};

/// Where the energy went since the start, J. What came in equals the sum of the others, which are
/// counted separately.
struct HeatLedger {
  double in = 0;         ///< from sources, and from vertices whose temperature is held or set
  double sensible = 0;   ///< held as temperature above body temperature
  double latent = 0;     ///< went with steam: latent heat, and what warmed that water; with smoke
  double removed = 0;    ///< taken away with removed elements, what their steam took included
  double surface = 0;    ///< given to the ambient
  double perfusion = 0;  ///< carried off by blood
};

/// How heat is computed.
struct HeatOptions {
  /// K from body temperature: what is nearer to it, and has no neighbour beyond, rests; a surface
  /// with an ambient beyond takes part in every step. 0: the whole mesh does.
  double active_rise = 0.1;
  double tolerance = 1e-6;    ///< of the linear system's residual, relative; (0, 1)
  int most_iterations = 200;  ///< of its solver, >= 1
  /// Who solves the linear system; all else is the caller's thread's. Systems too small for threads
  /// leave them asleep, and their bits do not depend on them. A device's answers agree with the
  /// host's to the tolerance, and repeat their own bits.
  Executor executor{};
  /// Active vertices, >= 0, from which a device solves, opened by the first such system; up to
  /// 2^25, and none of a sheet. Measured on an H200 beside its Xeon: 1,040 rows take as long on
  /// both, 4,046 rows 0.22 and 0.38 ms.
  Index device_rows = 1500;
};

/// What one step did.
struct HeatReport {
  Index active_vertices = 0;  ///< that took part
  int iterations = 0;         ///< of the linear system's solver
  double residual = 0;        ///< relative, of the linear system
  /// Whether the tolerance was reached. If not, energy is still accounted for.
  bool converged = true;
  /// Whether the step was taken; one whose result would not be finite is not.
  bool accepted = true;
  double hottest = kBodyTemperature;  ///< degrees Celsius, of what takes part
  Index slivers = 0;                  ///< ThermalMesh::sliver_count()
  bool is_on_device = false;          ///< who solved the linear system
};

/// What steps change of a field, at one version of its tissue.
struct HeatSnapshot {
  std::vector<double> temperatures;       ///< [vertex_count] as HeatField::temperatures()
  std::vector<double> peak_temperatures;  ///< [vertex_count] as HeatField::peak_temperatures()
  std::vector<double> water;              ///< [vertex_count] as HeatField::water()
  std::vector<double> survival;           ///< [vertex_count] as HeatField::survival()
  std::vector<double> collagen;           ///< [vertex_count] as HeatField::collagen()
  std::vector<double> charred;            ///< [vertex_count] as HeatField::charred()
  std::vector<Index> held;                ///< vertices of HeatField::hold(), each once
  std::vector<Index> active;              ///< vertices that the last step worked on, ascending
  std::vector<Index> pending;             ///< vertices that the next step looks at besides
  Index most_warm = 0;                    ///< vertices, since what takes part was last chosen
  HeatLedger ledger;                      ///< where the energy went
  TissueVersion tissue;                   ///< Tissue::identified_version()
};

/// Heat in the tissue of one or more bodies: conduction, boiling, perfusion, loss at the surface,
/// damage. Temperature moves with the tissue.
///
/// Linear finite elements with lumped mass on the rest mesh, stepped by the theta method in
/// increment form (the generalised trapezoidal rule: Hughes, The Finite Element Method, 8.2; for an
/// equation of first order also what is left of Newmark's scheme, whose gamma is theta):
///
///     (M + theta dt (K + R + B)) d = dt (b - (K + R + B) T),  T += d,
///
/// with M_i = rho c(w) V_i, (K T)_i = sum_j K_ij (T_j - T_i), R the perfusion of Pennes' equation,
/// + G (T_body - T), which ends where tissue coagulates, and B loss at the surface, + h A (T_amb -
/// T). Where linear elements have negative conductances they stay, so linear fields stay exact. A
/// vertex at 100 degrees then stays there until its water has boiled away; damage and char
/// follow from the temperature (heat/tissue_state.h). Boiling off once a step makes a drying front
/// of order 1/2 in the step: of Neumann's problem at 200 degrees on edges of 0.1 mm, after 5 s, it
/// lags by 2.4, 4.4 and 14 % with steps of 2, 10 and 100 ms.
///
/// Only the part takes part in which tissue is warm or heated, or has a surface that the ambient
/// warms or cools, and some rings around it; its rim is insulated. It grows as it warms and shrinks
/// as it cools. A step costs O(that part), whatever the size of the mesh, and allocates nothing
/// unless the part grows beyond what it was. The same calls give the same bits for any number of
/// threads, or on the same device.
///
/// Follows edits in O(changed); the next step takes up what changed. A new
/// vertex starts between the two that it lies between, by its share: water, peak and state as
/// such, temperature so that tetrahedra that are divided hold as much heat and steam as before; no
/// temperature leaves the range of those around it. An undo gives removed tissue back as
/// warm as its vertices are then; what that brings in, if steps were taken since, is taken from
/// HeatLedger::removed. All in the scene's numbering; vertices without tissue keep what they had. A
/// copy follows no edits and cannot be made to: it is of use until the next.
class PBDSURG_API HeatField final : public Follower {
 public:
  /// One body by itself, with the ids of its mesh.
  /// @throws InvalidArgument     naming the property, setting or option that is out of range
  HeatField(const TetMesh& mesh, const ThermalProperties& tissue, const ThermalModel& model = {},
            const HeatOptions& options = {});

  /// Bodies of living tissue, whose edits it follows.
  /// @throws InvalidArgument  as ThermalMesh and above
  HeatField(const Tissue& tissue, std::span<const ThermalBody> bodies,
            const ThermalModel& model = {}, const HeatOptions& options = {});

  /// Of a mesh, whose tissue's edits it follows.
  /// @throws InvalidArgument     naming the setting or option that is out of range, or if the mesh
  /// is
  ///                             a copy and its tissue was edited since
  HeatField(ThermalMesh mesh, const ThermalModel& model = {}, const HeatOptions& options = {});

  /// Advances by dt with constant sources; several at one place add up. Sources where no tissue is
  /// left, and at held vertices, deliver nothing.
  /// @param dt  s, positive and finite
  /// @throws InvalidArgument  naming the source whose vertex or tetrahedron is out of range or
  ///                          whose power is negative or not finite; then nothing has changed
  /// @throws Error            if a device fails; then temperatures and state are what they were
  HeatReport step(double dt, std::span<const HeatSource> sources,
                  std::span<const TetHeatSource> tet_sources = {});

  /// Sets temperatures, counted as energy that came in. Cost: O(n).
  /// @param vertices      [n] with tissue, each once
  /// @param temperatures  [n] degrees Celsius
  /// @throws InvalidArgument  naming the vertex that is out of range or without tissue, or the
  ///                          temperature that is not finite, or if sizes differ; nothing changes
  void set_temperatures(std::span<const Index> vertices, std::span<const double> temperatures);

  /// Holds vertices at their temperature from now on, instead of those held before: a heated jaw,
  /// a boundary of a test. Heat that this takes counts as coming in. They do not boil.
  /// @param vertices  [n] each once
  /// @throws InvalidArgument  naming the vertex out of range or given twice; then nothing has
  ///                          changed
  void hold(std::span<const Index> vertices);

  /// The state, to go back to. Cost: O(vertex_count).
  [[nodiscard]] HeatSnapshot snapshot() const;

  /// Goes back to a snapshot of this field, or of another in the same tissue, while the topology is
  /// what it was. On a host, steps from then on give the bits that they gave from there. Cost:
  /// O(vertex_count).
  /// most_warm and the ledger are taken as they are.
  /// @throws InvalidArgument  if the tissue is another, or was edited since, even to as many
  ///                          vertices; naming the array of another size, the vertex out of range
  ///                          or given twice, the active one that none of its bodies has, the
  ///                          temperature that is not finite or the share outside of [0, 1]; then
  ///                          nothing has changed
  void restore(const HeatSnapshot& snapshot);

  /// The tissue there is. Its topology follows edits through this field.
  [[nodiscard]] const ThermalMesh& mesh() const noexcept { return mesh_; }
  /// As given.
  [[nodiscard]] const ThermalModel& model() const noexcept { return model_; }
  /// HeatOptions::executor.
  [[nodiscard]] const Executor& executor() const noexcept { return options_.executor; }

  /// @name State
  /// Each [vertex_count] of mesh().
  /// @{

  /// degrees Celsius
  [[nodiscard]] std::span<const double> temperatures() const noexcept { return temperatures_; }

  /// degrees Celsius, the highest so far: unlike the temperature it never falls
  [[nodiscard]] std::span<const double> peak_temperatures() const noexcept { return peaks_; }

  /// share of the original water that is left, 1 to 0, never rising
  [[nodiscard]] std::span<const double> water() const noexcept { return water_; }

  /// share not yet coagulated, exp(-Omega) of the damage integral, 1 to 0, never rising
  [[nodiscard]] std::span<const double> survival() const noexcept { return survival_; }

  /// share of collagen not yet denatured, 1 to 0, never rising
  [[nodiscard]] std::span<const double> collagen() const noexcept { return collagen_; }

  /// share that is char, 0 to 1, never falling
  [[nodiscard]] std::span<const double> charred() const noexcept { return charred_; }

  /// @}

  /// @name One vertex or tetrahedron
  /// These functions throw InvalidArgument, naming the vertex or tetrahedron out of range.
  /// @{

  /// J/K of living tissue at a vertex, with the water that is left. Cost: O(tets at it).
  [[nodiscard]] double capacity(Index vertex) const;

  /// Whether a vertex has ever reached the boiling temperature.
  [[nodiscard]] bool has_boiled(Index vertex) const;

  /// How many of a tetrahedron's vertices have boiled.
  [[nodiscard]] int boiled_vertices(Index tet) const;

  /// @}

  /// Vertices that the last step worked on, ascending. Valid until the next call that changes
  /// anything.
  [[nodiscard]] std::span<const Index> active_vertices() const;

  /// Where the energy went since the start.
  [[nodiscard]] const HeatLedger& ledger() const noexcept { return ledger_; }

  void validate(const Tissue& tissue, const TopologyEdit& edit) const override;
  void validate_undo(const Tissue& tissue, const TissueChange& change) const override;
  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  // Copies with its owner.
  class RegionPointer {
   public:
    explicit RegionPointer(const HeatOptions& options);
    RegionPointer(const RegionPointer& other);
    RegionPointer(RegionPointer&&) noexcept;
    RegionPointer& operator=(RegionPointer other) noexcept;
    ~RegionPointer();
    HeatRegion* operator->() const noexcept { return region_.get(); }
    HeatRegion& operator*() const noexcept { return *region_; }
    // @throws InvalidArgument  if the field was moved from
    void check() const;

   private:
    std::unique_ptr<HeatRegion> region_;
  };

  // Of a vertex or an element, J.
  struct Heat {
    double sensible = 0, latent = 0;
  };

  void resize(std::size_t vertex_count);
  [[nodiscard]] bool is_boiled(Index vertex) const {
    return peaks_[static_cast<std::size_t>(vertex)] >= kBoilingTemperature;
  }
  // of a vertex with tissue
  [[nodiscard]] const ThermalProperties& tissue(Index vertex) const {
    return mesh_.tissues()[static_cast<std::size_t>(mesh_.tissue_of_vertex(vertex))];
  }
  [[nodiscard]] Heat heat_per_mass(Index vertex) const;
  [[nodiscard]] Heat heat_of(Index element) const;
  [[nodiscard]] Heat heat_of(std::span<const Index> vertices) const;
  void check(double dt, std::span<const HeatSource> sources,
             std::span<const TetHeatSource> tet_sources) const;
  // whether the ambient warms or cools tissue at body temperature
  [[nodiscard]] bool has_other_ambient() const {
    return model_.surface_transfer > 0 &&
           std::abs(model_.ambient_temperature - kBodyTemperature) > options_.active_rise;
  }
  // with its neighbours; of a vertex with tissue
  [[nodiscard]] bool takes_part(Index vertex) const;
  void activate(std::span<const HeatSource> sources, std::span<const TetHeatSource> tet_sources);
  void fill_rows(double dt, std::span<const HeatSource> sources,
                 std::span<const TetHeatSource> tet_sources);
  bool grow_rim(int rings);
  [[nodiscard]] double held_flow(std::span<const double> flows) const;
  void balance(double dt);
  void advance_state(double dt, HeatReport& report);
  void shrink();
  void add_vertex(Index vertex, const NewVertex& added);

  ThermalMesh mesh_;
  ThermalModel model_;
  HeatOptions options_;
  std::vector<double> temperatures_, peaks_, water_, survival_, collagen_, charred_;
  std::vector<Index> held_;
  HeatLedger ledger_;
  RegionPointer region_;
  std::vector<Index> pending_;  // vertices that may be warm and not yet in the region
  Index most_warm_ = 0;         // vertices, since the region was laid out

  // of the rows of the region, scratch
  struct Row {
    double temperature, capacity;  // degrees Celsius, J/K
    double perfusion, surface;     // W/K
    double power;                  // W
    bool is_held;
  };
  std::vector<Row> rows_;
  std::vector<double> row_temperatures_, flows_, added_, right_, increments_;
  std::vector<double> held_increments_;
  std::vector<Index> seeds_;

  // for the undo of the last edit
  HeatLedger ledger_before_;
  std::size_t vertices_before_ = 0, pending_before_ = 0;
  bool has_stepped_ = false;   // since that edit
  mutable Heat touched_heat_;  // of what it touched, noted when its undo is validated
  std::uint64_t seen_growth_ = 0, seen_version_ = 0;  // of the mesh
};

}  // namespace pbdsurg
