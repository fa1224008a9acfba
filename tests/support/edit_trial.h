// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Random edits of small scenes, good and bad, and what must hold after them: for tests and for
/// fuzzers.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "pbdsurg/edit/live_pieces.h"
#include "pbdsurg/edit/live_surface.h"
#include "pbdsurg/edit/topology_edit.h"
#include "pbdsurg/solver/scene.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/thermal/heat_field.h"

#include "support/live_model.h"

namespace pbdsurg::testing {

/// Choices made by bytes: those of a fuzzer, or random ones.
class Choices {
 public:
  /// @param bytes  must outlive this; zeros follow them
  explicit Choices(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  /// In [0, count). @param count  in [1, 65536]
  Index below(Index count);

  /// Whether no bytes are left.
  [[nodiscard]] bool is_spent() const { return next_ >= bytes_.size(); }

 private:
  std::span<const std::uint8_t> bytes_;
  std::size_t next_ = 0;
};

[[nodiscard]] std::vector<std::uint8_t> random_bytes(std::uint64_t seed, std::size_t count);

/// A scene to be edited.
struct EditScene {
  std::string name;
  Scene scene;
  TetMesh first_mesh;  ///< of body 0
};

/// Few tetrahedra each, so that thousands of trials take seconds: a lattice, a mesh of vertices
/// with many or few neighbours, an organ, bodies with and without volumes joined by links, solids
/// and a thread of particles. Built once.
[[nodiscard]] const std::vector<EditScene>& edit_scenes();

/// Ways of solving that a scene allows, one for each way in which constraints are kept.
[[nodiscard]] std::vector<SolverOptions> edit_options(const EditScene& scene);

/// A solver, all that follows its edits, and their model.
class EditTrial {
 public:
  EditTrial(const EditScene& scene, const SolverOptions& options);

  /// @param change  a good one
  void edit(const TopologyEdit& change);
  void edit(Choices& choices) { edit(make_edit(choices)); }

  /// Makes a good edit and takes it back, with or without a step in between.
  /// @return  what went wrong; empty if, without a step, all bits are those of before
  [[nodiscard]] std::string edit_and_undo(Choices& choices);

  /// Tries a bad edit: a good one with something in it that must be refused.
  /// @return  what went wrong; empty if it was refused and nothing changed
  [[nodiscard]] std::string try_bad_edit(Choices& choices);

  /// @return  what went wrong; empty if the state is finite
  [[nodiscard]] std::string step();

  /// @return  what differs from the model; empty if nothing does
  [[nodiscard]] std::string difference() const;

  [[nodiscard]] const Solver& solver() const { return solver_; }

 private:
  [[nodiscard]] std::vector<EditParticipant*> participants();
  [[nodiscard]] TopologyEdit make_edit(Choices& choices) const;
  void add_removals(Choices& choices, TopologyEdit& edit) const;
  void add_rest_values(Choices& choices, TopologyEdit& edit) const;
  void remove_body(Choices& choices, TopologyEdit& edit) const;
  void spoil(Choices& choices, TopologyEdit& edit) const;

  const EditScene* scene_;
  Solver solver_;
  HeatField heat_;
  std::vector<LiveSurface> surfaces_;  // [body]
  LivePieces pieces_;
  LiveModel model_;
};

/// A trial of edits, good and bad, and steps between them, until the bytes are spent.
/// @return  what went wrong; empty if nothing did
[[nodiscard]] std::string run_edit_trial(std::span<const std::uint8_t> bytes);

/// The bytes of one trial of many: a few edits.
[[nodiscard]] std::vector<std::uint8_t> bytes_of_trial(std::uint64_t seed);

}  // namespace pbdsurg::testing
