// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Electric potential around an electrode that touches tissue, and the heat of its current.

#include <Eigen/Core>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/executor.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/thermal_mesh.h"

namespace pbdsurg {

class HeatField;

/// A vertex that the electrode touches.
struct PatchVertex {
  Index vertex;  ///< of the mesh
  /// Share of the vertex's part of the surface that is touched, (0, 1]. From 0.99 on the vertex
  /// has the potential of the electrode; a lesser share adds the resistance by which a smaller disk
  /// exceeds a larger one, so that contact is made and broken smoothly.
  double weight;
};

/// How the potential is computed.
struct PotentialOptions {
  double region_radii = 10;   ///< radius of the region over that of the contact, > 1
  double tolerance = 1e-3;    ///< of the residual, (0, 1); the power's error is its square
  int most_iterations = 200;  ///< >= 0
  /// Relative, beyond which a solution is out of date, >= 0; so it is where tissue ceases to
  /// conduct.
  double conductivity_change = 0.05;
  Executor executor{};  ///< as HeatOptions::executor
  /// Vertices of a region, >= 0, from which a device solves; up to 2^25, and without triangles of
  /// sheets. Measured on an H200 beside
  /// its Xeon: 1,100 take 0.16 to 0.18 ms there and 0.23 to 0.30 ms on one thread, 850 take 0.12
  /// and 0.10.
  Index device_rows = 1000;
};

/// What PotentialField::solve() found.
struct PotentialReport {
  double conductance = 0;     ///< S, between electrode and ground; 0: an open circuit
  bool is_closed = false;     ///< whether current has a way from the electrode to ground
  bool is_new = false;        ///< whether this call solved, or found its last solution good enough
  int iterations = 0;         ///< of the last solution, as what follows
  double residual = 0;        ///< relative
  bool has_converged = true;  ///< whether the tolerance was reached
  Index vertex_count = 0;     ///< of the region
  Index lost_count = 0;       ///< vertices of the patch that no conducting element has
  bool is_on_device = false;  ///< who solves in this region
};

/// div(sigma grad u) = 0 in a region around the electrode: u is 1 on it and 0 at ground, and no
/// current leaves elsewhere. Linear finite elements; displacement current is neglected (in liver at
/// 500 kHz it makes the admittance 1.13 times as large, in other tissue less).
///
/// In sheets current flows along the plane, through all of the thickness. The region is what
/// conducting elements join to the patch within region_radii radii of the
/// contact, where ground begins: that leaves out (2 / pi) / region_radii of the resistance of a
/// disk on a half-space, and with a prescribed power hardly any of the heat. A radius counts as at
/// least half an edge of the mesh, for so does a disk that one vertex stands for; and the ball is
/// at most as wide as 0.9 of its body's longest side, so that every whole body has a ground. A
/// piece cut off within the ball has none: an open circuit without heat, and so is an empty or a
/// lost patch. Tissue that the patch does not reach has no heat, and no potential.
///
/// Heat for a voltage U is U^2 times what is given here for one volt, and sums to U^2 conductance
/// to rounding, converged or not: scaled to a wanted power, that is always right.
///
/// solve() sees what edits changed in its ThermalMesh. A compaction leaves patch and ground where
/// they are, but for vertices that were gone; there is no solution until the next solve().
/// Deterministic: the same calls give
/// the same bits for any number of threads, or on the same device. Allocates nothing while regions
/// are not larger than before.
class PBDSURG_API PotentialField {
 public:
  /// @param mesh  must outlive this, and stay where it is
  /// @throws InvalidArgument  naming the option that is out of range
  explicit PotentialField(const ThermalMesh& mesh, const PotentialOptions& options = {});

  /// In the tissue of a field of heat, with its executor where the options name none.
  /// @param field  must outlive this, and stay where it is
  /// @throws InvalidArgument  naming the option that is out of range
  explicit PotentialField(const HeatField& field, const PotentialOptions& options = {});
  ~PotentialField();
  PotentialField(const PotentialField&) = delete;
  PotentialField& operator=(const PotentialField&) = delete;

