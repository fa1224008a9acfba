// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random edits of small scenes, good and bad, and what must hold after them: for tests and for
/// fuzzers.

#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cautery.h"
#include "pbdsurg/surgery/connective_tissue.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"
#include "pbdsurg/views/live_surface.h"

#include "examples/tether/tethers.h"
#include "tests/support/choices.h"
#include "tests/support/edit_scenes.h"
#include "tests/support/live_model.h"
#include "tests/support/random_touches.h"

namespace pbdsurg::testing {

/// A solver, all that follows its tissue, and their model. Edits come between steps or within them.
/// A twin may take part, a serial solver that steps at once, so that its edits come after the step:
/// both must have the same bits.
class EditTrial {
 public:
  /// @param options   with a twin: strict, with the composition named
  /// @param has_twin  always there beside another backend than the serial one
  EditTrial(const EditScene& scene, const SolverOptions& options, bool has_twin = false);

  /// @param change  a good one
  void edit(const TopologyEdit& change);
  void edit(Choices& choices);

  /// Makes a good edit and takes it back, with or without a step in between, or the end of the one
  /// that runs.
  /// @return  what went wrong; empty if, without a step, all bits are those of before
  [[nodiscard]] std::string edit_and_undo(const TopologyEdit& change, bool steps = false);
  [[nodiscard]] std::string edit_and_undo(Choices& choices);

  /// Tries a bad edit: a good one with something in it that must be refused, or one that a follower
  /// refuses.
  /// @return  what went wrong; empty if it was refused and nothing changed
  [[nodiscard]] std::string try_bad_edit(Choices& choices);

  /// Why the last bad edit was refused.
  [[nodiscard]] const std::string& refusal() const { return refusal_; }

  /// Sets forces, or gravity, or takes forces away.
  void load(Choices& choices);

  /// Adds tethers, or takes them away: on a CPU, by a method that has sweeps.
  void tether(Choices& choices);

  /// Changes what touches what.
  void touch(Choices& choices);

  /// Begins a step, within which edits come until step().
  void start_step();
  [[nodiscard]] bool is_stepping() const { return is_stepping_; }

  /// Makes a step, or ends the one that runs.
  /// @return  what went wrong; empty if the state is finite, and all that the twin has
  [[nodiscard]] std::string step();

  /// @return  what differs from the model; empty if nothing does
  [[nodiscard]] std::string difference() const;

  [[nodiscard]] const Solver& solver() const { return solver_; }

 private:
  struct Change {
    TopologyEdit edit;
    CutFront front;
  };
  void add_surfaces();
  void begin_step();
  [[nodiscard]] Change make_change(Choices& choices);
  void apply(const TopologyEdit& change);

  Solver solver_;
  std::optional<Solver> twin_;
  StepReport twin_report_;
  bool is_stepping_ = false;
  std::shared_ptr<Tethers> tethers_, twin_tethers_;
  RandomTouches touches_;
  Cautery cautery_;
  ConnectiveTissue strands_;
  std::vector<LiveSurface> surfaces_;  // [body]
  LivePieces pieces_;
  LiveModel model_;
  CutFront front_;  // of the last edit
  std::string refusal_;
};

/// A trial of edits, good and bad, between steps and within them, until the bytes are spent.
/// @param backend  who steps, with a twin; of the serial backend some trials have one; the strategy
///                 of a device is chosen by the bytes
/// @param has_touches  whether the backend knows contact with surfaces
/// @return             what went wrong; empty if nothing did
[[nodiscard]] std::string run_edit_trial(std::span<const std::uint8_t> bytes,
                                         const Executor& executor, bool has_touches = true);

/// The bytes of one trial of many: a few edits.
[[nodiscard]] std::vector<std::uint8_t> bytes_of_trial(std::uint64_t seed);

}  // namespace pbdsurg::testing
