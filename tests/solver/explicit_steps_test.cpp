// SPDX-License-Identifier: Apache-2.0
// Explicit steps: the longest stable substep, what they do against closed forms, tools, edits.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "lib/solver/methods/stable_substep.h"
#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;
using testing::vertices_above;

SolverOptions explicit_options(float damping = 0) {
  return {.method = SolverMethod::explicit_steps, .damping = damping};
}

// Two particles and a link.
Scene make_swing(double mass, float compliance) {
  Scene scene;
  scene.set_gravity(Eigen::Vector3f::Zero());
  scene.add_particles("ends", std::vector<Eigen::Vector3d>{{0, 0, 0}, {0.1, 0, 0}}, mass);
  scene.add_link({0, 1, 0.1F, {1, compliance}});
  return scene;
}

// J, of a body that swings about rest without gravity; what its substeps keep.
double kinetic_energy(const Solver& solver) {
  const auto masses = solver.tissue().masses();
  const auto v = solver.velocities();
  double sum = 0;
  for (std::size_t i = 0; i < v.size(); ++i) {
    sum += 0.5 * masses[i] * v[i].squaredNorm();
  }
  return sum;
}

}  // namespace

// Would catch a bound that forgets a part of the stiffness matrix, or counts it twice: for a link
// between two equal masses it is exact.
TEST_CASE("explicit steps: the longest substep is that of a frequency somewhat higher", "[unit]") {
  const double mass = 2e-3;
  const float compliance = 0.01F;
  const Solver solver(make_swing(mass, compliance), explicit_options());
  const double frequency = std::sqrt(2 / (double{compliance} * mass));
  CHECK(solver.plan().longest_substep == Approx(2 / (std::sqrt(1.2) * frequency)).epsilon(1e-5));
  CHECK_THAT(solver.plan().name, ContainsSubstring("explicit, vertices, substeps of"));
  REQUIRE(solver.plan().phases.size() == 1);
  CHECK(solver.plan().phases[0].kind == PhaseKind::vertex);
}

// Would catch substeps that are too long: the noise would grow without end. And damping that nobody
// asked for: it would fade.
TEST_CASE("explicit steps: noise does not grow in the longest substep", "[property]") {
  const float ratio = GENERATE(0.3F, 0.45F, 0.49F);
  const bool has_limit = GENERATE(false, true);
  Material material = neo_hookean(1e4F, ratio);
  material.max_stretch = has_limit ? 1.2F : kInfinity;
  Scene scene = make_bar(material, {6, 3, 3});
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, explicit_options());
  std::vector<Eigen::Vector3f> v(static_cast<std::size_t>(solver.vertex_count()));
  for (std::size_t i = 0; i < v.size(); ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      v[i][axis] = static_cast<float>(1e-2 * (random_unit(7, i, axis) - 0.5));
    }
  }
  solver.write_velocities(v);
  const double start = kinetic_energy(solver);
  double most = 0;
  for (int i = 0; i < 2000; ++i) {
    solver.step(solver.plan().longest_substep);
    most = std::max(most, kinetic_energy(solver));
  }
  CHECK(most <
        1.5 * start);  // near the limit, the energy of a swing is not that of its speed alone
  CHECK(kinetic_energy(solver) > 0.2 * start);
}

// Would catch a force or an inertia that is off by a factor, and damping that nobody asked for.
TEST_CASE("explicit steps: a mass on a link swings as long and as far as it should",
          "[validation]") {
  const double mass = 2e-3;
  const double compliance = 0.02;
  Solver solver(make_swing(mass, static_cast<float>(compliance)), explicit_options());
  std::vector<Eigen::Vector3f> x = solver.positions();
  x[1].x() += 1e-3F;
  solver.write_positions(x);
  const double frequency = std::sqrt(2 / (compliance * mass));
  const double period = 2 * std::numbers::pi / frequency;
  const int count = 200;
  for (int i = 0; i < 10 * count; ++i) {
    solver.step(static_cast<float>(period / count));
  }
  x = solver.positions();
  CHECK(x[1].x() - x[0].x() == Approx(0.101).epsilon(1e-5));
  CHECK(x[0].x() + x[1].x() == Approx(0.101).epsilon(1e-5));
}

