// SPDX-License-Identifier: Apache-2.0
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>
#include <new>
#include <numeric>
#include <utility>
#include <vector>

#include "pbdsurg/base/mailbox.h"
#include "pbdsurg/contact/contact_probe.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/surgery/cut.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/base/step_team.h"
#include "tests/support/allocation_count.h"
#include "tests/support/catch.h"
#include "tests/support/held_slab.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::allocation_count;
using testing::allocation_limit;
using testing::kSoftEdge;

constexpr float kTimeStep = 5e-3F;  // s

}  // namespace

// Would catch a constructor that leaves behind threads which wait for work, and so never ends.
TEST_CASE("step team: without memory for more threads it has fewer", "[unit]") {
  std::vector<int> sizes;
  for (long spare = 0; sizes.empty() || sizes.back() < 4; ++spare) {
    REQUIRE(spare < 100);
    try {
      allocation_limit = allocation_count + spare;
      StepTeam team(4);
      allocation_limit = testing::kNoLimit;
      std::atomic<int> workers{0};
      team.run([&](int) { ++workers; });
      CHECK(workers == team.size());
      sizes.push_back(team.size());
    } catch (const std::bad_alloc&) {  // for the team itself
      allocation_limit = testing::kNoLimit;
      CHECK(sizes.empty());
    }
  }
  CHECK(sizes.front() == 1);
}

// Would catch a vector that grows within a step: a real-time thread must not wait for memory.
TEST_CASE("solver: a step allocates nothing after the first", "[validation]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const CoarseCorrection coarse_correction =
      method == SolverMethod::vertex_block ? GENERATE(CoarseCorrection::off, CoarseCorrection::on)
                                           : CoarseCorrection::off;
  const TetMesh mesh = testing::make_box({8, 6, 5}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  const Index copies = GENERATE(1, 3);
  Solver solver(scene, testing::small_steps({.method = method,
                                             .iterations = 2,
                                             .coarse_correction = coarse_correction,
                                             .copies = copies,
                                             .executor = executor}));
  solver.watch(std::array<Index, 3>{5, 1, 40});
  const Capsule capsule{{0, 0, 0}, {0.02F, 0, 0}, 4e-3F};
  ToolPose pose = ToolPose::Identity();
  pose.translation() = Eigen::Vector3f(0, 0.04F, 0.01F);
  const ToolId tool = solver.add_tool({&capsule, 1}, pose);
  const ToolId holder = solver.add_tool({}, ToolPose::Identity());
  const Index corner = solver.vertex_count() - 1;
  solver.grasp(holder, {&corner, 1}, 1e-4F);
  solver.step(kTimeStep);

  const long before = allocation_count;
  Index contacts = 0;
  for (int i = 0; i < 20; ++i) {
    pose.translation().y() -= 1e-3F;
    solver.move_tool(tool, pose);
    contacts = std::max(contacts, solver.step(kTimeStep).contacts);
  }
  CHECK(allocation_count == before);
  CHECK(contacts > 0);
}

// Would catch lists of what is near, or of pieces that push each other, that grow within a step:
// blocks that fall on each other, and a strip.
TEST_CASE("solver: bodies that meet allocate nothing after the first step", "[validation]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  Scene scene;
  const auto block = [&](const char* name, double height) {
    const TetMesh box = testing::make_box({5, 5, 2}, kSoftEdge);
    std::vector<Eigen::Vector3d> positions(box.positions().begin(), box.positions().end());
    for (Eigen::Vector3d& x : positions) {
      x.z() += height;
    }
    return scene.add_body(name, TetMesh(positions, {box.tets().begin(), box.tets().end()}));
  };
  constexpr double kHeight = 2 * kSoftEdge, kApart = 2e-3;
  scene.set_gravity({0, 0, -9.81F});
  scene.fix_where(block("table", 0), [](const Eigen::Vector3d& x) { return x.z() < 1e-9; });
  block("lower", kHeight + kApart);
  block("upper", 2 * (kHeight + kApart));
  const double strip = 3 * (kHeight + kApart);
  scene.add_sheet("strip",
                  std::vector<Eigen::Vector3d>{{0, 0, strip},
                                               {5 * kSoftEdge, 0, strip},
                                               {5 * kSoftEdge, 2 * kSoftEdge, strip},
                                               {0, 2 * kSoftEdge, strip}},
                  std::array<Triangle, 2>{{{0, 1, 2}, {0, 2, 3}}});
  Solver solver(scene, testing::small_steps({.method = method, .executor = executor}));
  for (const Index body : {0, 1, 2}) {
    solver.set_body_contact(body, body + 1, {.thickness = 0.5e-3F, .friction = 0.3F});
  }
  solver.step(kTimeStep);
  long allocations = 0;
  std::size_t contacts = 0;
  for (int i = 0; i < 40; ++i) {
    const long before = allocation_count;
    solver.step(kTimeStep);
    allocations += allocation_count - before;
    contacts = std::max(contacts, solver.body_contacts().size());
  }
  CHECK(allocations == 0);
  CHECK(contacts > 100);
}

// Would catch lists that a patch or its probe makes anew: the simulation waits for memory then, and
// with it all that a mailbox feeds.
TEST_CASE("contact: patches and packets allocate nothing once all slots of a mailbox were filled",
          "[validation]") {
  Scene scene;
  scene.add_body("block", testing::make_box({8, 6, 5}, kSoftEdge, 0.1));
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.executor = executor::serial()}));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  ContactProbe probe(solver, std::array<Index, 1>{0},
                     std::array<ToolPoint, 2>{{{{0, 0, 0}, 3e-3F}, {{5e-3F, 0, 0}, 3e-3F}}});
  Mailbox<ContactPatch> patches;
  std::uint32_t planes = 0;
  std::uint64_t step = 0;
  const auto round = [&] {  // over the block, there and back, mostly looking at what is near
    for (int i = 0; i < 60; ++i) {
      ToolPose pose = ToolPose::Identity();
      pose.translation() =
          Eigen::Vector3f(0.5e-3F * static_cast<float>(30 - std::abs(i - 30)), 0.01F, 0.022F);
      solver.move_tool(tool, pose);
      solver.step(kTimeStep);
      ++step;
      probe.collect_patch(solver, tool, GraspState::open, step, 1e-3 * static_cast<double>(step),
                          patches.draft());
      patches.publish();
      patches.take();
      planes += make_contact_packet(patches.value()).plane_count;
    }
  };
  for (int i = 0; i < 4; ++i) {
    round();
  }
  const long before = allocation_count;
  round();
  CHECK(allocation_count == before);
  CHECK(planes > 200);
}

