// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a servo has to know of a simulation: the tissue around a tool, found after a step.

#include <Eigen/Core>
#include <cstdint>
#include <span>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/ids.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/contact/contact_patch.h"
#include "pbdsurg/solver/solver.h"

namespace pbdsurg {

/// A body's surface that was read already, as World::surface() has it. Valid during a call.
struct TouchedSurface {
  std::span<const Triangle> triangles;         ///< corners in positions; thrice the same: none
  std::span<const Eigen::Vector3f> positions;  ///< m, in the scene
};

/// Finds the tissue around a tool after each step, in the thread of the simulation, for a
/// make_contact_packet() of any other. Can be moved; what was moved from refuses all else.
class PBDSURG_API ContactProbe {
 public:
  /// m/s, of tissue: what a probe that reads a solver counts with. Faster tissue is seen within
  /// 48 ms.
  static constexpr float kFastestTissue = 0.25F;

  /// @param bodies  [n] of the solver's tissue
  /// @param points  [n] of the tool, at most as many as a packet has planes
  /// @throws InvalidArgument  naming the body that there is not, the point that is not finite or
  ///                          whose radius is not positive, or the number of points
  ContactProbe(const Solver& solver, std::span<const Index> bodies,
               std::span<const ToolPoint> points);
  ~ContactProbe();
  /// Takes over.
  ContactProbe(ContactProbe&&) noexcept;
  ContactProbe& operator=(ContactProbe&&) noexcept;  ///< likewise

  /// Fills a patch with all that the tool may meet within ContactPatch::kMargin. The nearest points
  /// of its triangles are those of the whole surfaces, to the bit. The force is zero where jaws
  /// that are open now lost what they held in the step: see Solver::lost_grips().
  ///
  /// Reads from the solver the vertices around the tool, from a device in one transfer, those that
  /// edits show, and of all others groups in turn, each before the tool and kFastestTissue may have
  /// brought it near, and after 12 mm of these at the latest. It looks at all at once where they
  /// may have gone 3 mm since the last call, after a compaction, and if time goes back. After
  /// Solver::write_positions() and restore() what it sees may be 48 ms late.
  ///
  /// Cost: O(triangles around the tool), 0.03 ms of eight points on 10,800 triangles; where it
  /// looks at all O(triangles), 0.1 ms (contact_probe_bench, one of two cores of a Xeon at 2.6
  /// GHz, both busy).
  /// @param grasp     what the tool does to tissue now, as the solver does not tell
  /// @param sequence  of the step, above zero
  /// @param time      s, of the step
  /// @param patch     replaced
  /// @throws InvalidArgument  if there is no such tool, or the solver is of another tissue; for a
  ///                          sequence of zero, or a time that is not finite
  void collect_patch(const Solver& solver, ToolId tool, GraspState grasp, std::uint64_t sequence,
                     double time, ContactPatch& patch);

  /// Likewise, of surfaces that were read already, in place of the solver's positions. Nothing is
  /// too fast for it. Cost: O(triangles), 0.07 ms of the same, and no transfer from a device.
  /// @param surfaces  [n] of the bodies, as the last step left them
  /// @throws InvalidArgument  also if there is not one surface a body, or naming the triangle with
  ///                          a corner that is not among the positions
  void collect_patch(std::span<const TouchedSurface> surfaces, const Solver& solver, ToolId tool,
                     GraspState grasp, std::uint64_t sequence, double time, ContactPatch& patch);

 private:
  friend ContactPacket make_contact_packet(ContactProbe& probe, const Solver& solver, ToolId tool,
                                           GraspState grasp, std::uint64_t sequence, double time);
  struct Data;
  Owned<Data> data_;
};

/// Both halves at once, for a single thread: ContactProbe::collect_patch(), then
/// make_contact_packet() where the step had the tool.
/// @throws InvalidArgument  as collect_patch()
[[nodiscard]] PBDSURG_API ContactPacket make_contact_packet(ContactProbe& probe,
                                                            const Solver& solver, ToolId tool,
                                                            GraspState grasp,
                                                            std::uint64_t sequence, double time);

}  // namespace pbdsurg
