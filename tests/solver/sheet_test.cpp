// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"

#include "bench/sheets/cases.h"
#include "tests/support/catch.h"
#include "tests/support/check_refused.h"
#include "tests/support/fake_device.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/sheet_program.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::check_refused;
using testing::inspect;
using testing::kSheetEdge;
using testing::kUsualStep;
using testing::SheetMesh;

}  // namespace

// Would catch a membrane with other moduli, thickness or mass than its material's, or hinges that
// are no plate, or compressed triangles that hold against wrinkles, by each method.
TEST_CASE("sheet: comes to rest where closed forms say", "[long]") {
  const SolverMethod method = GENERATE(SolverMethod::vertex_block, SolverMethod::projection);
  for (const bench::SheetCase& each : bench::sheet_cases()) {
    const bench::SheetOutcome outcome =
        each.run({.method = method, .executor = executor::threads(1)});
    CAPTURE(each.name, outcome.value, outcome.expected);
    CHECK(std::abs(outcome.value - outcome.expected) < 0.05 * outcome.expected);
  }
}

TEST_CASE("sheet: registers and threads give the serial bits", "[equivalence]") {
  const float damping = GENERATE(0.0F, 2e-3F);
  const Scene scene = testing::make_sheet_scene(damping);
  const int variant = GENERATE(0, 1, 2, 3);
  SolverOptions options =
      testing::small_steps({.substeps = 10, .iterations = 2, .math = MathMode::strict});
  options.composition = PlanComposition::separate;
  switch (variant) {
    case 1:
      options.composition = PlanComposition::nested;
      break;
    case 2:
      options.coloring.max_colors = 5;
      break;
    case 3:
      options.method = SolverMethod::vertex_block;
      break;
  }
  options.executor = executor::serial();
  Solver serial(scene, options);
  const bool has_phase = std::ranges::any_of(
      serial.plan().phases, [](const Phase& phase) { return phase.kind == PhaseKind::membrane; });
  CHECK(has_phase == (options.method == SolverMethod::projection));
  for (int i = 0; i < 20; ++i) {
    REQUIRE(serial.step(kUsualStep).non_finite_vertices == 0);
  }
  for (const int threads : {1, 2, 3}) {
    options.executor = executor::threads(threads);
    Solver threaded(scene, options);
    for (int i = 0; i < 20; ++i) {
      threaded.step(kUsualStep);
    }
    CHECK(threaded.state_hash() == serial.state_hash());
  }
}

// Would catch a shape from which a sheet does not come back, or bursts: each vertex anywhere in a
// ball as large as the sheet.
TEST_CASE("sheet: a crumpled one unfolds and stays finite", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const SheetMesh mesh = testing::make_sheet({6, 6}, kSheetEdge);
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles, {.damping = 1e-3F});
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, {.method = method, .damping = 5, .executor = executor::threads(1)});
  std::vector<Eigen::Vector3f> crumpled;
  for (std::size_t v = 0; v < mesh.positions.size(); ++v) {
    crumpled.emplace_back(static_cast<float>(6 * kSheetEdge * random_unit(7, v, 0)),
                          static_cast<float>(6 * kSheetEdge * random_unit(7, v, 1)),
                          static_cast<float>(6 * kSheetEdge * random_unit(7, v, 2)));
  }
  solver.write_positions(crumpled);
  for (int i = 0; i < 200; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
  }
  const auto x = solver.positions();
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles) {
    area += (x[b] - x[a]).cross(x[c] - x[a]).norm() / 2;
  }
  const double at_rest = 36 * kSheetEdge * kSheetEdge;
  CHECK(area > 0.95 * at_rest);
  CHECK(area < 1.05 * at_rest);
}

// Would catch forces between triangles, or a friction, that move a sheet as a whole: of a free one
// that spins.
TEST_CASE("sheet: a free one keeps its momentum", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const SheetMesh disc = testing::make_disc(4, 3 * kSheetEdge);
  Scene scene;
  scene.add_sheet("disc", disc.positions, disc.triangles, {.damping = 1e-3F});
  scene.set_gravity({0, 0, 0});
  Solver solver(scene, {.method = method, .executor = executor::threads(1)});
  const Eigen::Vector3f spin(1, 2, 5), speed(0.1F, 0, 0.2F);  // rad/s, m/s
  std::vector<Eigen::Vector3f> velocities;
  for (const Eigen::Vector3f& x : solver.positions()) {
    velocities.push_back(speed + spin.cross(x));
  }
  solver.write_velocities(velocities);
  const auto momenta = [&] {
    Eigen::Vector3d linear = Eigen::Vector3d::Zero(), angular = linear;
    const auto x = solver.positions(), v = solver.velocities();
    for (std::size_t i = 0; i < x.size(); ++i) {
      const Eigen::Vector3d impulse = scene.masses()[i] * v[i].cast<double>();
      linear += impulse;
      angular += x[i].cast<double>().cross(impulse);
    }
    return std::pair(linear, angular);
  };
  const auto [linear, angular] = momenta();
  for (int i = 0; i < 40; ++i) {
    solver.step(kUsualStep);
  }
  const auto [linear_now, angular_now] = momenta();
  CHECK((linear_now - linear).norm() < 1e-4 * linear.norm());
  CHECK((angular_now - angular).norm() < 0.03 * angular.norm());
}

