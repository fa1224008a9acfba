// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// The way of current from an electrode through tissue, and its heat.

#include <Eigen/Core>
#include <cstdint>
#include <span>
#include <vector>

#include "pbdsurg/base/types.h"
#include "pbdsurg/heat/disk_source.h"
#include "pbdsurg/heat/heat_field.h"
#include "pbdsurg/heat/potential_field.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/tissue/renumbering.h"

#include "lib/surgery/electrode_contact.h"

namespace pbdsurg {

/// A vertex that the electrode's metal cools.
struct CooledVertex {
  Index vertex;
  double area;  ///< m^2 of the contact that counts for it
};

/// Tissue as the generator sees it.
struct TissueLoad {
  double conductance = 0;              ///< S; 0: no current has a way
  std::span<const HeatSource> heat{};  ///< W for 1 V; sums to the conductance
  int iterations = 0;
  bool converged = true;
};

/// Keeps the electrical conductivity of tissue up to date, and finds where current goes: by a
/// potential, or, where edges of a solid are longer than twice the radius of a disk as large as the
/// contact, by the closed form of that disk.
class Current {
 public:
  static constexpr double kSparkReach = 0.3e-3;  ///< m, beyond the contact

  /// @param positions  kept up to date with edits by their owner; what is needed is read into them
  Current(const HeatField& field, const CauteryOptions& options, ScenePositions& positions);

  /// Takes over what an electrode touches; again for the same contact where positions changed.
  void touch(const Solver& solver, const HeatField& field, const ElectrodeContact& contact);

  /// Lets current jump to wet surface within kSparkReach of the contact, through what is dry to the
  /// next wet vertices, and through as large a share of what is dry in cells there as kSparkReach
  /// is of their edges; of a disk, through the dry layer of all cells that are not dry altogether.
  /// Lasts until the next touch().
  /// @return  whether it is so
  bool arc(const HeatField& field, const ElectrodeContact& contact);

  /// Takes over what a step of the field changed, whether current flowed or not.
  void update_conductivities(const HeatField& field);

  /// Valid until the next call.
  TissueLoad find_load(const Solver& solver, const HeatField& field);

  /// What the metal touches; of a disk, all that takes its heat.
  [[nodiscard]] std::span<const CooledVertex> cooled() const noexcept { return cooled_; }

  [[nodiscard]] bool is_disk() const noexcept { return is_disk_; }
  [[nodiscard]] Index vertex_count() const noexcept { return vertex_count_; }
  [[nodiscard]] const PotentialField& potential() const noexcept { return potential_; }

  /// Takes the conductivity of all tissue anew, after the field went back to a snapshot, and keeps
  /// nothing of the last potential. Cost: O(elements).
  /// @param warm  live elements at the field's active vertices, ascending
  void restore(const HeatField& field, std::vector<Index> warm) noexcept;

  /// Goes along with a compaction, after the field has. What was touched has to be told again.
  void renumber(const HeatField& field, const Renumbering& ids);

  void follow(const HeatField& field) noexcept;
  void undo(const HeatField& field) noexcept;

 private:
  void find_conductivities(const HeatField& field, Index first_tet, Index first_triangle);
  void find_conductivity(const HeatField& field, Index element);
  void bridge(const HeatField& field);
  void find_bridged(const HeatField& field);
  [[nodiscard]] bool meet(Index element);
  void find_near_tets(const HeatField& field, const Triangle& triangle);
  TissueLoad find_disk_load(const HeatField& field);
  TissueLoad find_potential_load(const Solver& solver);

  double radius_;           // m, of the contact around the electrode's axis
  double disk_radius_ = 0;  // m, of a disk as large as the contact
  PotentialField potential_;
  DiskSource disk_;
  ScenePositions& positions_;
  ElementValues<double> conductivities_;  // S/m
  std::vector<Index> warm_;     // elements that update_conductivities() looks at in any case
  std::vector<Index> bridged_;  // elements that sparks pass, until the next touch()
  bool has_updated_ = false;    // since the last edit
  bool is_disk_ = false;
  bool is_sparking_ = false;  // of a disk, until the next touch()
  bool is_new_ = false;       // touched since the last find_load()
  Index vertex_count_ = 0;
  std::vector<PatchVertex> patch_, behind_;
  std::vector<CooledVertex> cooled_;
  std::vector<VertexShare> shares_;  // of the disk
  std::vector<HeatSource> heat_;

  // scratch
  ElementValues<std::uint32_t> seen_elements_;  // round in which each was met
  std::vector<std::uint32_t> seen_vertices_;    // likewise
  std::uint32_t round_ = 0;
  std::vector<Index> near_tets_, near_vertices_, warm_before_;
};

}  // namespace pbdsurg
