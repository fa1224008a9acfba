// SPDX-License-Identifier: Apache-2.0
// Fibres on a device: strict against the serial backend, fast against strict.
#include "pbdsurg/cuda/device.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/device_strategies.h"
#include "tests/support/fibre_program.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::FibreProgram;
using testing::kSoftEdge;
using testing::StrictPair;

constexpr float kStep = FibreProgram::kStep;

}  // namespace

// Would catch fibres that a kernel leaves out or adds in another order, records and rows that edits
// of fibres, of tissue or their undo change and nobody sends, and one copy's state in another's
// place.
TEST_CASE("cuda fibres: strict has the serial bits by each strategy, through edits and undo",
          "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float damping = GENERATE(0.0F, 1e-3F);
  const Index copies = GENERATE(1, 3);
  const Index spare = GENERATE(0, 200);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const Scene scene = testing::make_fibred_scene(damping);
  StrictPair pair(scene,
                  {.method = method,
                   .substeps = 2,
                   .iterations = 3,
                   .copies = copies,
                   .spare = {spare, spare, spare, spare}},
                  strategy);
  pair.both([&](Solver& solver) { FibreProgram::begin(solver, scene); });
  for (Index round = 0; round < 32; ++round) {
    INFO("damping " << damping << ", copies " << copies << ", spare " << spare << ", round "
                    << round);
    pair.both([&](Solver& solver) { FibreProgram::act(solver, round); });
    pair.step_and_compare(kStep);
    for (const Index tool : {0, 1}) {
      REQUIRE(pair.device.tool_force(ToolId{tool}) == pair.serial.tool_force(ToolId{tool}));
    }
  }
}

// Would catch explicit kernels without fibres, with tools, which have kernels of their own, and
// without.
TEST_CASE("cuda fibres: explicit steps have the serial bits", "[device]") {
  const auto strategy =
      GENERATE(DeviceStrategy::stream, DeviceStrategy::graph, DeviceStrategy::cooperative);
  const bool has_tools = GENERATE(false, true);
  const Scene scene = testing::make_fibred_scene(0);
  StrictPair pair(scene, {.method = SolverMethod::explicit_steps, .damping = 2, .copies = 2},
                  strategy);
  pair.both([&](Solver& solver) {
    if (has_tools) {
      FibreProgram::begin(solver, scene);
    } else {
      solver.write_positions(testing::stretched(scene, 1.1F), 1);
    }
  });
  for (Index round = 0; round < 24; ++round) {
    INFO("tools " << has_tools << ", round " << round);
    pair.both([&](Solver& solver) { FibreProgram::act(solver, round); });
    pair.step_and_compare(kStep);
  }
}

// Would catch a plan whose kernels project no fibres: serial phases, domains.
TEST_CASE("cuda fibres: each composition of a plan has the serial bits", "[device]") {
  const auto composition =
      GENERATE(PlanComposition::separate, PlanComposition::joint, PlanComposition::nested);
  const int max_colors = GENERATE(0, 5);
  SolverOptions options{.iterations = 2, .composition = composition};
  options.coloring.max_colors = max_colors;
  options.coloring.repair = max_colors == 0;
  const Scene scene = testing::make_fibred_scene(GENERATE(0.0F, 1e-3F));
  StrictPair pair(scene, options, DeviceStrategy::graph);
  pair.both([&](Solver& solver) { FibreProgram::begin(solver, scene); });
  for (Index round = 0; round < 16; ++round) {
    INFO("composition " << static_cast<int>(composition) << ", at most " << max_colors
                        << " colors, round " << round);
    pair.both([&](Solver& solver) { FibreProgram::act(solver, round); });
    pair.step_and_compare(kStep);
  }
}

// Would catch residuals of a coarse correction without fibres, by rows or by tiles.
TEST_CASE("cuda fibres: BDF2 and a coarse correction have the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const Scene scene = testing::make_fibred_scene(GENERATE(0.0F, 1e-3F));
  StrictPair pair(scene,
                  {.method = SolverMethod::vertex_block,
                   .substeps = 2,
                   .iterations = 3,
                   .coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on),
                   .integration = integration},
                  strategy);
  pair.both([&](Solver& solver) { FibreProgram::begin(solver, scene); });
  for (Index round = 0; round < 16; ++round) {
    INFO("round " << round);
    pair.both([&](Solver& solver) { FibreProgram::act(solver, round); });
    pair.step_and_compare(kStep);
  }
}

