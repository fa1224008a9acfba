// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/program/step_program.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "tests/support/catch.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

// -1 if it is not there
std::ptrdiff_t place_of(const StepProgram& program, StepOperation operation) {
  const auto found = std::ranges::find(program.operations, operation);
  return found == program.operations.end() ? -1 : found - program.operations.begin();
}

}  // namespace

// Would catch an executor's loop that leaves out a substep or runs operations out of order.
TEST_CASE("step program: runs its operations in order, once a substep", "[unit]") {
  const StepProgram program = step_program({}, {3, 1});
  std::vector<std::pair<StepOperation, int>> run, expected;
  run_step(program, [&](StepOperation operation, int substep) {
    run.push_back({operation, substep});
  });
  for (int substep = 0; substep < 3; ++substep) {
    for (const StepOperation operation : program.operations) {
      expected.push_back({operation, substep});
    }
  }
  CHECK(run == expected);
  CHECK(!run.empty());
}

// Would catch a method whose sweeps see the contacts, or whose tools feel the forces, of another
// substep.
TEST_CASE("step program: every method predicts, finds contacts, sweeps, then looks back",
          "[unit]") {
  for (const SolverOptions& options :
       {SolverOptions{}, SolverOptions::paper(),
        testing::small_steps({.method = SolverMethod::vertex_block})}) {
    const StepProgram program = step_program(options, {options.substeps, options.iterations});
    CHECK(program.division.substeps == options.substeps);
    const bool displaces = options.mode == ProjectionMode::compliance;
    CHECK(program.operations.front() ==
          (displaces ? StepOperation::predict_displacements : StepOperation::predict_positions));
    CHECK(program.operations.back() ==
          (displaces ? StepOperation::settle : StepOperation::update_velocities));
    CHECK(std::ranges::count(program.operations, StepOperation::sweep) == 1);
    const std::ptrdiff_t contacts = place_of(program, StepOperation::find_contacts);
    const std::ptrdiff_t sweep = place_of(program, StepOperation::sweep);
    CHECK(contacts > 0);
    CHECK(sweep > contacts);
    CHECK(place_of(program, StepOperation::collect_forces) > sweep);
    CHECK(place_of(program, StepOperation::clear_multipliers) < sweep);
  }
}

// Would catch vertices that feel another substep's tools or damping.
TEST_CASE("step program: vertex blocks have their own operations where these belong", "[unit]") {
  const StepProgram program = step_program({.method = SolverMethod::vertex_block}, {1, 1});
  const auto at = [&](StepOperation operation) { return place_of(program, operation); };
  CHECK(at(StepOperation::gather_holds) > at(StepOperation::find_contacts));
  CHECK(at(StepOperation::gather_holds) < at(StepOperation::sweep));
  CHECK(at(StepOperation::damp_rows) > at(StepOperation::predict_displacements));
  CHECK(at(StepOperation::damp_rows) < at(StepOperation::sweep));
}

// Would catch a past that is recalled too late for the prediction, or kept before the end is known.
TEST_CASE("step program: BDF2 recalls its past before all else and keeps it last", "[unit]") {
  for (const SolverMethod method : {SolverMethod::projection, SolverMethod::vertex_block}) {
    SolverOptions options{.method = method};
    const StepProgram usual = step_program(options, {1, 1});
    options.integration = TimeIntegration::bdf2;
    const StepProgram program = step_program(options, {1, 1});
    const std::size_t count = usual.operations.size();
    REQUIRE(program.operations.size() == count + 4);
    CHECK(program.operations[0] == StepOperation::take_lengths);
    CHECK(program.operations[1] == StepOperation::recall_past);
    CHECK(std::ranges::equal(program.operations.subspan(2, count), usual.operations));
    CHECK(program.operations[count + 2] == StepOperation::keep_past);
    CHECK(program.operations.back() == StepOperation::ease_contacts);
  }
}

// Would catch a program that costs a method what only another needs.
TEST_CASE("step program: methods leave out what they have no use for", "[unit]") {
  const auto has = [](const SolverOptions& options, StepOperation operation) {
    return place_of(step_program(options, {options.substeps, options.iterations}), operation) >= 0;
  };
  const SolverOptions compliances = testing::small_steps({.mode = ProjectionMode::compliance});
  const SolverOptions fractions = testing::small_steps({.mode = ProjectionMode::fraction});
  const SolverOptions blocks = testing::small_steps({.method = SolverMethod::vertex_block});
  CHECK(has(compliances, StepOperation::clear_multipliers));
  CHECK_FALSE(has(fractions, StepOperation::clear_multipliers));
  CHECK_FALSE(has(blocks, StepOperation::clear_multipliers));
  for (const StepOperation operation : {StepOperation::gather_holds, StepOperation::damp_rows}) {
    CHECK(has(blocks, operation));
    CHECK_FALSE(has(compliances, operation));
    CHECK_FALSE(has(fractions, operation));
  }
}

}  // namespace pbdsurg