// Would catch what a step needs and a grasp or a compaction leaves to it to find.
TEST_CASE("solver: the step after a grasp, and after a compaction, allocates nothing",
          "[validation]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const TetMesh mesh = testing::make_box({8, 6, 5}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  Solver solver(scene, testing::small_steps({.method = method, .executor = executor::serial()}));
  const ToolId holder = solver.add_tool({}, ToolPose::Identity());
  const auto allocations_of_step = [&] {
    const long before = allocation_count;
    solver.step(kTimeStep);
    return allocation_count - before;
  };
  CHECK(allocations_of_step() == 0);
  std::vector<Index> vertices(60);
  std::iota(vertices.begin(), vertices.end(), Index{100});
  solver.grasp(holder, vertices, 1e-4F);
  CHECK(allocations_of_step() == 0);
  solver.tissue().apply({.remove_tets = {0, 1, 2, 3, 4, 5}});
  Compaction compaction(solver);
  compaction.build();
  static_cast<void>(compaction.finish(solver));
  CHECK(allocations_of_step() == 0);
}

// Would catch what a grip needs as it slides, as points leave the pad, and as it lets go.
TEST_CASE("solver: a grip that slips off allocates nothing", "[validation]") {
  const auto method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const testing::HeldSlab slab;
  Solver solver(slab.scene, {.method = method, .executor = executor::serial()});
  const ToolId tool = solver.add_tool({}, testing::HeldSlab::pose());
  solver.grasp(tool, slab.points(), testing::HeldSlab::grip(0.05F));
  solver.step(kTimeStep);
  const long before = allocation_count;
  for (int i = 1; i <= 60; ++i) {
    solver.move_tool(tool, testing::HeldSlab::pose({5e-4F * static_cast<float>(i), 0, 0}));
    solver.step(kTimeStep);
  }
  CHECK(allocation_count == before);
  CHECK(solver.tool_grip(tool).state == GripState::lost);
}

