// SPDX-License-Identifier: Apache-2.0
// Sheets on a device: strict against the serial backend, fast against closed forms.
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "bench/sheets/cases.h"
#include "tests/cuda/strict_pair.h"
#include "tests/support/catch.h"
#include "tests/support/device_strategies.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/sheet_program.h"

namespace pbdsurg {
namespace {

using testing::SheetMesh;
using testing::SheetProgram;
using testing::StrictPair;

constexpr float kStep = SheetProgram::kStep;

// By less, a link between these bodies is stiff, which no cooperative kernel takes.
float link_compliance(DeviceStrategy strategy) {
  return strategy == DeviceStrategy::cooperative ? 2e-2F : 1e-3F;  // m/N
}

}  // namespace

// Would catch triangles that a kernel leaves out or sums in another order, one copy's rows in
// another's place, what removals, rips, undo and new sheets change and nobody sends, and tools that
// hold or push sheets otherwise than on a CPU.
TEST_CASE("cuda sheets: strict has the serial bits by each strategy, through all edits of a sheet",
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
  StrictPair pair(testing::make_sheet_scene(damping, link_compliance(strategy)),
                  {.method = method,
                   .substeps = 2,
                   .iterations = 3,
                   .copies = copies,
                   .spare = {spare, spare, spare, spare}},
                  strategy);
  pair.both([](Solver& solver) { SheetProgram::begin(solver); });
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : pair.serial.positions()) {
    velocities.push_back(Eigen::Vector3f(3, -4, 5).cross(x));
  }
  pair.both([&](Solver& solver) { solver.write_velocities(velocities, copies - 1); });
  for (Index round = 0; round < 40; ++round) {
    INFO("damping " << damping << ", copies " << copies << ", spare " << spare << ", round "
                    << round);
    pair.both([&](Solver& solver) { SheetProgram::act(solver, round); });
    pair.step_and_compare(kStep);
    for (const Index tool : {0, 1}) {
      REQUIRE(pair.device.tool_force(ToolId{tool}) == pair.serial.tool_force(ToolId{tool}));
    }
  }
}

// Would catch a plan whose kernels project no triangles: serial phases, domains, joint phases.
TEST_CASE("cuda sheets: each composition of a plan has the serial bits of a sheet", "[device]") {
  const auto composition =
      GENERATE(PlanComposition::separate, PlanComposition::joint, PlanComposition::nested);
  const int max_colors = GENERATE(0, 5);
  SolverOptions options{.iterations = 2, .composition = composition};
  options.coloring.max_colors = max_colors;
  options.coloring.repair = max_colors == 0;
  StrictPair pair(testing::make_sheet_scene(GENERATE(0.0F, 1e-3F)), options, DeviceStrategy::graph);
  pair.both([](Solver& solver) { SheetProgram::begin(solver); });
  for (Index round = 0; round < 20; ++round) {
    INFO("composition " << static_cast<int>(composition) << ", at most " << max_colors
                        << " colors, round " << round);
    pair.both([&](Solver& solver) { SheetProgram::act(solver, round); });
    pair.step_and_compare(kStep);
  }
}

// Would catch triangles in what BDF2 and a coarse correction do beside sweeps.
TEST_CASE("cuda sheets: BDF2 and a coarse correction have the serial bits of a sheet", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  StrictPair pair(testing::make_sheet_scene(GENERATE(0.0F, 1e-3F), link_compliance(strategy)),
                  {.method = SolverMethod::vertex_block,
                   .substeps = 2,
                   .iterations = 3,
                   .coarse_correction = GENERATE(CoarseCorrection::off, CoarseCorrection::on),
                   .integration = integration},
                  strategy);
  pair.both([](Solver& solver) { SheetProgram::begin(solver); });
  for (Index round = 0; round < 20; ++round) {
    INFO("round " << round);
    pair.both([&](Solver& solver) { SheetProgram::act(solver, round); });
    pair.step_and_compare(kStep);
  }
}