  /// What the electrode touches from now on; empty: nothing. Those without tissue, now or later, do
  /// not count.
  /// @param area  m^2 of contact, which gives the size of the region; positive and finite, or
  ///              anything for an empty patch
  /// @throws InvalidArgument  naming the vertex that is out of range or given twice, the weight
  ///                          outside (0, 1], or the area; then nothing has changed
  void set_patch(std::span<const PatchVertex> patch, double area);

  /// Vertices at potential 0, in place of the ball around the patch; none: the ball. The patch
  /// prevails where both have a vertex.
  /// @throws InvalidArgument  naming the vertex that is out of range; then nothing has changed
  void set_ground(std::span<const Index> vertices);

  /// Finds the region that the next solve() will solve in, for who gathers positions of it alone;
  /// what is given below stays that of the last solution.
  /// @param conductivities  as for solve()
  /// @return  [n] ids of its vertices, valid until the next call; empty where nothing conducts
  /// @throws InvalidArgument  as solve()
  /// Cost: O(region) to look, far below a solution; a search, where one is due, as much as one.
  std::span<const Index> find_region(const ElementSpan& conductivities);

  /// Solves for one volt, from where the last solution ended, if the patch, the topology or a
  /// conductivity of the region changed enough; else nothing is done but to look.
  /// @param conductivities  S/m, >= 0 and finite where elements of the region live; of triangles
  ///                        only where the mesh has any that conduct
  /// @param positions       [vertex_count] m, for the current shape of the tissue, in which
  ///                        flattened elements count as of a tenth of their rest volume, and
  ///                        slivers as ThermalMesh has them; empty: the shape at rest. Moves count
  ///                        where they exceed conductivity_change of an edge's length.
  /// @throws InvalidArgument  naming the array of a wrong size, the element whose conductivity
  ///                          is negative or not finite, or the vertex whose position is not
  ///                          finite, or if the mesh is a copy, and so missed an edit; then nothing
  ///                          has changed
  /// @throws Error            if a device fails; then nothing is left of the last solution, as with
  ///                          an empty patch, and the next call starts afresh
  /// Cost: O(region), and of a new region once more: one that has to be searched for, since the
  /// patch left its middle, tissue came or changed corners, or may have been cut off by what went.
  /// See bench/potential_bench.cpp.
  const PotentialReport& solve(const ElementSpan& conductivities,
                               std::span<const Eigen::Vector3f> positions = {});

  /// Is as if it were new from here on, without patch, ground and solution: what is given to two
  /// such fields has the same bits. Cost: O(V).
  void forget() noexcept;

  /// Of the last call of solve().
  [[nodiscard]] const PotentialReport& report() const noexcept;

  /// [vertex_count of the region] ids. Until another region is searched for, those stay whose
  /// tissue has gone, without heat; so do their elements in elements().
  [[nodiscard]] std::span<const Index> vertices() const noexcept;

  /// [vertex_count of the region] share of the electrode's voltage, in [0, 1] but for obtuse
  /// tetrahedra and the tolerance
  [[nodiscard]] std::span<const double> potentials() const noexcept;

  /// [vertex_count of the region] W/V^2: a quarter of the heat of each tetrahedron, a third of that
  /// of each triangle, and that of a contact that is less than whole; sums to the conductance.
  [[nodiscard]] std::span<const double> vertex_heat() const noexcept;

  /// [element_count of the region] ids
  [[nodiscard]] std::span<const Index> elements() const noexcept;

  /// [element_count of the region] W/V^2: sigma V |grad u|^2
  [[nodiscard]] std::span<const double> element_heat() const noexcept;

 private:
  struct Work;
  std::unique_ptr<Work> work_;
};

}  // namespace pbdsurg
