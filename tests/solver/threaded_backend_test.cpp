// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/instruction_set.h"
#include "tests/support/meshes.h"
#include "tests/support/skip.h"
#include "tests/support/small_steps.h"
#include "tests/support/solver_cases.h"

namespace pbdsurg {
namespace {

using testing::ContainsSubstring;
using testing::kSoftEdge;
using testing::kUsualStep;

// A body with volumes, a tube without, links between them and a strain limit; in compliance mode a
// Neo-Hookean body, too. No array's length is a multiple of a register's.
Scene make_threaded_scene(ProjectionMode mode, float damping) {
  Scene scene;
  const TetMesh block = testing::make_box({5, 4, 3}, kSoftEdge, 0.1);
  const TetMesh tube = testing::make_box({9, 1, 1}, kSoftEdge, 0.1, 2);
  Material soft = elastic_material(block, 1000, 20e3);
  soft.max_stretch = 1.05F;
  soft.damping = damping;
  Material walls = elastic_material(tube, 1000, 20e3);
  walls.has_volume_constraints = false;
  scene.add_body("block", block, soft);
  scene.add_body("tube", tube, walls);
  scene.add_body("solid", testing::make_box({3, 3, 2}, kSoftEdge, 0.1, 3),
                 mode == ProjectionMode::compliance
                     ? Material{.model = ElasticModel::neo_hookean, .damping = damping}
                     : soft);
  for (Index v = 0; v < 12; ++v) {
    scene.add_link({v, scene.body(1).first_vertex + v, 0, {0.5F, 1e-3F}});
    scene.add_link({v, scene.body(2).first_vertex + 3 * v, 0, {0.5F, 1e-3F}});
  }
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  return scene;
}

struct Outcome {
  std::uint64_t hash;
  StepReport report;
  Eigen::Vector3f push, pull;
};

bool operator==(const Outcome& a, const Outcome& b) {
  return a.hash == b.hash && a.report.inverted_tets == b.report.inverted_tets &&
         a.report.contacts == b.report.contacts &&
         a.report.distance_residual == b.report.distance_residual &&
         a.report.volume_residual == b.report.volume_residual && a.push == b.push &&
         a.pull == b.pull;
}

// Stretches the scene, pushes it with one tool, pulls with another, and cuts it on the way.
Outcome run(const Scene& scene, const SolverOptions& options) {
  Solver solver(scene, options);
  std::vector<Eigen::Vector3f> stretched = solver.positions();
  for (Eigen::Vector3f& x : stretched) {
    x.x() *= 1.1F;
  }
  solver.write_positions(stretched);
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.017F, 0.006F);
  const ToolId pusher = solver.add_tool({&capsule, 1}, pose);
  const ToolId puller = solver.add_tool({}, ToolPose::Identity());
  const Index corner = scene.body(0).vertex_count - 1;
  solver.grasp(puller, std::array{corner, Index{corner - 1}}, 1e-4F);
  StepReport report;
  for (int i = 0; i < 4; ++i) {
    if (i == 2) {
      solver.tissue().apply({.remove_tets = {7, 8, 9, 30, 31, 100, 200}});
    }
    pose.translation().y() -= 5e-4F;
    solver.move_tool(pusher, pose);
    report = solver.step(kUsualStep);
  }
  return {solver.state_hash(), report, solver.tool_force(pusher), solver.tool_force(puller)};
}

// Strict has the serial bits, fast one's own, on any number of threads.
void check_lanes(const std::string& set) {
  const auto mode = GENERATE(ProjectionMode::fraction, ProjectionMode::compliance);
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::joint);
  const testing::InstructionSet only(set);
  const int max_colors = GENERATE(0, 9);
  const float damping = mode == ProjectionMode::compliance && max_colors == 0 ? 0.01F : 0.0F;
  const Scene scene = make_threaded_scene(mode, damping);
  SolverOptions options = testing::small_steps(
      {.mode = mode, .substeps = 2, .iterations = 3, .composition = composition});
  options.coloring.max_colors = max_colors;
  options.coloring.repair = max_colors == 0;
  options.executor = executor::serial();
  const Outcome serial = run(scene, options);
  REQUIRE(serial.report.contacts > 0);
  REQUIRE(serial.report.non_finite_vertices == 0);
  REQUIRE(serial.pull.norm() > 0);

  options.executor = executor::threads(1);
  const std::string name = Solver(scene, options).backend_name();
  if (name.find(set) == std::string::npos) {
    testing::skip("this processor has no " + set);
    return;
  }
  const Outcome fast = run(scene, options);
  CHECK(fast.push.isApprox(serial.push, 0.05F));
  for (const int threads : {1, 2, 3, 8}) {
    INFO(set << ", " << threads << " threads, mode " << static_cast<int>(mode) << ", composition "
             << static_cast<int>(composition) << ", at most " << max_colors << " colors");
    options.executor = executor::threads(threads);
    options.math = MathMode::strict;
    CHECK(run(scene, options) == serial);
    options.math = MathMode::fast;
    CHECK(run(scene, options) == fast);
  }
}

}  // namespace

TEST_CASE("threaded backend: AVX-512 gives the serial bits", "[equivalence][avx512]") {
  check_lanes("AVX-512");
}