// Would catch a kernel of all substeps that takes a corner of a triangle for one of another
// substep: no tool touches anything here.
TEST_CASE("cuda sheets: steps that one kernel takes have the serial bits of a sheet", "[device]") {
  const Index substeps = GENERATE(1, 2, 5);
  StrictPair pair(testing::make_sheet_scene(0, link_compliance(DeviceStrategy::cooperative)),
                  {.method = SolverMethod::vertex_block,
                   .substeps = substeps,
                   .iterations = GENERATE(1, 3),
                   .coarse_correction = CoarseCorrection::off,
                   .copies = 2},
                  DeviceStrategy::cooperative);
  for (Index round = 0; round < 40; ++round) {
    INFO("substeps " << substeps << ", round " << round);
    pair.both([&](Solver& solver) {
      if (round % 10 == 4) {
        solver.tissue().apply({.remove_triangles = {2 * round, 2 * round + 3}});
      } else if (round % 10 == 7) {
        solver.tissue().apply(testing::rip_vertex(solver, 30 + round));
      } else if (round % 10 == 9) {
        solver.tissue().undo();
      }
    });
    pair.step_and_compare(kStep);
  }
}

// Would catch kernels that were chosen when there were no triangles and go on without them.
TEST_CASE("cuda sheets: the first sheet of a scene comes by an edit, goes by undo and comes again",
          "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const bool has_solid = GENERATE(true, false);
  const bool is_held = GENERATE(true, false);
  if (!testing::suits(strategy, method)) {
    return;
  }
  Scene scene;
  scene.add_body("block", testing::make_box({8, 6, 4}, 4e-3, 0.1),
                 has_solid ? Material{.model = ElasticModel::neo_hookean}
                           : elastic_material(testing::make_box({8, 6, 4}, 4e-3, 0.1), 1000, 20e3));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 2e-3; });
  StrictPair pair(scene, {.method = method, .substeps = 3, .iterations = 2, .copies = 2}, strategy);
  if (is_held) {
    pair.both([](Solver& solver) {
      solver.grasp(solver.add_tool({}, ToolPose::Identity()), std::array<Index, 2>{100, 130},
                   1e-3F);
    });
  }
  const SheetMesh mesh = testing::make_disc(2, 8e-3);
  TopologyEdit with_sheet;
  with_sheet.new_bodies.add_sheet("disc", mesh.positions, mesh.triangles);
  const auto step_some = [&] {
    for (int i = 0; i < 3; ++i) {
      pair.step_and_compare(kStep);
    }
  };
  step_some();
  for (int time = 0; time < 2; ++time) {
    INFO("time " << time);
    pair.both([&](Solver& solver) { solver.tissue().apply(with_sheet); });
    step_some();
    if (time == 0) {
      pair.both([](Solver& solver) { solver.tissue().undo(); });
      step_some();
    }
  }
  pair.both([](Solver& solver) { solver.tissue().apply({.remove_triangles = {0, 5}}); });
  step_some();
}

// Would catch kernels that were chosen when no triangle had a free vertex, and so no row.
TEST_CASE("cuda sheets: a sheet that is let go has the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const SheetMesh mesh = testing::make_sheet({5, 4}, testing::kSheetEdge, 0.2);
  Scene scene;
  scene.add_body("block", testing::make_box({5, 4, 4}, testing::kSheetEdge, 0.1),
                 {.model = ElasticModel::neo_hookean});
  const Index sheet = scene.add_sheet("sheet", mesh.positions, mesh.triangles);
  scene.fix_where(sheet, [](const Eigen::Vector3d&) { return true; });
  StrictPair pair(scene, {.method = method, .substeps = 2, .iterations = 2}, strategy);
  TopologyEdit let_go;
  for (Index v = 0; v < static_cast<Index>(mesh.positions.size()); ++v) {
    if (v % 6 > 0) {  // held at one side still
      let_go.unfix_vertices.push_back(scene.body(sheet).first_vertex + v);
    }
  }
  const auto step_some = [&] {
    for (int i = 0; i < 3; ++i) {
      pair.step_and_compare(kStep);
    }
  };
  step_some();
  for (int time = 0; time < 2; ++time) {
    INFO("time " << time);
    pair.both([&](Solver& solver) { solver.tissue().apply(let_go); });
    step_some();
    if (time == 0) {
      pair.both([](Solver& solver) { solver.tissue().undo(); });
      step_some();
    }
  }
  CHECK(pair.serial.positions().back().y() < mesh.positions.back().y() - 1e-6);
}

