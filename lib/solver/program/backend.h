// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What executes a step plan.

#include <Eigen/Core>
#include <cstddef>
#include <functional>
#include <memory>
#include <span>

#include "pbdsurg/base/export.h"
#include "pbdsurg/base/types.h"
#include "pbdsurg/solver/step_report.h"

#include "lib/solver/state/particle.h"

namespace pbdsurg {

class SolverData;
struct SolverState;

/// One coarse call a step: nothing virtual happens per constraint.
///
/// A backend either works on the arrays of SolverData, or keeps the state elsewhere, on a device.
/// Both step all copies. For the latter, the solver sees to this:
/// - SolverData::changes says what happened since its last step, or since it was made from the
///   data. start_step() takes that over; the solver clears it when start_step() has returned.
/// - From start_step() on, particles, velocities and carries of SolverData are out of date, until
///   fetch_state() or until the host rewrites them all, but for those of Changes::moved. Inverse
///   masses there are always valid.
/// - Between start_step() and finish_step() none of its functions is called but name(),
///   keeps_state(), memory_bytes(), ask_for_motion(), follow_edit() and the destructor.
/// - Edits that bring no vertices happen there, too: topology, constraints, masses, vertex blocks,
///   the plan and what tools hold may change under a running step, which has taken over what it
///   needs; `changes` is then that of the next. What stays is the state, which and how many tools
///   there are, their poses, and what is watched.
class PBDSURG_API Backend {
 public:
  virtual ~Backend() = default;

  /// Who it is, for example "cuda, NVIDIA H200, graph, fast".
  [[nodiscard]] virtual const char* name() const noexcept = 0;

  /// Begins a step, and waits for all parts of it but the last; may return before that is done. If
  /// it throws, what it keeps elsewhere may be part of a step on.
  /// @param data  whose `part` is the first of the step; go_on() makes it the next, until it is
  ///              the last
  virtual void start_step(SolverData& data) = 0;

  /// Of explicit steps, before a step, or between parts of one on a host: the largest
  /// stiffest_vertex() of the copies.
  [[nodiscard]] virtual float stiffest(SolverData& data);

  /// Waits for the step and ends it: poses and forces of tools are then those after it. Called once
  /// after each start_step(). Writes `last_report` of all copies; one that keeps the state also
  /// writes `watched_positions`.
  virtual StepReport finish_step(SolverState& state) = 0;

  /// Called after each edit: a chance to prepare, while a step runs, what start_step() would do for
  /// it later. May empty the lists of constraints and tetrahedra in SolverData::changes.
  virtual void follow_edit(SolverData& /*data*/) noexcept {}

  /// Whether the state lies outside of SolverData. Always the same answer.
  [[nodiscard]] virtual bool keeps_state() const noexcept { return false; }

  /// Brings positions, velocities and carries of a copy as the last step left them into
  /// SolverData: at all places that there were in it and still are. Inverse masses there stay: an
  /// edit may have changed them since.
  virtual void fetch_state(SolverState& /*state*/, Index /*copy*/) {}

  /// Reads some positions of a copy as the last step left them; called only while those of
  /// SolverData are out of date.
  /// @param places  [n] see SolverData; of vertices that were in that step
  /// @param out     [n] m
  virtual void read_positions(const SolverState& /*state*/, Index /*copy*/,
                              std::span<const Index> /*places*/,
                              std::span<Eigen::Vector3f> /*out*/) {}

  /// Begins to read how some vertices of all copies move, as the last step begun leaves them; may
  /// return before that step is done. One such read is kept, the last.
  /// @param places  [n] see SolverData; of vertices that were in that step
  virtual void ask_for_motion(std::span<const Index> /*places*/) {}

  /// What was asked for, of a copy.
  /// @param out  [n]
  virtual void collect_motion(Index /*copy*/, std::span<VertexMotion> /*out*/) {}

  /// @param data  with all that a solver has, but a backend
  using Maker = std::function<std::unique_ptr<Backend>(const SolverData& data)>;

  /// Makes backends like this one, on its device, in any thread, and also once this one is gone.
  [[nodiscard]] virtual Maker maker() const = 0;

  /// Whether it projects a Filling, where the state lies elsewhere.
  [[nodiscard]] virtual bool takes_fillings() const noexcept { return false; }

  /// Bytes that it holds, on a device or here, beside SolverData.
  [[nodiscard]] virtual std::size_t memory_bytes() const noexcept { return 0; }
};

}  // namespace pbdsurg