// Would catch a drag that counts twice, or half: the guide tells when a swing has lost half its
// height.
TEST_CASE("explicit steps: drag halves a swing in 1.4 over its rate", "[validation]") {
  const double mass = 2e-3;
  const double compliance = 0.02;
  const double period = 2 * std::numbers::pi * std::sqrt(compliance * mass / 2);
  const int periods = 20, count = 100;
  const double drag = 2 * std::numbers::ln2 / (periods * period);
  Solver solver(make_swing(mass, static_cast<float>(compliance)),
                explicit_options(static_cast<float>(drag)));
  std::vector<Eigen::Vector3f> x = solver.positions();
  x[1].x() += 1e-3F;
  solver.write_positions(x);
  for (int i = 0; i < periods * count; ++i) {
    solver.step(static_cast<float>(period / count));
  }
  x = solver.positions();
  CHECK(x[1].x() - x[0].x() - 0.1F == Approx(0.5e-3).epsilon(0.01));
}

// Would catch a start that takes a velocity of now for one of half a substep before, or the
// reverse: what swings would be off by a share of the substep, not of its square.
TEST_CASE("explicit steps: half a substep leaves a quarter of the error", "[validation]") {
  const double mass = 2e-3;
  const double compliance = 0.02;
  const double period = 2 * std::numbers::pi * std::sqrt(compliance * mass / 2);
  const auto error = [&](int count) {  // substeps a period
    Solver solver(make_swing(mass, static_cast<float>(compliance)), explicit_options());
    std::vector<Eigen::Vector3f> x = solver.positions();
    x[1].x() += 1e-3F;
    solver.write_positions(x);
    for (int i = 0; i < count + count / 4; ++i) {
      solver.step(static_cast<float>(period / count));
    }
    x = solver.positions();
    return std::abs(x[1].x() - x[0].x() - 0.1F);  // it passes through rest
  };
  const auto coarse = static_cast<double>(error(40)), fine = static_cast<double>(error(80));
  CHECK(coarse > 3e-6);  // m, far above rounding
  CHECK(coarse / fine > 3.5);
  CHECK(coarse / fine < 4.5);
}

// Would catch velocities that the change of a substep's length, a snapshot or a written state
// leaves half of the wrong substep behind: a fall is a parabola without error.
TEST_CASE("explicit steps: what falls is on its parabola whatever the steps are", "[golden]") {
  Scene scene;
  scene.add_particles("stone", std::vector<Eigen::Vector3d>{{0, 0, 0}}, 1e-3);
  SolverOptions options = explicit_options();
  options.copies = 2;
  options.executor = GENERATE(executor::serial(), executor::threads(2));
  options.substeps = 3;
  Solver solver(scene, options);
  double t = 0;
  const auto step = [&](float dt) {
    solver.step(dt);
    t += double{dt};
    const double fallen = 9.81 / 2 * t * t;
    CHECK(-solver.positions(1)[0].y() == Approx(fallen).epsilon(1e-5));
  };
  for (const float dt : {1e-3F, 1e-3F, 4e-3F, 2e-4F, 3e-3F}) {
    step(dt);
  }
  const Snapshot before = solver.snapshot();
  solver.step(2e-3F);
  const std::uint64_t hash = solver.state_hash();
  solver.restore(before, 1);
  solver.restore(before, 0);
  step(2e-3F);
  CHECK(solver.state_hash() == hash);

  Scene more;
  more.add_particles("late", std::vector<Eigen::Vector3d>{{1, 0, 0}}, 1e-3);
  solver.tissue().apply({.new_bodies = more});
  const double came = t;
  step(1e-3F);
  step(3e-3F);
  CHECK(-solver.positions(1)[1].y() == Approx(9.81 / 2 * (t - came) * (t - came)).epsilon(1e-4));

  solver.write_positions(std::vector<Eigen::Vector3f>{{0, 0, 0}, {1, 0, 0}},
                         1);  // where nothing is known
  solver.write_velocities(std::vector<Eigen::Vector3f>(2, {0, 0, 0}),
                          1);  // of before, it starts anew
  t = 0;
  step(1e-3F);
  step(2e-3F);
}

// Would catch a link or a tool that is left out of the step, or a force in newtons that takes
// another substep for its multipliers.
TEST_CASE("explicit steps: a grasp and a tool feel the weight that they carry", "[validation]") {
  const float compliance = GENERATE(0.0F, 1e-3F);
  const auto features = GENERATE(ContactFeatures::vertices, ContactFeatures::all);
  const double edge = 5e-3;
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, edge), neo_hookean(5e3F, 0.4F));
  const Index block = scene.vertex_count();
  scene.add_particles("particle", std::vector<Eigen::Vector3d>{{0.1, 0.0101, 0}}, 1e-3);
  Solver solver(scene, explicit_options(60));
  const ToolId holder = solver.add_tool({}, ToolPose::Identity());
  const ToolId floor = solver.add_tool(std::vector<Capsule>{{{0.1F, 0, 0}, {0.1F, 0, 0}, 0.01F}},
                                       ToolPose::Identity(), {features, 0});
  std::vector<Index> top = vertices_above(scene, 1.99 * edge);
  std::erase(top, block);
  solver.grasp(holder, top, compliance);
  run(solver, 600, 2e-3F);
  const double weight = 1000 * std::pow(2 * edge, 3) * 9.81;
  CHECK(solver.tool_force(holder).y() == Approx(-weight).epsilon(2e-3));
  CHECK(solver.tool_force(floor).y() == Approx(-9.81e-3).epsilon(2e-3));
  CHECK(solver.positions()[block].y() == Approx(0.01).epsilon(1e-3));
}