// Would catch kernels and records that were chosen when nothing had fibres, by an edit that gives
// them to tissue and by one that brings tissue with them.
TEST_CASE("cuda fibres: the first fibres of a scene have the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method =
      GENERATE(SolverMethod::projection, SolverMethod::vertex_block, SolverMethod::explicit_steps);
  const bool brings_body = GENERATE(false, true);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const Scene scene = testing::make_fibreless_scene(0);
  SolverOptions options{.method = method, .copies = 2};
  if (method != SolverMethod::explicit_steps) {
    options.substeps = 3;
    options.iterations = 2;
  }
  StrictPair pair(scene, options, strategy);
  pair.both([&](Solver& solver) { solver.write_positions(testing::stretched(scene, 1.1F), 1); });
  TopologyEdit bring = brings_body ? FibreProgram::guest(0) : TopologyEdit{}, take;
  for (Index t = 0; t < scene.body(0).tet_count && !brings_body; ++t) {
    bring.fibres.push_back({t, testing::fibre_of(t)});
    take.fibres.push_back({t, {}});
  }
  const auto step_some = [&] {
    for (int i = 0; i < 3; ++i) {
      pair.step_and_compare(kStep);
    }
  };
  step_some();
  for (int time = 0; time < 2; ++time) {
    INFO("time " << time);
    pair.both([&](Solver& solver) { solver.tissue().apply(bring); });
    step_some();
    if (time == 0) {
      pair.both([](Solver& solver) { solver.tissue().undo(); });
      step_some();
    }
  }
  if (!brings_body) {
    pair.both([&](Solver& solver) { solver.tissue().apply(take); });
    step_some();
  }
}

// Would catch fibres or their numbers that a compaction mixes up on a device.
TEST_CASE("cuda fibres: a compaction has the serial bits", "[device]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Scene scene = testing::make_fibred_scene(1e-3F);
  StrictPair pair(scene, {.method = method, .substeps = 2, .iterations = 2, .copies = 2},
                  DeviceStrategy::automatic);
  pair.both([&](Solver& solver) { FibreProgram::begin(solver, scene); });
  for (Index round = 1; round < 20; ++round) {
    INFO("round " << round);
    pair.both([&](Solver& solver) {
      if (round % 8 == 3) {  // the edit before cannot be taken back
        Compaction compaction(solver);
        compaction.build();
        static_cast<void>(compaction.finish(solver));
      } else {
        FibreProgram::act(solver, round);
      }
    });
    pair.step_and_compare(kStep);
  }
}

// Would catch what fast kernels of fibres do otherwise than strict ones, beyond rounding.
TEST_CASE("cuda fibres: fast steps have the same bits in every run, close to strict", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method =
      GENERATE(SolverMethod::projection, SolverMethod::vertex_block, SolverMethod::explicit_steps);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const Scene scene = testing::make_fibred_scene(0);
  SolverOptions options{.method = method,
                        .damping = 5,
                        .executor = cuda::device(),
                        .math = MathMode::strict,
                        .device_strategy = strategy};
  if (method != SolverMethod::explicit_steps) {
    options.substeps = 10;
    options.iterations = 2;
    options.composition = PlanComposition::separate;
  }
  Solver strict(scene, options), without(testing::make_fibreless_scene(0), options);
  options.math = MathMode::fast;
  Solver fast(scene, options), again(scene, options);
  for (Solver* const solver : {&strict, &without, &fast, &again}) {
    solver->write_positions(testing::stretched(scene, 1.1F));
    testing::run(*solver, 5, kStep);
  }
  INFO(fast.backend_name());
  CHECK(again.state_hash() == fast.state_hash());
  constexpr auto kEdge = static_cast<float>(kSoftEdge);
  REQUIRE(testing::farthest(strict, without) > 0.1F * kEdge);
  CHECK(testing::farthest(strict, fast) < 1e-3F * kEdge);
}

}  // namespace pbdsurg
