// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// What a state of a world holds, in memory.

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

#include "pbdsurg/world/world_state.h"

#include "lib/solver/solver_copy.h"
#include "lib/tissue/tissue_data.h"
#include "lib/world/world_data.h"

namespace pbdsurg {

/// Tissue and solver as they were when recording began.
struct World::Origin {
  SolverOptions options;  ///< of the solver, nothing automatic, with the world's executor
  std::unique_ptr<const TissueData> tissue;
  SolverCopy solver;
  std::size_t bytes;
  /// Where the first recording began, if that was before any edit and no compaction came since;
  /// else null.
  std::shared_ptr<const Scene> scene;
  EditJournal::Edits edits_of_scene;  ///< that made this tissue of that scene

  /// Cost: O(all that there ever was), of memory bandwidth.
  [[nodiscard]] static std::shared_ptr<const Origin> of(const Executor& executor,
                                                        const Solver& solver,
                                                        std::shared_ptr<const Scene> scene,
                                                        EditJournal::Edits edits_of_scene);
};

/// A cautery and its generator.
struct BurnerState {
  BurnerSetup setup;
  std::optional<GeneratorSettings> settings;
  CauterySnapshot cautery;
};

struct WorldState::Data {
  std::shared_ptr<const World::Origin> origin;
  EditJournal::Edits edits;
  ConnectiveTissue strands;
  BodyTable bodies;
  std::vector<BurnerState> burners;
  SolverMotion motion;
};

}  // namespace pbdsurg
