// SPDX-License-Identifier: Apache-2.0
// Forces at vertices and gravity at run time: what they do, and what they go along with.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "bench/support/static_energy.h"
#include "lib/solver/solver_copy.h"
#include "tests/support/catch.h"
#include "tests/support/fake_device.h"
#include "tests/support/instruction_set.h"
#include "tests/support/meshes.h"
#include "tests/support/solver_cases.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::kSoftEdge;
using testing::make_bar;
using testing::neo_hookean;
using testing::Recipe;
using testing::run;

constexpr float kDrag = 30;  // 1/s, near critical

// The methods that need no numbers of a test, each with those that bring it to rest.
Recipe any_loaded_recipe() {
  return GENERATE(
      Recipe{"default", {.damping = kDrag}},
      Recipe{"default, BDF2", {.damping = kDrag, .integration = TimeIntegration::bdf2}},
      Recipe{"vertex blocks",
             {.method = SolverMethod::vertex_block, .iterations = 30, .damping = kDrag}},
      Recipe{"projections",
             {.method = SolverMethod::projection, .iterations = 10, .damping = kDrag}},
      Recipe{"projections, BDF2",
             {.method = SolverMethod::projection,
              .iterations = 10,
              .damping = kDrag,
              .integration = TimeIntegration::bdf2}},
      Recipe{"explicit", {.method = SolverMethod::explicit_steps, .damping = kDrag}});
}

std::vector<Index> vertices_where(const Scene& scene,
                                  const std::function<bool(const Eigen::Vector3d&)>& is_in) {
  std::vector<Index> found;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (is_in(scene.positions()[v])) {
      found.push_back(v);
    }
  }
  return found;
}

std::vector<Eigen::Vector3f> shared(const Eigen::Vector3f& force, std::size_t count) {
  return std::vector<Eigen::Vector3f>(count, force / static_cast<float>(count));
}

Eigen::Vector3d mean_way(const Scene& scene, const Solver& solver,
                         const std::vector<Index>& vertices) {
  const auto x = solver.positions();
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Index v : vertices) {
    sum += x[v].cast<double>() - scene.positions()[v];
  }
  return sum / static_cast<double>(vertices.size());
}

// Two blocks apart from each other, held at their lower sides.
Scene make_two_blocks() {
  Scene scene;
  const Material soft = neo_hookean(5e3F, 0.3F);
  for (const double x : {0.0, 0.05}) {
    TetMesh mesh = testing::make_box({2, 3, 2}, kSoftEdge, 0.1);
    std::vector<Eigen::Vector3d> points(mesh.positions().begin(), mesh.positions().end());
    for (Eigen::Vector3d& point : points) {
      point.x() += x;
    }
    const std::vector<Tet> tets(mesh.tets().begin(), mesh.tets().end());
    const Index body =
        scene.add_body(x > 0 ? "second" : "first", TetMesh(std::move(points), tets), soft);
    scene.fix_where(body, [](const Eigen::Vector3d& p) { return p.y() < 0.5 * kSoftEdge; });
  }
  return scene;
}

}  // namespace