// Would catch lanes, or threads, that move a vertex another way than the serial executor does.
TEST_CASE("explicit steps: strict threads have the serial bits, fast ones their own", "[golden]") {
  Material limited = neo_hookean(5e3F, 0.45F);
  limited.max_stretch = 1.1F;
  Scene scene = make_bar(limited, {6, 2, 2});
  const TetMesh tube = testing::make_box({3, 1, 1}, 4e-3, 0.1, 2);
  const BodyId springs = scene.add_body("springs", tube, testing::soft_springs(tube));
  const Index first = scene.body(springs).first_vertex;
  scene.add_link({5, first, 0.004F, {1, 1e-2F}});
  scene.add_hinges(0, 1e-5F);
  const auto hash_of = [&](const Executor& executor, MathMode math) {
    SolverOptions options = explicit_options();
    options.executor = executor;
    options.math = math;
    Solver solver(scene, options);
    const Capsule ball{{0.02F, -0.012F, 0.004F}, {0.02F, -0.012F, 0.004F}, 0.0125F};
    const ToolId pusher = solver.add_tool({&ball, 1}, ToolPose::Identity());
    const ToolId holder = solver.add_tool({}, ToolPose::Identity());
    solver.grasp(holder, std::array<Index, 2>{first + 2, first + 3}, 1e-3F);
    ToolPose pose = ToolPose::Identity();
    Index contacts = 0;
    for (int i = 0; i < 20; ++i) {
      pose.translation().y() += 1e-4F;
      solver.move_tool(pusher, pose);
      solver.move_tool(holder, pose);
      contacts += solver.step(1e-3F).contacts;
    }
    CHECK(contacts > 0);
    return solver.state_hash();
  };
  const std::uint64_t serial = hash_of(executor::serial(), MathMode::strict);
  CHECK(hash_of(executor::threads(1), MathMode::strict) == serial);
  CHECK(hash_of(executor::threads(3), MathMode::strict) == serial);
  const std::uint64_t fast = hash_of(executor::threads(1), MathMode::fast);
  CHECK(hash_of(executor::threads(3), MathMode::fast) == fast);
}

// Would catch a bound that keeps what an edit has taken away, or that an undo does not bring back.
TEST_CASE("explicit steps: the longest substep follows edits", "[unit]") {
  Tissue tissue(make_bar(neo_hookean(1e4F, 0.45F), {4, 2, 2}));
  Solver solver(tissue, explicit_options());
  const float before = solver.plan().longest_substep;
  std::vector<Index> removed;
  for (Index t = 0; t < static_cast<Index>(tissue.tets().size()); t += 3) {
    removed.push_back(t);
  }
  tissue.apply({.remove_tets = removed});
  const float after = solver.plan().longest_substep;
  CHECK(after != before);
  run(solver, 3, 1e-3F);
  tissue.undo();
  CHECK(solver.plan().longest_substep == before);
  tissue.apply({.remove_tets = removed});
  CHECK(solver.plan().longest_substep == after);
  const Solver anew(tissue, explicit_options());
  CHECK(anew.plan().longest_substep == after);
  Scene added;
  added.add_body("stiff", testing::make_box({1, 1, 1}, 2e-3), neo_hookean(1e4F, 0.45F));
  tissue.apply({.new_bodies = added});
  CHECK(solver.plan().longest_substep < 0.7F * before);
}

