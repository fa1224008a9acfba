// SPDX-License-Identifier: Apache-2.0
#pragma once

/// @file
/// Programs that together do all that the library does to tissue.

#include <functional>
#include <string>
#include <vector>

#include "pbdsurg/solver/solver.h"

#include "tests/regression/driver.h"

namespace pbdsurg::testing {

/// A program to be run by any executor.
struct Program {
  std::string name;
  std::function<void(const Executor&, Record&)> run;
};

/// Every plan, method and material under tools, writes, edits and undo; with copies; edits within
/// steps; compaction.
[[nodiscard]] std::vector<Program> mechanics_programs();

/// Bodies that meet each other, shafts and jaws, by every method and with copies; edits, undo and
/// compaction in contact.
[[nodiscard]] std::vector<Program> contact_programs();

/// Random edits of all kinds and cuts, taken back in between, with all that follows them.
[[nodiscard]] std::vector<Program> edit_programs();

/// Cuts, strands that part, burns, with all that follows them, undo and compaction.
[[nodiscard]] std::vector<Program> surgery_programs();

/// Two sweeps in strict order, as most programs here want them.
/// @param composition  named, so that all executors have the same plan
[[nodiscard]] inline SolverOptions plain_options(PlanComposition composition) {
  return {.method = SolverMethod::projection,
          .substeps = 2,
          .iterations = 2,
          .damping = 20,
          .composition = composition};
}

}  // namespace pbdsurg::testing