// Would catch a force that acts in some substeps only, or that a start of sweeps forgets: the block
// would come to rest elsewhere.
TEST_CASE("forces: a pulled block rests where a static solution has it", "[property][long]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  const Scene scene = [] {
    Scene block;
    block.add_body("block", testing::make_box({4, 4, 4}, kSoftEdge, 0.1), neo_hookean(10e3F, 0.4F));
    block.fix_where(0, [](const Eigen::Vector3d& x) { return x.y() < 0.5 * kSoftEdge; });
    return block;
  }();
  std::vector<Index> top =
      vertices_where(scene, [](const Eigen::Vector3d& x) { return x.y() > 3.5 * kSoftEdge; });
  const auto more = vertices_where(scene, [](const Eigen::Vector3d& x) {
    return x.y() > 2.5 * kSoftEdge && x.y() < 3.5 * kSoftEdge && x.x() > 3.5 * kSoftEdge;
  });
  top.insert(top.end(), more.begin(), more.end());
  REQUIRE(top.size() == 30);
  const std::vector<Eigen::Vector3f> forces = shared({0.03F, 0.04F, 0}, top.size());  // 0.05 N

  bench::StaticEnergy energy(scene);
  for (std::size_t i = 0; i < top.size(); ++i) {
    energy.pull(top[i], forces[i].cast<double>());
  }
  const bench::Positions rest = bench::find_equilibrium(
      energy, bench::Positions(scene.positions().begin(), scene.positions().end()));

  Solver solver(scene, recipe.options);
  solver.set_forces(top, forces);
  run(solver, 300, 2e-3F);
  const auto x = solver.positions();
  double largest_way = 0, largest_error = 0;
  for (std::size_t v = 0; v < x.size(); ++v) {
    largest_way = std::max(largest_way, (rest[v] - scene.positions()[v]).norm());
    largest_error = std::max(largest_error, (x[v].cast<double>() - rest[v]).norm());
  }
  CAPTURE(1e3 * largest_way, 1e3 * largest_error);
  CHECK(largest_way > 1e-3);
  CHECK(largest_error < 0.01 * largest_way);
}

// Would catch an inverse mass too many or too few: the weight of an end load is no share of mass.
TEST_CASE("forces: a bar under an end load stretches as Hooke says", "[property][long]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  constexpr double kModulus = 20e3;  // Pa
  const std::array<Index, 3> cells{8, 2, 2};
  Scene scene;
  scene.add_body("bar", testing::make_box(cells, kSoftEdge), neo_hookean(kModulus, 0));
  // free to become thinner: Poisson's ratio is zero
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.x() < 0.5 * kSoftEdge; });
  scene.set_gravity(Eigen::Vector3f::Zero());
  const double length = 8 * kSoftEdge, area = 4 * kSoftEdge * kSoftEdge;
  const std::vector<Index> end =
      vertices_where(scene, [&](const Eigen::Vector3d& x) { return x.x() > length - 1e-6; });
  const float load = static_cast<float>(0.01 * kModulus * area);
  // a uniform stress gives each vertex a third of the area of the triangles around it
  std::vector<Eigen::Vector3f> forces(end.size(), Eigen::Vector3f::Zero());
  const auto tets = scene.tets();
  for (const Tet& tet : tets) {
    std::vector<std::size_t> corners;
    for (const Index v : tet) {
      if (const auto found = std::ranges::find(end, v); found != end.end()) {
        corners.push_back(static_cast<std::size_t>(found - end.begin()));
      }
    }
    if (corners.size() == 3) {  // half a square
      for (const std::size_t corner : corners) {
        forces[corner].x() += load / 8 / 3;
      }
    }
  }
  Solver solver(scene, recipe.options);
  solver.set_forces(end, forces);
  run(solver, 300, 2e-3F);
  const double stretched = mean_way(scene, solver, end).x();
  // of a Neo-Hookean bar, that to second order in strain; at 1 % the linear law is right to 1 %
  CHECK(stretched == Approx(0.01 * length).epsilon(0.012));
}

// Would catch a force that is scaled by a substep's length, or an impulse in place of a force.
TEST_CASE("forces: what nothing holds speeds up by F / m, and falls as in that gravity",
          "[property]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  SolverOptions options = recipe.options;
  options.damping = 0;
  Scene scene;
  scene.add_body("cube", testing::make_box({2, 2, 2}, kSoftEdge, 0.1), neo_hookean(5e3F, 0.3F));
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, options);
  const Eigen::Vector3f pull(3, 0, 4);  // m/s^2
  solver.set_forces([&](Index v, const Eigen::Vector3f&) -> Eigen::Vector3f {
    return static_cast<float>(scene.masses()[v]) * pull;
  });
  run(solver, 50, 1e-3F);
  const auto velocities = solver.velocities();
  const float passed = options.method == SolverMethod::explicit_steps ? 0.0499F : 0.05F;
  for (const Eigen::Vector3f& velocity : velocities) {
    CHECK((velocity - passed * pull).norm() < 5e-3F * passed * pull.norm());
  }
}