// Would catch sweeps of another energy or friction than those which are summed apart from them.
TEST_CASE("sheet: sweeps leave next to no residual", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float damping = GENERATE(0.0F, 1e-3F);
  const SheetMesh mesh = testing::make_sheet({8, 8}, kSheetEdge, 0.2);
  Scene scene;
  scene.add_sheet("sheet", mesh.positions, mesh.triangles,
                  {.youngs_modulus = 20e3F, .damping = damping});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() > 7.5 * kSheetEdge; });
  Solver solver(
      scene,
      {.method = method, .substeps = 20, .iterations = 60, .executor = executor::threads(1)});
  for (int i = 0; i < 4; ++i) {  // it still swings
    solver.step(kUsualStep);
  }
  const Convergence sheet = solver.convergence(kUsualStep)[0];
  CHECK(sheet.vertex_count == 9 * 8);
  CHECK(sheet.residual < 0.01 * sheet.elastic);
}

// Would catch edits that sheets do not follow while they move, and triangles or rows that a
// compaction mixes up: it goes on as one that was not compacted.
TEST_CASE("sheet: rips, loses triangles and is compacted in motion", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const SolverOptions options = testing::small_steps(
      {.method = method, .iterations = 2, .copies = 2, .executor = executor::serial()});
  const Scene scene = testing::make_sheet_scene(1e-3F);
  Solver solver(scene, options);
  for (int i = 0; i < 4; ++i) {
    solver.step(kUsualStep);
  }
  const Tissue& tissue = solver.tissue();
  const Index middle = 12 * 4 + 6;
  TopologyEdit edit{.remove_triangles = {0, 1, 40}, .new_vertices = {{middle, middle, 0}}};
  for (const Index t : tissue.triangles_at(middle)) {
    if (edit.triangle_moves.size() < 2) {
      edit.triangle_moves.push_back({t, middle, tissue.vertex_count()});
    }
  }
  solver.tissue().apply(edit);
  REQUIRE(!tissue.last_change().removed_hinges.empty());
  for (int i = 0; i < 4; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
  }
  CHECK(solver.state_hash(0) == solver.state_hash(1));
  const auto apart = [&] {
    const auto x = solver.positions();
    return (x[middle] - x.back()).norm();
  };
  CHECK(apart() > 1e-6);
  const std::size_t alive = static_cast<std::size_t>(std::ranges::count_if(
      std::vector<Index>{0, 1, 2, 40, 41}, [&](Index t) { return tissue.is_triangle_alive(t); }));
  CHECK(alive == 2);
  const auto numbers = inspect(solver).sets.numbers_of_triangle(41);
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  CHECK(ids.triangles[0] == kInvalidIndex);
  CHECK(inspect(solver).sets.numbers_of_triangle(ids.triangles[41]) == numbers);
  for (int i = 0; i < 4; ++i) {
    REQUIRE(solver.step(kUsualStep).non_finite_vertices == 0);
  }
}

// Would catch fans that leave out a triangle or a pull, or count one twice: of those that edits
// change, of vertices that move to another lane, at rims and where a sheet branches.
TEST_CASE("sheet: fast arithmetic moves it as strict does, through edits", "[unit]") {
  Scene scene = testing::make_sheet_scene();
  const std::vector<Eigen::Vector3d> cross{{0, 0, 0},           {kSheetEdge, 0, 0},
                                           {0, kSheetEdge, 0},  {-kSheetEdge, 0, 0},
                                           {0, -kSheetEdge, 0}, {0, 0, kSheetEdge}};
  const std::vector<Triangle> leaves{{0, 5, 1}, {0, 5, 2}, {0, 5, 3}, {0, 5, 4}};
  scene.add_sheet("cross", cross, leaves, {});
  const auto make = [&](MathMode math) {
    SolverOptions options = testing::vertex_options(2, 4);
    options.executor = executor::threads(1);
    options.math = math;
    return Solver(scene, options);
  };
  Solver strict = make(MathMode::strict), fast = make(MathMode::fast);
  const VertexBlocks& blocks = inspect(fast).vertex_blocks;
  const auto with_fans = [&] {
    return std::ranges::count_if(blocks.arrays().blocks,
                                 [](const VertexBlock& block) { return block.fans.count > 0; });
  };
  CHECK(with_fans() >= 4);
  testing::SheetProgram::begin(strict);
  testing::SheetProgram::begin(fast);
  for (Index round = 0; round < 14; ++round) {
    testing::SheetProgram::act(strict, round);
    testing::SheetProgram::act(fast, round);
    const auto x = strict.positions(), v = strict.velocities();
    for (Solver* const solver : {&strict, &fast}) {  // without what others remember
      solver->write_positions(x);
      solver->write_velocities(v);
    }
    strict.step(testing::SheetProgram::kStep);
    fast.step(testing::SheetProgram::kStep);
    CAPTURE(round);
    REQUIRE(testing::farthest(strict, fast) < 1e-7F);
  }
}