// Would catch substeps that stay what they are at rest: a body that is drawn to three times its
// length burst, and so did an organ under its weight.
TEST_CASE("explicit steps: substeps get shorter as tissue is stretched", "[property]") {
  Scene scene = make_bar(neo_hookean(1e4F, 0.45F), {6, 2, 2});
  scene.set_gravity(Eigen::Vector3f::Zero());
  SolverOptions options = explicit_options(20);
  Solver solver(scene, options);
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  std::vector<Index> end;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > 5.5 * testing::kSoftEdge) {
      end.push_back(v);
    }
  }
  solver.grasp(tool, end);
  ToolPose pose = ToolPose::Identity();
  for (int i = 0; i < 200; ++i) {
    pose.translation().x() += static_cast<float>(2 * 6 * testing::kSoftEdge / 200);
    solver.move_tool(tool, pose);
    REQUIRE(solver.step(1e-3F).inverted_tets == 0);
  }
  CHECK(static_cast<float>(solver.last_report().substeps) >
        1.2F * 1e-3F / solver.plan().longest_substep);
  run(solver, 500, 1e-3F);
  CHECK(kinetic_energy(solver) < 1e-7);

  options.substeps = 2;
  Solver given(scene, options);
  const float dt = 2 * given.plan().longest_substep;
  given.step(dt);
  given.write_positions(solver.positions());
  CHECK_THROWS_WITH(given.step(dt), ContainsSubstring("as tissue is stretched and moves now"));
  given.step(dt / 4);
}

// Would catch substeps that stay what they were at the start of a step, while what is stiff swings
// there and back several times in it, and a look at it at the instant at which it is soft: without
// either, the bar bursts within 0.1 s.
TEST_CASE("explicit steps: stiff tissue that is let go does not burst in long steps",
          "[property]") {
  const Scene scene = testing::make_uneven_bar();
  const float dt = GENERATE(1e-3F, 5e-3F);
  Solver solver(scene, explicit_options());
  solver.write_positions(testing::stretched(scene, 1.3F));
  double first = 0, most = 0;
  int substeps = 0;
  for (float t = 0; t < 0.1F; t += dt) {
    substeps = std::max(substeps, solver.step(dt).substeps);
    const double energy = kinetic_energy(solver);
    REQUIRE(std::isfinite(energy));
    (t < 0.02F ? first : most) = std::max(t < 0.02F ? first : most, energy);
  }
  CHECK(most > 0.1 * first);  // it swings on
  CHECK(most < 1.5 * first);
  CHECK(static_cast<float>(substeps) > 1.2F * dt / solver.plan().longest_substep);
}

// Would catch parts of a step in which an executor divides the rest another way, or begins the way
// or the forces of tools anew, and copies that go apart.
TEST_CASE("explicit steps: strict threads have the serial bits in steps of several parts",
          "[golden]") {
  const Scene scene = testing::make_uneven_bar();
  const int copies = GENERATE(1, 3);
  const auto trial = [&](const Executor& executor) {
    SolverOptions options = explicit_options(1);
    options.executor = executor;
    options.math = MathMode::strict;
    options.copies = copies;
    Solver solver(scene, options);
    solver.write_positions(testing::stretched(scene, 1.3F), copies - 1);
    const Capsule ball{{0.012F, -0.012F, 0.003F}, {0.012F, -0.012F, 0.003F}, 0.0122F};
    const ToolId pusher = solver.add_tool({&ball, 1}, ToolPose::Identity());
    const ToolId holder = solver.add_tool({}, ToolPose::Identity());
    solver.grasp(holder, std::array<Index, 2>{scene.vertex_count() - 1, 30}, 1e-4F, copies - 1);
    ToolPose pose = ToolPose::Identity();
    std::vector<float> forces;
    std::vector<std::uint64_t> hashes;
    Index contacts = 0;
    for (const float dt : {1e-3F, 1.3e-3F, 1e-4F, 2e-3F, 0.9e-3F}) {
      pose.translation().y() += 0.2F * dt;
      solver.move_tool(pusher, pose, copies - 1);
      solver.move_tool(holder, pose, copies - 1);
      const StepReport report = solver.step(dt);
      contacts += report.contacts;
      for (const ToolId tool : {pusher, holder}) {
        forces.push_back(solver.tool_force(tool, copies - 1).y());
      }
      hashes.push_back(static_cast<std::uint64_t>(report.substeps));
      hashes.push_back(solver.state_hash(0));
      hashes.push_back(solver.state_hash(copies - 1));
    }
    CHECK(contacts > 0);
    CHECK(solver.last_report().substeps > 2 * StableSubstep::kUnseen);
    return std::pair(hashes, forces);
  };
  const auto serial = trial(executor::serial());
  CHECK(trial(executor::threads(1)) == serial);
  CHECK(trial(executor::threads(3)) == serial);
}