// Would catch a gravity that only the first step reads, or another start of sweeps' own.
TEST_CASE("forces: gravity turned at run time moves the rest as one set before", "[unit]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  const Eigen::Vector3f turned(0, 0, 9.81F);
  Scene scene = make_bar(neo_hookean(10e3F, 0.3F), {4, 2, 2});
  Solver later(scene, recipe.options);
  run(later, 20, 2e-3F);
  later.set_gravity(turned);
  CHECK(later.gravity(0) == turned);
  scene.set_gravity(turned);
  Solver before(scene, recipe.options);
  run(later, 400, 2e-3F);
  run(before, 400, 2e-3F);
  const std::vector<Index> end =
      vertices_where(scene, [](const Eigen::Vector3d& x) { return x.x() > 3.5 * kSoftEdge; });
  const double sag = mean_way(scene, before, end).norm();
  CAPTURE(sag, testing::farthest(later, before));
  CHECK(sag > 1e-4);
  CHECK(testing::farthest(later, before) < 0.01 * sag);
}

// Would catch a gravity that is of all bodies, of the first, or of places in place of vertices.
TEST_CASE("forces: a body's own gravity moves it as one of all would, and no other", "[unit]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  const Scene scene = make_two_blocks();
  const Eigen::Vector3f own(5, -9.81F, 0);
  Solver solver(scene, recipe.options), all(scene, recipe.options), none(scene, recipe.options);
  solver.set_gravity(1, own);
  all.set_gravity(own);
  CHECK(solver.gravity(0) == scene.gravity());
  CHECK(solver.gravity(1) == own);
  for (Solver* const each : {&solver, &all, &none}) {
    run(*each, 100, 2e-3F);
  }
  const auto x = solver.positions(), with = all.positions(), without = none.positions();
  float moved = 0, first = 0, second = 0;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    const bool is_second = v >= scene.body(1).first_vertex;
    moved = std::max(moved, (with[v] - without[v]).norm());
    (is_second ? second : first) =
        std::max(is_second ? second : first, (x[v] - (is_second ? with : without)[v]).norm());
  }
  CAPTURE(moved, first, second);
  CHECK(moved > 1e-4F);
  CHECK(first < 0.01F * moved);
  CHECK(second < 0.01F * moved);
}

// Would catch a cost or a rounding where nothing is used: bits would differ.
TEST_CASE("forces: forces of zero, and gravity as it is, change no bit", "[unit]") {
  const Recipe recipe = any_loaded_recipe();
  INFO(recipe.name);
  const Scene scene = make_two_blocks();
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  Solver plain(scene, options), zero(scene, options), cleared(scene, options);
  zero.set_forces(std::array<Index, 2>{5, 7},
                  std::array<Eigen::Vector3f, 2>{Eigen::Vector3f::Zero(), Eigen::Vector3f::Zero()});
  zero.set_gravity(scene.gravity());
  cleared.set_forces(std::array<Index, 1>{5}, std::array{Eigen::Vector3f(1, 2, 3)});
  cleared.clear_forces();
  cleared.set_gravity(1, Eigen::Vector3f(1, 2, 3));
  cleared.set_gravity(scene.gravity());
  for (Solver* const each : {&plain, &zero, &cleared}) {
    run(*each, 5);
  }
  CHECK(testing::farthest(plain, zero) == 0);
  CHECK(plain.velocities() == zero.velocities());
  CHECK(plain.state_hash() == cleared.state_hash());
  zero.clear_forces();
  CHECK(plain.state_hash() == zero.state_hash());
}