// Would catch triangles or rows that an edit changes and a device does not hear of: it keeps them
// to itself.
TEST_CASE("sheet: a device that hears of edits alone has the serial bits", "[equivalence]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float damping = GENERATE(0.0F, 1e-3F);
  SolverOptions options = testing::small_steps(
      {.method = method, .substeps = 2, .iterations = 2, .copies = 2, .math = MathMode::strict});
  options.composition = PlanComposition::separate;
  const float link = GENERATE(1e-3F, 2e-2F);
  const Scene scene = testing::make_sheet_scene(damping, link);
  options.executor = executor::serial();
  Solver serial(scene, options);
  const bool has_stiff_links = std::ranges::any_of(
      serial.plan().phases, [](const Phase& phase) { return phase.kind == PhaseKind::stiff_link; });
  REQUIRE(has_stiff_links == (method == SolverMethod::vertex_block && link < 0.01F));
  options.executor = testing::fake_device();
  Solver device(scene, options);
  testing::SheetProgram::begin(serial);
  testing::SheetProgram::begin(device);
  Index contacts = 0;
  for (Index round = 0; round < 40; ++round) {
    INFO("round " << round);
    testing::SheetProgram::act(serial, round);
    testing::SheetProgram::act(device, round);
    const StepReport report = serial.step(testing::SheetProgram::kStep);
    device.step(testing::SheetProgram::kStep);
    contacts += report.contacts;
    REQUIRE(report.non_finite_vertices == 0);
    REQUIRE(device.state_hash(0) == serial.state_hash(0));
    REQUIRE(device.state_hash(1) == serial.state_hash(1));
  }
  CHECK(contacts > 0);
}

// Would catch a way of solving that takes sheets and does them wrong.
TEST_CASE("sheet: who cannot step them says so, of scenes and of edits", "[unit]") {
  const SheetMesh mesh = testing::make_sheet({1, 1}, kSheetEdge);
  Scene scene, other;
  scene.add_sheet("wall", mesh.positions, mesh.triangles);
  other.add_body("block", testing::make_box({1, 1, 1}, kSheetEdge), testing::kSprings);
  TopologyEdit edit;
  edit.new_bodies = scene;

  const SolverOptions fraction =
      testing::small_steps({.mode = ProjectionMode::fraction, .executor = executor::serial()});
  check_refused([&] { Solver(scene, fraction); }, "body 'wall' is a sheet, which has moduli");
  Solver by_fractions(other, fraction);
  check_refused([&] { by_fractions.tissue().apply(edit); }, "body 'wall' is a sheet");

  const SolverOptions explicitly{.method = SolverMethod::explicit_steps};
  check_refused([&] { Solver(scene, explicitly); }, "body 'wall' is a sheet, whose frequencies");
}

// Would catch a stiff sheet that steps of a soft body's length shake.
TEST_CASE("sheet: automatic substeps follow its waves", "[unit]") {
  const auto longest = [](float youngs_modulus, double edge) {
    const SheetMesh mesh = testing::make_plate({4, 4}, edge);
    Scene scene;
    scene.add_sheet("sheet", mesh.positions, mesh.triangles, {.youngs_modulus = youngs_modulus});
    return Solver(scene, {.executor = executor::serial()}).plan().longest_substep;
  };
  CHECK(longest(1e6F, kSheetEdge) == testing::Approx(longest(1e5F, kSheetEdge) / std::sqrt(10)));
  CHECK(longest(1e5F, 2 * kSheetEdge) == testing::Approx(2 * longest(1e5F, kSheetEdge)));
  // an equilateral triangle's edge, in plane stress, at 0.95 of the crossing time for one sweep
  const double crossing = kSheetEdge * std::sqrt(1000 * (1 - 0.45 * 0.45) / 1e5);
  CHECK(longest(1e5F, kSheetEdge) == testing::Approx(0.95 * std::sqrt(2) * crossing).epsilon(1e-3));
}

// Would catch phases, groups or rows that a scene pays for without sheets.
TEST_CASE("sheet: a scene without has nothing of them", "[unit]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, kSheetEdge),
                 {.model = ElasticModel::neo_hookean});
  const Solver solver(scene,
                      testing::small_steps({.method = method, .executor = executor::serial()}));
  const SolverData& data = inspect(solver);
  CHECK(data.sets.of<MembraneConstraint>().memory_bytes() == 0);
  CHECK(std::ranges::count(data.sets.phases, PhaseKind::membrane, &Phase::kind) == 0);
  CHECK(data.vertex_blocks.arrays().triangles.empty());
}

}  // namespace pbdsurg