// Would catch a part of a step that forgets the length of the substep before, counts time or the
// forces of tools twice, or not at all, or moves tools at another speed than the step has.
TEST_CASE("explicit steps: parts of a step are one step to what falls, hangs and is drawn",
          "[validation]") {
  Scene scene = testing::make_uneven_bar();
  scene.set_gravity({0, -9.81F, 0});
  const Index stone = scene.vertex_count();
  const double mass = 1e-3;
  scene.add_particles("stones", std::vector<Eigen::Vector3d>{{0, 0, 1}, {0, 0, 2}, {0, 0, 3}},
                      mass);
  SolverOptions options = explicit_options();
  options.executor = GENERATE(executor::serial(), executor::threads(2));
  Solver solver(scene, options);
  std::vector<Eigen::Vector3f> x = solver.positions();
  const std::vector<Eigen::Vector3f> longer = testing::stretched(scene, 1.3F);
  std::copy(longer.begin(), longer.begin() + stone, x.begin());
  solver.write_positions(x);
  const ToolId still = solver.add_tool({}, ToolPose::Identity());
  const ToolId drawn = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(still, std::array<Index, 1>{stone + 1});
  solver.grasp(drawn, std::array<Index, 1>{stone + 2});
  double t = 0;
  ToolPose pose = ToolPose::Identity();
  const auto step = [&](float dt) {
    pose.translation().x() += 0.5F * dt;
    solver.move_tool(drawn, pose);
    CHECK(solver.step(dt).substeps > StableSubstep::kUnseen);
    t += double{dt};
    x = solver.positions();
    CHECK(-x[stone].y() == Approx(9.81 / 2 * t * t).epsilon(1e-4));
    CHECK(x[stone + 2].x() == Approx(pose.translation().x()).epsilon(1e-5));
    CHECK(solver.velocities()[stone + 2].x() == Approx(0.5).epsilon(1e-2));
  };
  for (const float dt : {1e-3F, 3e-3F, 2e-3F, 5e-3F, 1e-3F}) {
    step(dt);
    if (t > 2e-3) {
      CHECK(solver.tool_force(still).y() == Approx(-9.81 * mass).epsilon(5e-3));
    }
  }
  solver.release(still);
  solver.release(drawn);
  const Snapshot before = solver.snapshot();
  solver.step(2e-3F);
  const std::uint64_t hash = solver.state_hash();
  solver.step(1e-3F);
  solver.restore(before);
  solver.step(2e-3F);
  CHECK(solver.state_hash() == hash);
}

TEST_CASE("explicit steps: what they cannot do is refused with the number", "[unit]") {
  const Scene scene = make_bar(neo_hookean(1e4F, 0.45F));
  const auto problem = [&](const Scene& of, SolverOptions options) {
    CHECK_THROWS_AS(Solver(of, options), InvalidArgument);
    try {
      Solver(of, options);
    } catch (const InvalidArgument& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  SolverOptions options = explicit_options();
  options.iterations = 3;
  CHECK_THAT(problem(scene, options), ContainsSubstring("explicit steps have no sweeps"));
  options = explicit_options();
  options.accuracy = 0.1F;
  CHECK_THAT(problem(scene, options), ContainsSubstring("accuracy is 0.1"));
  options = explicit_options();
  options.integration = TimeIntegration::bdf2;
  CHECK_THAT(problem(scene, options), ContainsSubstring("integration of their own"));
  options = explicit_options();
  options.mode = ProjectionMode::fraction;
  options.substeps = options.iterations = 1;
  CHECK_THAT(problem(make_bar(testing::kSprings), options),
             ContainsSubstring("fraction mode has none"));
  options = explicit_options();
  options.convergence_interval = 1;
  CHECK_THAT(problem(scene, options), ContainsSubstring("no system"));
  options = explicit_options();
  options.over_relaxation = 1.3F;
  CHECK_THAT(problem(scene, options), ContainsSubstring("over_relaxation"));

  Material damped = neo_hookean(1e4F, 0.45F);
  damped.damping = 1e-3F;
  CHECK_THAT(problem(make_bar(damped), explicit_options()),
             ContainsSubstring("damping is 0.001 s; explicit steps have no inner friction"));
  CHECK_THAT(problem(make_bar(neo_hookean(1e9F, 0.45F)), explicit_options()),
             ContainsSubstring("of body 'bar' needs explicit substeps of"));
  CHECK_THAT(problem(make_swing(1e-3, 0), explicit_options()),
             ContainsSubstring("a compliance of 0"));

  options = explicit_options();
  options.substeps = 2;
  Solver solver(scene, options);
  const float longest = solver.plan().longest_substep;
  CHECK_THROWS_WITH(solver.step(3 * longest), ContainsSubstring("stable up to"));
  solver.step(2 * longest);
  CHECK_THROWS_WITH(solver.convergence(1e-4F), ContainsSubstring("residual"));
}

}  // namespace pbdsurg