// Would catch an edit that looks for memory between two steps, or leaves that to the next step.
TEST_CASE("solver: edits within the spare room allocate nothing after the first ones",
          "[validation]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const auto composition = GENERATE(PlanComposition::separate, PlanComposition::nested);
  const TetMesh mesh = testing::make_box({8, 6, 5}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  Solver solver(scene,
                testing::small_steps(
                    {.executor = executor, .composition = composition, .spare = {.links = 400}}));
  TopologyEdit edit;
  long before = 0;
  for (Index round = 0; round < 30; ++round) {
    edit.remove_tets.clear();
    for (Index i = 0; i < (round < 15 ? 24 : 8); ++i) {  // at first with all of a corner
      edit.remove_tets.push_back(24 * round + i);
    }
    edit.rest_volumes.assign({{1439, 1e-9F}});
    edit.remove_links.clear();
    if (round > 1 && solver.tissue().is_link_alive(8)) {
      edit.remove_links.push_back(8);
    }
    edit.new_links.clear();
    for (Index i = 0; i < 8; ++i) {
      const Index first = solver.vertex_count() - 1 - (37 * round + 5 * i) % 100;
      const Index second = first - 40 - 3 * i;
      edit.new_links.push_back({first, second, 0.01F, {0.5F, 1e-2F}});
    }
    if (round == 15) {
      before = allocation_count;
    }
    solver.tissue().apply(edit);
    if (round % 5 == 0) {
      solver.tissue().undo();
      solver.tissue().apply(edit);
    }
    solver.step(kTimeStep);
  }
  CHECK(allocation_count == before);
  CHECK(solver.tissue().links().size() > 230);
}

// Would catch lists that no room was made for, in the solver or in a compacted one, and colours
// that open or fill beyond theirs.
TEST_CASE("solver: a blade's edits within the spare room allocate nothing after the first pass",
          "[validation]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const TetMesh mesh = testing::make_box({8, 6, 5}, kSoftEdge, 0.1);
  Material limited = elastic_material(mesh, 1000, 20e3);
  limited.max_stretch = 1.2F;
  Scene scene;
  scene.add_body("block", mesh, limited);
  Solver solver(scene,
                testing::small_steps({.executor = executor,
                                      .composition = PlanComposition::separate,
                                      .spare = {.vertices = 4000, .tets = 20000, .edges = 30000}}));
  if (GENERATE(false, true)) {
    Compaction compaction(solver);
    compaction.build();
    static_cast<void>(compaction.finish(solver));
  }
  std::size_t added = 0;
  constexpr int kPasses = 4, kFrames = 20;
  for (int pass = 0; pass < kPasses; ++pass) {
    CutFront front;
    for (int frame = 0; frame < kFrames; ++frame) {
      const float z = kSoftEdge * (0.6F + 1.1F * static_cast<float>(pass));
      const auto blade_at = [&](int at) {
        const float x = kSoftEdge * (-1 + 10 * static_cast<float>(at) / kFrames);
        return BladeEdge{{x, -1, z}, {x, 1, z}};
      };
      const CutSurface way = sweep_blade(std::array{blade_at(frame), blade_at(frame + 1)});
      const CutPlan plan = plan_cut(solver, way, {.front = std::move(front)});
      const long before = allocation_count;
      solver.tissue().apply(plan.edit);
      solver.step(kTimeStep);
      const long count = allocation_count - before;
      INFO("pass " << pass << ", frame " << frame << ": " << plan.edit.new_tets.size());
      CHECK((pass == 0 || count == 0));
      front = plan.front;
      added += plan.edit.new_tets.size();
    }
  }
  CHECK(added > 2000);
}

// Would catch a list that is made anew for each tetrahedron that is split, or each edge of it. What
// is left are lists that grow as cuts do, and colours that open.
TEST_CASE("solver: cuts into thousands of tetrahedra allocate little within the spare room",
          "[validation]") {
  const Executor executor = GENERATE(executor::serial(), executor::threads(2));
  const TetMesh mesh = testing::make_box({8, 6, 5}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("block", mesh, elastic_material(mesh, 1000, 20e3));
  Solver solver(scene,
                testing::small_steps({.executor = executor,
                                      .composition = PlanComposition::separate,
                                      .spare = {.vertices = 4000, .tets = 20000, .edges = 30000}}));
  constexpr int kCuts = 10;
  for (int cut = 0; cut < kCuts; ++cut) {
    const float z = kSoftEdge * (0.4F + 0.37F * static_cast<float>(cut));
    const auto blade_at = [&](float x) { return BladeEdge{{x, -1, z}, {x, 1, z}}; };
    const CutPlan plan = plan_cut(solver, sweep_blade(std::array{blade_at(-1), blade_at(1)}));
    REQUIRE(plan.edit.new_tets.size() > 100);
    const long before = allocation_count;
    solver.tissue().apply(plan.edit);
    solver.step(kTimeStep);
    INFO("cut " << cut << " into " << plan.edit.new_tets.size());
    CHECK((cut < 2 || allocation_count - before < 100));
  }
}

}  // namespace pbdsurg