// Would catch lanes that take another's force, a rest of a register that takes none, and an order
// of sums of its own.
TEST_CASE("forces: the serial bits on any number of threads and any instruction set",
          "[equivalence]") {
  const Recipe recipe = any_loaded_recipe();
  const std::string set = GENERATE("AVX-512", "AVX2", "SSSE3");
  const testing::InstructionSet only(set);
  const bool has_field = GENERATE(false, true);
  const Scene scene = make_two_blocks();
  SolverOptions options = recipe.options;
  options.math = MathMode::strict;
  options.composition = PlanComposition::separate;
  for (const int threads : {1, 3}) {
    options.executor = executor::threads(threads);
    Solver solver(scene, options);
    if (std::string(solver.backend_name()).find(set) == std::string::npos) {
      return;  // this processor has none
    }
    INFO(recipe.name << ", " << solver.backend_name() << ", field " << has_field);
    options.executor = executor::serial();
    Solver reference(scene, options);
    for (Solver* const each : {&reference, &solver}) {
      for (int round = 0; round < 4; ++round) {
        if (has_field) {
          each->set_forces([&](Index, const Eigen::Vector3f& x) -> Eigen::Vector3f {
            return 0.02F * static_cast<float>(round) * x;
          });
        } else {
          each->set_gravity(round % 2, Eigen::Vector3f(1, -2, static_cast<float>(round)));
        }
        each->step(5e-3F);
      }
    }
    CHECK(solver.state_hash() == reference.state_hash());
  }
}

// Would catch a call that sets what comes before the fault.
TEST_CASE("forces: bad ones are refused by vertex and value, and nothing is set", "[unit]") {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  Solver solver(make_two_blocks(), {.copies = 2});
  const Eigen::Vector3f good(1, 2, 3);
  const auto refuses = [&](std::vector<Index> vertices, std::vector<Eigen::Vector3f> forces,
                           const char* why) {
    CHECK_THROWS_AS(solver.set_forces(vertices, forces, 1), InvalidArgument);
    CHECK_THROWS_WITH(solver.set_forces(vertices, forces, 1), ContainsSubstring(why));
    CHECK(solver.forces(1).empty());
  };
  refuses({1, 7}, {good, {0, kNan, 0}},
          "the force at vertex 7 is (0, nan, 0) N; it must be finite");
  refuses({1, 999}, {good, good}, "vertex 999");
  refuses({1, -1}, {good, good}, "vertex -1");
  refuses({4, 1, 4}, {good, good, good}, "vertex 4 is named twice");
  refuses({1, 2}, {good}, "there are 1 forces for 2 vertices");
  CHECK_THROWS_WITH(solver.set_forces(std::array<Index, 1>{1}, std::array{good}, 2),
                    ContainsSubstring("there is no copy 2"));
  CHECK_THROWS_WITH(solver.set_gravity({0, kNan, 0}),
                    ContainsSubstring("gravity is (0, nan, 0) m"));
  CHECK_THROWS_WITH(solver.set_gravity(0, {0, 0, kNan}), ContainsSubstring("it must be finite"));
  CHECK_THROWS_WITH(solver.set_gravity(2, good), ContainsSubstring("body 2"));
  CHECK_THROWS_WITH(solver.gravity(-1), ContainsSubstring("body -1"));
  CHECK(solver.gravity(0) == Eigen::Vector3f(0, -9.81F, 0));
}

// Would catch forces that a snapshot leaves behind, or that stay where it had none.
TEST_CASE("forces: a snapshot has them, and a solver goes on from it with the same bits",
          "[unit]") {
  const auto executor = GENERATE(executor::serial(), testing::fake_device());
  const auto integration = GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  SolverOptions options = testing::vertex_options(2, 2);
  options.integration = integration;
  options.executor = executor;
  Solver solver(make_two_blocks(), options);
  const Snapshot without = solver.snapshot();
  CHECK(without.forces.empty());
  solver.set_forces(std::array<Index, 2>{8, 40},
                    std::array<Eigen::Vector3f, 2>{{{1e-3F, 0, 0}, {0, 0, 2e-3F}}});
  run(solver, 3);
  const Snapshot with = solver.snapshot();
  REQUIRE(with.forces.size() == with.positions.size());
  CHECK(with.forces[40] == Eigen::Vector3f(0, 0, 2e-3F));
  run(solver, 3);
  const std::uint64_t end = solver.state_hash();

  solver.restore(without);
  CHECK(solver.forces().empty());
  run(solver, 2);
  solver.restore(with);
  run(solver, 3);
  CHECK(solver.state_hash() == end);

  Snapshot bad = with;
  bad.forces[3].y() = std::numeric_limits<float>::infinity();
  CHECK_THROWS_WITH(solver.restore(bad), ContainsSubstring("the force of vertex 3 is not finite"));
  bad.forces.resize(2);
  CHECK_THROWS_WITH(solver.restore(bad), ContainsSubstring("the snapshot's forces has 2 entries"));
}

