// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// A solver without what is dead in it, made while it goes on.

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/export.h"
#include "pbdsurg/base/owned.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/renumbering.h"

namespace pbdsurg {

/// Gives a solver new ids, memory and colours, as if it were made of what lives in it: after many
/// edits ids of the dead take room, what was added lies behind, and colours are more than need be.
///
///     Compaction compaction(solver);                      // between two steps
///     std::future<void> built =                           // meanwhile the solver steps
///         std::async(std::launch::async, [&] { compaction.build(); });
///     ...
///     built.get();                                        // what build() throws comes here
///     const Renumbering ids = compaction.finish(solver);  // between two steps, nothing edited
///     since
///
/// All that moves goes over: positions, velocities, tools, what they hold, what is watched, of all
/// copies; so do rest values, masses and options as they are. Steps then do the same in another
/// order of constraints. The edit before cannot be taken back any more, and snapshots from before
/// are of another topology.
///
/// All that follows the tissue gets the new ids in finish(): heat, water and all sums go on to the
/// bit; slots of surfaces, pieces and strands keep their numbers. What an application keeps by ids
/// without being a Follower, it maps.
class PBDSURG_API Compaction {
 public:
  /// Copies what lives, and how near it lies in the first copy.
  /// Cost: O(all that there ever was), of memory bandwidth.
  explicit Compaction(const Solver& solver);
  ~Compaction();
  /// Takes over. The other can then only be destroyed or assigned to.
  Compaction(Compaction&&) noexcept;
  Compaction& operator=(Compaction&&) noexcept;  ///< likewise

  /// Colours and plans, in any thread; the solver may step, be read, written and edited meanwhile.
  /// Of a solver on a CUDA device, on that device.
  /// Cost: that of making a solver.
  /// @throws Error  if the device fails or has no room for it; then nothing is built
  void build();

  /// Puts what was built in the place of what the solver has; that is freed with this object.
  /// Cost: O(V) per copy, to move the state.
  /// @throws InvalidArgument  if nothing is built, it is used already, the solver is another or its
  ///                          topology has changed since, a vertex without tissue is watched, or
  ///                          another solver follows the tissue; then nothing has changed
  Renumbering finish(Solver& solver);

 private:
  struct Parts;
  Owned<Parts> parts_;
};

}  // namespace pbdsurg
