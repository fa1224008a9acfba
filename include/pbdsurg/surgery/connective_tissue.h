// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Connective tissue between organs: strands that stretch, tear, and are cut or burnt apart.

#include <Eigen/Core>
#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/surgery/membrane.h"
#include "pbdsurg/tissue/scene.h"
#include "pbdsurg/tissue/tissue.h"

namespace pbdsurg {

/// What strands are made of.
struct StrandOptions {
  /// Links in a row, >= 1: one joins two surface vertices directly, and resists pressure as it does
  /// tension; more have particles between them and give way to pressure.
  int segments = 1;
  double stiffness = 0.12;  ///< N of tension in a fibre of twice its rest length, positive
  float fraction = 1;       ///< as Stiffness has it, for fraction mode
  /// A strand tears when it is longer than this times its rest length: > 1, infinite for never. At
  /// rest, in compliance mode, that is a tension of stiffness (tear_stretch - 1) in each fibre, N.
  double tear_stretch = 2;
  double least_length = 0.2e-3;  ///< m, positive: shorter links stretch and tear as if so long
  double slack = 0;              ///< in [0, 1]: how much longer than the gap; needs two segments
  /// kg, positive; of two segments or more. With much less than stiffness substep^2 / length of a
  /// link, one sweep a substep leaves strands too long: soft, and soon torn. A millimetre of tissue
  /// 2 mm^2 across has 2e-6.
  double particle_mass = 2e-5;
  std::uint64_t seed = 1;  ///< of the side to which a slack strand bows
};

/// A strand: links in a row, from the first organ to the second.
struct Strand {
  Index first_link;   ///< the others follow
  Index link_count;   ///< >= 1; after a compaction, of a strand that had parted, >= 0
  Index fibres;       ///< that run side by side in it
  float tear_length;  ///< m: longer, all links together, it tears
};

/// Why a strand parted.
enum class StrandLoss : std::uint8_t {
  torn,            ///< longer than its tear_length
  blade,           ///< cut
  removed,         ///< a link went by an edit made elsewhere: a cautery's, where heat parted it
  without_tissue,  ///< what it hung on has gone
};

/// A strand that parted.
struct StrandEvent {
  Index strand;      ///< of ConnectiveTissue::strands()
  Index link;        ///< of the tissue, where it parted first; kInvalidIndex after a compaction
  StrandLoss cause;  ///< why it parted
  std::uint64_t version;  ///< of the tissue, after the edit
};

/// Strands between organs, and what became of them. Deterministic.
///
/// join() adds strands to a scene, of which then a tissue is made. From then on this must follow
/// that: see Tissue::add_follower(). A strand that has parted carries nothing: what is left of it
/// hangs from the organs, and is not torn or cut again.
///
/// Cost of an edit that parts strands, and of its undo: O(strands); of others: O(links removed).
/// Of a solver with copies, the first is looked at.
class PBDSURG_API ConnectiveTissue final : public Follower {
 public:
  /// Without strands.
  ConnectiveTissue() = default;

  /// As another is or was, by what it had: a strand is whole unless there is an event of it.
  /// @param strands  [strand_count] of links of the tissue, ascending
  /// @param events   in their order
  /// @param tissue   that this is to follow from here on
  /// @throws InvalidArgument  naming the strand whose links are out of range or out of order, or
  ///                          the event whose strand there is not, or parted before
  ConnectiveTissue(std::vector<Strand> strands, std::vector<StrandEvent> events,
                   const Tissue& tissue);

  /// Joins two bodies of a scene along links of membrane_links() or scattered_links(); strands of
  /// several segments bring a body of particles, "strands from A to B".
  /// @param links  in vertices of the two bodies
  /// @return       the index of the first new strand; strand i is of links[i]
  /// @throws InvalidArgument  naming the option, the body or the link out of range, or the body
  ///                          that would be joined to itself, and as Scene::add_particles(); then
  ///                          nothing has changed
  Index join(Scene& scene, Index first, Index second, std::span<const MembraneLink> links,
             const StrandOptions& options = {});

  /// [strand_count] in the order of join(), those that parted included.
  [[nodiscard]] std::span<const Strand> strands() const noexcept { return strands_; }
  /// Whether a strand has not parted.
  /// @throws InvalidArgument  naming the strand that there is not
  [[nodiscard]] bool is_whole(Index strand) const;
  /// How many have not parted.
  [[nodiscard]] Index whole_count() const noexcept { return static_cast<Index>(whole_.size()); }

  /// Strands that parted, in their order; undoing an edit takes its events back. Read what is new
  /// after each step to know when.
  [[nodiscard]] std::span<const StrandEvent> events() const noexcept { return events_; }

  /// Share of all strands that parted for a cause, [0, 1]; 0 where there are none.
  [[nodiscard]] double share_lost(StrandLoss cause) const noexcept;

  /// Adds the links at which whole strands tear: the longest of each that exceeds its tear_length.
  ///
  /// This and the next: O(links of whole strands), and they allocate only what `links` does.
  /// @param links  takes ids for TopologyEdit::remove_links
  /// @throws InvalidArgument  if this does not follow the solver's tissue
  void find_torn(const Solver& solver, std::vector<Index>& links);

  /// Adds the links of whole strands that blades crossed, of each strand the first. Strands are
  /// taken where they are now: a blade that rests cuts nothing.
  /// @throws InvalidArgument  as find_torn(), and naming the blade that is not finite
  void find_cut(const Solver& solver, std::span<const BladeSweep> blades,
                std::vector<Index>& links);

  /// Adds to an edit the links at which whole strands are cut or tear: of each that the edit names
  /// no link of yet, one. events() tells the cause once that edit was applied.
  /// @throws InvalidArgument  as find_cut()
  void find_parting(const Solver& solver, std::span<const BladeSweep> blades, TopologyEdit& edit);

  /// Cuts and tears, in one edit of the solver's tissue; to be called once a step. A strand that is
  /// both is cut.
  /// @return  what it did; null if nothing parted, and then there was no edit
  /// @throws InvalidArgument  as find_cut(), and whatever a follower throws to refuse the edit;
  /// then
  ///                          nothing has changed
  const TissueChange* separate(Solver& solver, std::span<const BladeSweep> blades = {});

  void follow(const Tissue& tissue, const TissueChange& change) noexcept override;
  void undo(const Tissue& tissue, const TissueChange& change) noexcept override;
  /// Strands and events keep their numbers. Links of strands that parted are those that are left,
  /// which may be none.
  void renumber(const Tissue& tissue, const Renumbering& ids) noexcept override;

 private:
  void read_ends(const Solver& solver);
  void collect_whole(std::span<const Link> links) noexcept;
  template <class Visit>
  void visit_whole(Visit visit) const;

  std::vector<Strand> strands_;
  std::vector<bool> is_whole_;       // [strand_count]
  std::vector<StrandEvent> events_;  // has room for all strands
  std::size_t undone_events_ = 0;    // how many there were before the last edit
  std::vector<Index> whole_;         // strands, ascending
  std::vector<Index> ends_;          // scene vertices, two for each link of each whole strand
  std::vector<Eigen::Vector3f> positions_;  // m, of ends_
  TopologyEdit edit_;                       // of separate()
  // of the last find_parting(), by link, until the next edit
  std::vector<std::pair<Index, StrandLoss>> causes_;
  std::vector<Index> named_;  // strands, scratch
};

}  // namespace pbdsurg