// Would catch gravities of a motion from a file that are read beyond their end, or throw tissue
// away.
TEST_CASE("forces: a motion with gravities that the solver cannot have is refused", "[unit]") {
  Solver solver(make_two_blocks(), testing::vertex_options(1, 2));
  solver.set_gravity(1, {1, 2, 3});
  const SolverMotion good = motion_of(solver);
  solver.set_gravity({0, 0, 0});
  const auto refuses = [&](const std::function<void(SolverMotion&)>& spoil,
                           const std::string& what) {
    SolverMotion bad = good;
    spoil(bad);
    CHECK_THROWS_WITH(set_motion(solver, bad), ContainsSubstring(what));
    CHECK(solver.gravity(1) == Eigen::Vector3f(0, 0, 0));
  };
  const float nan = std::nanf("");
  refuses([](SolverMotion& motion) { motion.body_gravities.pop_back(); },
          "the motion has 1 gravities of bodies; it needs 2");
  refuses([&](SolverMotion& motion) { motion.body_gravities[1].z() = nan; },
          "gravity is (1, 2, nan) m");
  refuses([&](SolverMotion& motion) { motion.gravity.x() = nan; }, "it must be finite");
  set_motion(solver, good);
  CHECK(solver.gravity(1) == Eigen::Vector3f(1, 2, 3));
}

// Would catch a force that comes back at another vertex, or a gravity that a body lost.
TEST_CASE("forces: they and gravity follow edits, their undo and a compaction", "[unit]") {
  const auto executor = GENERATE(executor::serial(), testing::fake_device());
  SolverOptions options = testing::vertex_options(1, 3);
  options.executor = executor;
  Solver solver(make_two_blocks(), options);
  Tissue& tissue = solver.tissue();
  const auto end = static_cast<Index>(solver.vertex_count());
  const Eigen::Vector3f force(1e-3F, 0, 2e-3F), own(1, 2, 3);
  solver.set_forces(std::array<Index, 1>{end - 1}, std::array{force});
  solver.set_gravity(1, own);
  run(solver, 1);

  Scene guest;
  guest.add_body("guest", testing::make_box({1, 1, 1}, kSoftEdge), neo_hookean(5e3F, 0.3F));
  const auto before = solver.snapshot();
  tissue.apply({.new_bodies = guest});
  CHECK(solver.gravity(2) == Eigen::Vector3f(0, -9.81F, 0));
  CHECK(solver.gravity(1) == own);
  CHECK(solver.forces().back() == Eigen::Vector3f::Zero());
  solver.set_forces(std::array<Index, 1>{solver.vertex_count() - 1}, std::array{force});
  tissue.undo();
  CHECK(solver.forces().size() == static_cast<std::size_t>(end));
  CHECK(solver.forces().back() == force);
  tissue.apply({.new_bodies = guest});
  CHECK(solver.forces().back() == Eigen::Vector3f::Zero());  // not that of the one that went

  tissue.apply({.remove_bodies = {0}});
  Compaction compaction(solver);
  compaction.build();
  const Renumbering ids = compaction.finish(solver);
  CHECK(solver.gravity(ids.bodies[1]) == own);
  CHECK(solver.gravity(ids.bodies[2]) == Eigen::Vector3f(0, -9.81F, 0));
  CHECK(solver.forces()[ids.vertices[end - 1]] == force);
  const auto start = solver.positions();
  run(solver, 1);
  CHECK((solver.velocities()[ids.vertices[end - 1]].z()) > 0);
  CHECK(before.positions.size() == static_cast<std::size_t>(end));
}

}  // namespace pbdsurg