// Would catch triangles or their numbers that a compaction mixes up on a device.
TEST_CASE("cuda sheets: a compaction of a ripped sheet has the serial bits", "[device]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  StrictPair pair(testing::make_sheet_scene(1e-3F),
                  {.method = method, .substeps = 2, .iterations = 2, .copies = 2},
                  DeviceStrategy::automatic);
  pair.both([](Solver& solver) { SheetProgram::begin(solver); });
  for (Index round = 0; round < 24; ++round) {
    INFO("round " << round);
    pair.both([&](Solver& solver) {
      if (round % 8 == 3) {
        Compaction compaction(solver);
        compaction.build();
        static_cast<void>(compaction.finish(solver));
      } else if (round % 8 != 0 && round % 8 != 7) {  // the edit before cannot be taken back
        SheetProgram::act(solver, round);
      }
    });
    pair.step_and_compare(kStep);
  }
}

// Would catch rows that lead to what is lost and take a sheet along.
TEST_CASE("cuda sheets: beside a lost vertex a sheet has the serial bits", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::graph, DeviceStrategy::cooperative);
  StrictPair pair(testing::make_sheet_scene(GENERATE(0.0F, 1e-3F), link_compliance(strategy)),
                  {.method = SolverMethod::vertex_block, .substeps = 2, .iterations = 2}, strategy);
  std::vector<Eigen::Vector3f> positions = pair.serial.positions();
  positions[40].setConstant(1e18F);
  pair.both([&](Solver& solver) { solver.write_positions(positions); });
  for (int i = 0; i < 4; ++i) {
    pair.step_and_compare(kStep);
  }
  CHECK(pair.serial.positions()[41].norm() < 1);
}

// Would catch what fast kernels of triangles do otherwise than strict ones, beyond rounding.
TEST_CASE("cuda sheets: a fast sheet has the same bits in every run, close to strict", "[device]") {
  const auto strategy = GENERATE(DeviceStrategy::stream, DeviceStrategy::graph,
                                 DeviceStrategy::cluster, DeviceStrategy::cooperative);
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  if (!testing::suits(strategy, method)) {
    return;
  }
  const Scene scene = testing::make_sheet_scene(GENERATE(0.0F, 1e-3F), link_compliance(strategy));
  SolverOptions options{.method = method,
                        .substeps = 10,
                        .iterations = 2,
                        .damping = 5,
                        .executor = cuda::device(),
                        .math = MathMode::strict,
                        .device_strategy = strategy,
                        .composition = PlanComposition::separate};
  Solver strict(scene, options);
  options.math = MathMode::fast;
  Solver fast(scene, options), again(scene, options);
  for (int i = 0; i < 5; ++i) {
    for (Solver* const solver : {&strict, &fast, &again}) {
      solver->step(kStep);
    }
  }
  CHECK(again.state_hash() == fast.state_hash());
  const auto of_strict = strict.positions(), of_fast = fast.positions();
  float apart = 0;
  for (std::size_t v = 0; v < of_strict.size(); ++v) {
    apart = std::max(apart, (of_strict[v] - of_fast[v]).norm());
  }
  INFO(fast.backend_name());
  CHECK(apart < 1e-3 * testing::kSheetEdge);
}

// Would catch fast kernels that settle elsewhere: other moduli, or rows that are left out where all
// vertices have some.
TEST_CASE("cuda sheets: a fast sheet comes to rest where closed forms say", "[device]") {
  const auto method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  for (const bench::SheetCase& each : bench::sheet_cases()) {
    const bench::SheetOutcome outcome = each.run({.method = method, .executor = cuda::device()});
    CAPTURE(each.name, outcome.value, outcome.expected);
    CHECK(std::abs(outcome.value - outcome.expected) < 0.05 * outcome.expected);
  }
}

}  // namespace pbdsurg
