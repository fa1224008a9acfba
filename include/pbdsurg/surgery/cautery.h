// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// An electrosurgical hook: heat where it touches, tissue that shrinks and goes, links that part.

#include <Eigen/Core>
#include <span>
#include <vector>

#include "pbdsurg/core/types.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/thermal/heat_field.h"
#include "pbdsurg/thermal/tissue.h"
#include "pbdsurg/thermal/tissue_state.h"

namespace pbdsurg {

struct CauteryOptions {
  double contact_radius = 1.5e-3;  ///< m, reach of the tip into tissue
  double dry_water = 0.05;         ///< share of water below which boiling tissue is gone
  double largest_shrinkage = 0.3;  ///< of lengths, when all water has gone
  double link_energy = 0.8;        ///< J that part one link: 0.5 mm^3 of membrane boiled dry
  double link_share = 4;           ///< how much more a link takes than a vertex as near: current
                                   ///< crowds in what is thin
};

/// What one update did.
struct CauteryReport {
  Index contact_vertices = 0;
  Index contact_links = 0;
  double energy = 0;     ///< J delivered; none where the tip touches nothing
  TopologyEdit request;  ///< what heat changed, for undo_edit(); empty if there was no edit
  EditResult edit;       ///< what went
};

/// Couples a hook's tip to a heat field and to topology. Deterministic.
///
/// Only vertices are sensed: where edges are longer than the contact radius, a tip between them
/// touches nothing. Edits made elsewhere must name the cautery as a participant, so that its field
/// follows. Undoing an edit does not take back the heat that led to it: what heat removed goes
/// again in the next update.
class Cautery final : public EditParticipant {
 public:
  /// Tetrahedra that are gone already are left out.
  /// @throws InvalidArgument  naming the option out of range, the body that is not there, is given
  ///                          twice or has no water, or whose mesh is missing or not of its size,
  ///                          or if edits brought new vertices already
  Cautery(const Solver& solver, std::span<const ThermalBody> bodies,
          const CauteryOptions& options = {});

  /// Applies power at the tip for dt, lets heat spread, shrinks, removes and cuts.
  ///
  /// The power is shared among the vertices and links within the contact radius, by
  /// 1 - distance / radius, links link_share times as much; vertices whose water is gone take
  /// nothing and pass their share on to wet neighbours. Where all is dry, nothing is delivered. A
  /// power of zero lets the tissue cool.
  /// @param tip    m, in the world
  /// @param power  W, >= 0
  /// @param dt     s
  /// @param participants  further holders of topology, beside the heat field
  /// @throws InvalidArgument  for a value out of range; then nothing has changed. What another
  ///                          participant throws to refuse the edit passes through: the heat has
  ///                          been delivered then, and the edit is tried again in the next update.
  CauteryReport update(Solver& solver, const Eigen::Vector3f& tip, double power, double dt,
                       std::span<EditParticipant* const> participants = {});

  [[nodiscard]] const HeatField& field() const noexcept { return field_; }

  /// State of a tetrahedron; normal where the hook may not burn. @param tet  of the scene
  [[nodiscard]] HeatState state(Index tet) const;

  void validate(const Solver& solver, const TopologyEdit& edit) const override;
  void apply(const Solver& solver, const TopologyEdit& edit,
             const EditResult& result) noexcept override;
  void undo(const Solver& solver, const TopologyEdit& edit,
            const EditResult& result) noexcept override;

  /// What went into links, J.
  [[nodiscard]] double link_energy_spent() const noexcept { return link_energy_spent_; }

 private:
  struct Share {
    Index id;  // vertex or link
    double weight;
  };
  std::vector<Share> find_touched_vertices(std::span<const Eigen::Vector3f> positions,
                                           const Eigen::Vector3f& tip) const;
  std::vector<Share> find_touched_links(const Solver& solver,
                                        std::span<const Eigen::Vector3f> positions,
                                        const Eigen::Vector3f& tip) const;
  void collect_changes(const Solver& solver, TopologyEdit& edit) const;
  [[nodiscard]] double shrunk(double water) const;
  [[nodiscard]] double energy_in() const noexcept;

  CauteryOptions options_;
  HeatField field_;
  std::vector<double> link_doses_;  // [link] J
  double link_energy_spent_ = 0;
};

}  // namespace pbdsurg
