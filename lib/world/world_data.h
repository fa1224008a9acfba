// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a world owns, for the calls of its users and for its steps.

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "pbdsurg/world/world.h"

#include "lib/world/body_table.h"
#include "lib/world/edit_journal.h"

namespace pbdsurg {

/// What a burner is made of.
struct BurnerSetup {
  ToolId tool;
  std::vector<BodyId> bodies;
  Electrode electrode;  // in the tool's frame
  CauteryOptions options;
  // When it came, and which bodies of the tissue it burns, by their numbers then.
  struct Arrival {
    std::size_t edits_before;
    std::vector<ThermalBody> burnt;
  };
  Arrival since_record;  // or as if it had come with that
  Arrival since_scene;   // since the first recording, see World::Origin::scene
};

/// Who works for heat that names nobody: who steps, but for a device in strict mode, as its heat
/// has other bits than a host's.
/// @param stepping  of the solver's options
[[nodiscard]] Executor heat_executor(MathMode math, const Executor& stepping);

/// A generator at a tool, and what it burns.
struct Burner {
  BurnerSetup setup;
  std::optional<GeneratorSettings> settings;
  Cautery cautery;
};

/// What one source asks for.
struct EditRequest {
  EditSource source;
  TopologyEdit edit;
  Index burner = kInvalidIndex;  // of heat
};

/// An edit of the program, for the topology that there was.
struct ProgramEdit {
  TopologyEdit edit;
  std::uint64_t version;
};

/// The parts of a world, and what is asked of its next step.
struct World::Data {
  static constexpr const char* kWho = "a world";

  explicit Data(const SolverOptions& wanted) : options(wanted) {}

  // Before the solver is made.
  SolverOptions options;
  Scene scene;

  ConnectiveTissue strands;
  BodyTable bodies;
  std::unique_ptr<Tissue> tissue;
  std::unique_ptr<Solver> solver;
  std::vector<std::unique_ptr<Burner>> burners;
  std::map<Index, std::unique_ptr<Surface>> surfaces;  // by body id
  std::unique_ptr<LivePieces> pieces;

  // of save(), from record() on
  std::shared_ptr<const Origin> origin;
  std::unique_ptr<EditJournal> journal;

  // for the next step
  std::vector<ProgramEdit> edits;
  std::vector<BodyId> leaving;
  Scene new_bodies;
  std::vector<BladeSweep> blades;

  /// Adds a body to the scene, or to what comes with the next step.
  /// @param add_to  Index(Scene&)
  template <class AddTo>
  BodyId add(const std::string& name, const TissueRecord& tissue, const AddTo& add_to);

  void make_solver();
  void follow_tissue();
  void add_burner(const BurnerSetup& setup);
  void check_is_scene(const char* what) const;
  [[nodiscard]] Solver& solver_of(ToolId tool) const;
  [[nodiscard]] Burner& burner(CauteryId cautery) const;
  [[nodiscard]] const HeatField* heat_of(BodyId body) const;
  void refresh();

  // the parts of a step, see world_step.cpp
  void heat(double dt, Frame& frame, std::vector<EditRequest>& requests);
  std::vector<EditRequest> collect(double dt, Frame& frame);
  void collect_program(Frame& frame, std::vector<EditRequest>& requests);
  void change(std::vector<EditRequest>& requests, std::span<const BladeSweep> swept, Frame& frame);
  bool apply_all(const std::vector<EditRequest>& requests, Frame& frame);
  void apply_each(std::vector<EditRequest>& requests, std::span<const BladeSweep> swept,
                  Frame& frame);
  const TissueChange& apply(const TopologyEdit& edit, Frame& frame);
  void commit(const EditRequest& request, Frame& frame);
};

}  // namespace pbdsurg