TEST_CASE("threaded backend: AVX2 gives the serial bits", "[equivalence][avx2]") {
  check_lanes("AVX2");
}

TEST_CASE("threaded backend: SSSE3 gives the serial bits", "[equivalence][ssse3]") {
  check_lanes("SSSE3");
}

TEST_CASE(
    "threaded backend: domains of a nested plan give the serial bits on any number of threads",
    "[equivalence][long]") {
  const bool springs = GENERATE(true, false);
  const TetMesh mesh =
      testing::make_box({28, 21, 19}, kSoftEdge, 0.1);  // 12,760 vertices: 4 domains
  Scene scene;
  Material material = elastic_material(mesh, 1000, 20e3);
  material.max_stretch = 1.2F;
  scene.add_body("block", mesh, springs ? material : Material{.model = ElasticModel::neo_hookean});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kSoftEdge; });
  SolverOptions options = testing::small_steps({.substeps = 1});
  options.executor = executor::serial();
  Index top = 0;
  const Solver solver(scene, options);
  for (const Phase& phase : solver.plan().phases) {
    top = std::max(top, phase.level);
  }
  REQUIRE(top == 2);
  const Outcome serial = run(scene, options);

  options.executor = executor::threads(1);
  const Outcome fast = run(scene, options);
  for (const int threads : {2, 3, 4, 8}) {
    options.executor = executor::threads(threads);
    options.math = MathMode::strict;
    CHECK(run(scene, options) == serial);
    options.math = MathMode::fast;
    CHECK(run(scene, options) == fast);
  }
}

// Would catch work that is done twice or not at all where one thread takes a step over from others,
// which happens beside programs that keep these from their processors.
TEST_CASE("threaded backend: as many threads as pay give the bits of one, beside busy neighbours",
          "[equivalence][long]") {
  const auto [method, composition] =
      GENERATE(std::pair(SolverMethod::projection, PlanComposition::separate),
               std::pair(SolverMethod::projection, PlanComposition::nested),
               std::pair(SolverMethod::vertex_block, PlanComposition::automatic));
  const TetMesh mesh = testing::make_box({28, 21, 19}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, {.model = ElasticModel::neo_hookean, .damping = 1e-3F});
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kSoftEdge; });
  SolverOptions options = testing::small_steps({.method = method, .substeps = 2});
  options.composition = composition;
  options.executor = executor::threads(1);
  Solver one(scene, options);
  options.executor = executor::threads(3);  // which share each phase of so large a body
  Solver three(scene, options);
  options.executor = executor::threads();
  Solver chosen(scene, options);
  std::vector<std::jthread> neighbours;  // which stop when they are destroyed
  for (unsigned i = 0; i < 2 * std::thread::hardware_concurrency(); ++i) {
    neighbours.emplace_back([](const std::stop_token& stop) {
      while (!stop.stop_requested()) {
      }
    });
  }
  std::vector<std::uint64_t> expected, hashes;
  for (int step = 0; step < 30; ++step) {
    one.step(kUsualStep);
    chosen.step(kUsualStep);
    expected.push_back(one.state_hash());
    hashes.push_back(chosen.state_hash());
  }
  neighbours.clear();
  for (int step = 0; step < 30; ++step) {
    three.step(kUsualStep);
  }
  CHECK(three.state_hash() == expected.back());
  CHECK(hashes == expected);
}

// Would catch a team that two use at once: one then works alone, with the same bits.
TEST_CASE("threaded backend: solvers of several threads may share an executor", "[equivalence]") {
  const TetMesh mesh = testing::make_box({14, 12, 10}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.z() < 0.5 * kSoftEdge; });
  Solver alone(scene, testing::small_steps({.executor = executor::threads(1)}));
  std::vector<Solver> solvers;
  const Executor shared = executor::threads(GENERATE(3, 0));
  for (int i = 0; i < 3; ++i) {
    solvers.emplace_back(scene, testing::small_steps({.executor = shared}));
  }
  constexpr int kSteps = 20;
  {
    std::vector<std::jthread> users;
    for (Solver& solver : solvers) {
      users.emplace_back([&solver] {
        for (int step = 0; step < kSteps; ++step) {
          solver.step(kUsualStep);
        }
      });
    }
  }
  for (int step = 0; step < kSteps; ++step) {
    alone.step(kUsualStep);
  }
  for (const Solver& solver : solvers) {
    CHECK(solver.state_hash() == alone.state_hash());
  }
}

// Would catch an estimate of a root that is no number where both ends are at one point.
TEST_CASE("threaded backend: a link without length has a finite residual", "[unit]") {
  const std::string set = GENERATE("AVX-512", "AVX2", "SSSE3");
  const testing::InstructionSet only(set);
  Scene scene;
  const std::array<Eigen::Vector3d, 2> one_point{Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  scene.add_particles("strand", one_point, 1e-6);
  scene.add_link({0, 1, 1e-3F, {0.5F, 1e-3F}});
  for (const MathMode math : {MathMode::strict, MathMode::fast}) {
    Solver solver(scene, testing::small_steps({.executor = executor::threads(1), .math = math}));
    CHECK(solver.step(kUsualStep).distance_residual == 1);
  }
}

}  // namespace pbdsurg
