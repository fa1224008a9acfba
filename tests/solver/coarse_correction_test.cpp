// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/coarse_correction.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/solver/compaction.h"
#include "pbdsurg/solver/solver.h"
#include "pbdsurg/tissue/tissue.h"

#include "tests/support/catch.h"
#include "tests/support/cuts.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::farthest;
using testing::inspect;
using testing::kSoftEdge;
using testing::make_bar;
using testing::neo_hookean;
using testing::run;
using testing::vertex_options;

SolverOptions corrected(int sweeps, float damping = 0) {
  SolverOptions options = vertex_options(1, sweeps, damping);
  options.coarse_correction = CoarseCorrection::on;
  return options;
}

using Start = std::vector<Eigen::Vector3f>;

Solver after_a_step(const Scene& scene, const SolverOptions& options, const Start& start,
                    float dt) {
  Solver solver(scene, options);
  solver.write_positions(start);
  solver.step(dt);
  return solver;
}

Start turned(Start positions, float angle) {
  const Eigen::AngleAxisf turn(angle, Eigen::Vector3f(1, 2, -1).normalized());
  for (Eigen::Vector3f& x : positions) {
    x = turn * x;
  }
  return positions;
}

// Of a bar of 16 cells.
std::vector<Index> tip_of(const Scene& scene) {
  std::vector<Index> tip;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (scene.positions()[v].x() > 15.5 * kSoftEdge) {
      tip.push_back(v);
    }
  }
  return tip;
}

Scene weightless(Scene scene) {
  scene.set_gravity(Eigen::Vector3f::Zero());
  return scene;
}

}  // namespace

// Of one tetrahedron and one vertex that it hangs on, the modes are all there is: the correction is
// Newton's step. Would catch a wrong stiffness, mass, length of a substep, or turn.
TEST_CASE("coarse correction: is exact where its modes are all motions", "[validation]") {
  const bool springs = GENERATE(false, true);
  const float angle = GENERATE(0.0F, 2.0F);
  const float dt = GENERATE(5e-4F, 1e-3F);
  const TetMesh tet({{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}, {{0, 1, 2, 3}});
  Scene scene;
  scene.add_body("tet", tet, springs ? testing::soft_springs(tet) : neo_hookean(2e4F, 0.45F));
  scene.fix_where(0, [](const Eigen::Vector3d& x) { return x.norm() < 1e-6; });
  scene = weightless(scene);
  Start start = testing::stretched(scene, 1.002F);
  start = turned(start, angle);

  const Solver converged = after_a_step(scene, vertex_options(1, 3000), start, dt);
  const float plain = farthest(after_a_step(scene, vertex_options(1, 2), start, dt), converged);
  const float with = farthest(after_a_step(scene, corrected(2), start, dt), converged);

  CAPTURE(springs, angle, dt, plain, with);
  REQUIRE(plain > 1e-7F);  // m
  CHECK(with < 0.05F * plain);
}

TEST_CASE("coarse correction: brings few sweeps closer to many", "[property]") {
  const bool springs = GENERATE(false, true);
  const float angle = GENERATE(0.0F, 2.0F);
  const TetMesh mesh = testing::make_box({24, 4, 4}, kSoftEdge, 0.1);
  Scene scene;
  scene.add_body("bar", mesh, springs ? testing::soft_springs(mesh) : neo_hookean(2e4F, 0.45F));
  scene = weightless(scene);
  const Start start = turned(testing::stretched(scene, 1.1F), angle);
  const Solver converged = after_a_step(scene, vertex_options(1, 1000), start, 5e-3F);

  const float plain = farthest(after_a_step(scene, vertex_options(1, 10), start, 5e-3F), converged);
  const float with = farthest(after_a_step(scene, corrected(3), start, 5e-3F), converged);

  CAPTURE(springs, angle, plain, with);
  CHECK(with < 0.5F * plain);
}

// Would catch a correction that drags what tools hold along, or that pulls at what rests.
TEST_CASE("coarse correction: a held bar rests as it does without, with the same force",
          "[validation]") {
  const Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {16, 4, 4});
  const auto rest = [&](const SolverOptions& options) {
    Solver solver(scene, options);
    const ToolId tool = solver.add_tool({}, ToolPose::Identity());
    solver.grasp(tool, tip_of(scene));
    ToolPose pose = ToolPose::Identity();
    pose.translation() = Eigen::Vector3f(0.01F, 0.02F, 0);
    solver.move_tool(tool, pose);
    run(solver, 300);
    return solver;
  };
  Solver with = rest(corrected(3, 20)), without = rest(vertex_options(1, 60, 20));

  CHECK(farthest(with, without) < 0.002F * static_cast<float>(kSoftEdge));
  const Eigen::Vector3f force = without.tool_force(ToolId{0});
  REQUIRE(force.norm() > 0.01F);
  CHECK((with.tool_force(ToolId{0}) - force).norm() < 0.01F * force.norm());
}

// A tip that is carried half around and pushed in: stiffness at rest is wrong there. Would catch
// steps that are not shortened, which shake tissue for ever, or until it bursts.
TEST_CASE("coarse correction: crumpled tissue comes to rest", "[validation]") {
  const Scene scene = make_bar(neo_hookean(1e4F, 0.45F), {16, 4, 4});
  Solver solver(scene, corrected(4));
  const ToolId tool = solver.add_tool({}, ToolPose::Identity());
  solver.grasp(tool, tip_of(scene));
  for (int i = 1; i <= 60; ++i) {
    const float share = static_cast<float>(i) / 60;
    ToolPose pose(
        Eigen::AngleAxisf(share * 2 * std::numbers::pi_v<float> / 3, Eigen::Vector3f::UnitY()));
    pose.translation() = share * Eigen::Vector3f(0.005F, 0, 0.01F);
    solver.move_tool(tool, pose);
    solver.step(5e-3F);
  }
  StepReport report = run(solver, 600);

  CHECK(report.non_finite_vertices == 0);
  float fastest = 0;
  for (const Eigen::Vector3f& v : solver.velocities()) {
    fastest = std::max(fastest, v.norm());
  }
  CHECK(fastest < 1e-3F);  // m/s
  CHECK(solver.convergence(5e-3F)[0].ratio() < 0.01);
}

// Would catch a move that takes a lost vertex for one in balance.
TEST_CASE("coarse correction: a vertex that is lost takes nothing else along", "[unit]") {
  const Scene scene = make_bar(neo_hookean(2e4F, 0.4F));
  Solver solver(scene, corrected(3));
  Start velocities(solver.positions().size(), Eigen::Vector3f::Zero());
  velocities.back().setConstant(std::numeric_limits<float>::max());
  solver.write_velocities(velocities);
  CHECK(solver.step(1.5F).non_finite_vertices == 1);  // all fall by metres

  const StepReport report = run(solver, 300);

  CHECK(report.non_finite_vertices == 1);
  float fastest = 0;
  for (const Eigen::Vector3f& v : solver.velocities()) {
    fastest = std::max(fastest, v.allFinite() ? v.norm() : 0.0F);
  }
  CHECK(fastest < 1);  // m/s
}

// Places of a node's vertices count from its first. Would catch a piece that does not turn any more
// once that one is lost.
TEST_CASE("coarse correction: the first vertex of a node may be lost", "[unit]") {
  const Scene scene = weightless(make_bar(neo_hookean(2e4F, 0.4F), {16, 4, 4}));
  SolverOptions options = corrected(3);
  options.executor = executor::serial();
  Solver solver(scene, options);
  const SolverData& data = testing::inspect(solver);
  Start start = turned(testing::stretched(scene, 1.0F), 2);
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (data.place_of_vertex[v] == data.coarse_space.members(1).own[0]) {
      start[v].setConstant(1e30F);
    }
  }
  solver.write_positions(start);
  solver.step(1e-3F);

  const Eigen::Matrix3f expected =
      Eigen::AngleAxisf(2, Eigen::Vector3f(1, 2, -1).normalized()).matrix();
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> found(
      data.step_scratch.coarse.turns[0].of);
  CHECK((found - expected).norm() < 0.01F);
}

// Would catch a wrong sign in a quaternion, mirror images, and steps that end too early.
TEST_CASE("coarse correction: turns are those of a singular value decomposition", "[unit]") {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200; ++i) {
    Eigen::Matrix3d product;
    for (double& number : product.reshaped()) {
      number = normal(random);
    }
    if (i % 3 == 0) {  // flat
      product.col(2) = product.col(0) - 2 * product.col(1);
    }
    product *= std::pow(10.0, i % 11 - 5);
    const Eigen::JacobiSVD<Eigen::Matrix3d> svd(product, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Eigen::Matrix3d u = svd.matrixU();
    u.col(2) *= (u * svd.matrixV().transpose()).determinant();
    const Eigen::Matrix3d expected = u * svd.matrixV().transpose();
    double numbers[3][3];
    for (int row = 0; row < 3; ++row) {
      for (int column = 0; column < 3; ++column) {
        numbers[row][column] = product(row, column);
      }
    }

    const Turn turn = nearest_turn(numbers);

    CAPTURE(i, product);
    const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> found(turn.of);
    REQUIRE((found.cast<double>() - expected).norm() < 5e-6);
  }
}

TEST_CASE("coarse correction: what lies on a line turns no further than it must", "[unit]") {
  const Eigen::Vector3d place = Eigen::Vector3d(1, 2, -0.5).normalized();
  const Eigen::Vector3d way = Eigen::Vector3d(-0.3, 1, 2).normalized();
  double numbers[3][3];
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      numbers[row][column] = way[row] * place[column];
    }
  }
  const Turn turn = nearest_turn(numbers);
  const Eigen::Matrix3d expected = Eigen::Quaterniond::FromTwoVectors(place, way).matrix();
  const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> found(turn.of);
  CHECK((found.cast<double>() - expected).norm() < 0.01);
}

TEST_CASE("coarse correction: what lies at one place or nowhere does not turn", "[unit]") {
  const double scale = GENERATE(0.0, std::numeric_limits<double>::infinity(),
                                std::numeric_limits<double>::quiet_NaN());
  const double numbers[3][3] = {{scale, 0, 0}, {0, scale, 0}, {0, 0, scale}};
  const Turn turn = nearest_turn(numbers);
  CHECK(std::ranges::equal(turn.of, Turn{}.of));
}

// Would catch a factorisation that reads what it has overwritten.
TEST_CASE("coarse correction: springs at holds hold as the whole system says", "[unit]") {
  constexpr Index kModes = 20;
  CoarseRows holds;
  holds.count = 4;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(0.5F, 2);
  for (Index hold = 0; hold < holds.count; ++hold) {
    holds.sums[hold] = 10 * uniform(random);
    holds.counts[hold] = hold + 1;
  }
  const Index rows = 3 * holds.count;
  Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> moves(kModes, rows);
  for (float& number : moves.reshaped()) {
    number = uniform(random) - 1.2F;
  }
  Eigen::VectorXf gives(kModes), loads(kModes);
  for (Index m = 0; m < kModes; ++m) {
    gives[m] = uniform(random);
    loads[m] = uniform(random) - 1;
  }
  const Eigen::VectorXf amplitudes = gives.cwiseProduct(loads);
  Eigen::MatrixXd whole = gives.cast<double>().cwiseInverse().asDiagonal();
  for (Index row = 0; row < rows; ++row) {
    const Eigen::VectorXd of_row = moves.col(row).cast<double>();
    whole += of_row * of_row.transpose() / holds.give(row / 3);
  }
  const Eigen::VectorXd expected = whole.ldlt().solve(loads.cast<double>());

  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> all(kModes, rows + 1);
  all << moves.cast<double>(), amplitudes.cast<double>();
  const Eigen::VectorXd all_gives = gives.cast<double>();
  HoldSystem system;
  system.solve(OneWorker{}, holds, [&](Index entry) {
    return HoldSystem::sum_of_modes(entry, rows, kModes, all_gives.data(), all.data());
  });

  for (Index m = 0; m < kModes; ++m) {
    CAPTURE(m);
    CHECK(amplitudes[m] - system.taken(rows, gives[m], moves.data() + m * rows) ==
          Approx(expected[m]).margin(1e-5));
  }
}

// Would catch places without a node near, and lists that are empty.
TEST_CASE("coarse correction: takes any scene", "[unit]") {
  Scene scene;
  const std::string which =
      GENERATE("particles alone", "one tetrahedron", "more pieces than nodes", "all fixed");
  CAPTURE(which);
  if (which == "particles alone") {
    scene.add_particles("thread", std::vector<Eigen::Vector3d>{{0, 0, 0}, {0, 0.01, 0}}, 1e-3);
    scene.add_link({0, 1, 0.01F, {1, 0.1F}});
  } else if (which == "more pieces than nodes") {
    for (int i = 0; i < 60; ++i) {
      std::vector<Eigen::Vector3d> positions;
      const TetMesh mesh = testing::make_box({1, 1, 1}, kSoftEdge);
      for (const Eigen::Vector3d& x : mesh.positions()) {
        positions.emplace_back(x + Eigen::Vector3d(0.01 * i, 0, 0));
      }
      scene.add_body("body " + std::to_string(i),
                     TetMesh(positions, {mesh.tets().begin(), mesh.tets().end()}),
                     neo_hookean(2e4F, 0.4F));
    }
  } else {
    scene.add_body("tet",
                   TetMesh({{0, 0, 0}, {0.01, 0, 0}, {0, 0.01, 0}, {0, 0, 0.01}}, {{0, 1, 2, 3}}),
                   neo_hookean(2e4F, 0.4F));
    if (which == "all fixed") {
      scene.fix_where(0, [](const Eigen::Vector3d&) { return true; });
    }
  }
  Solver solver(scene, corrected(3));
  const StepReport report = run(solver, 10);
  CHECK(report.non_finite_vertices == 0);
  CHECK_THAT(solver.plan().name, ContainsSubstring("coarse correction"));
  for (const Eigen::Vector3f& v : solver.velocities()) {  // all fall, or nothing moves
    CHECK(v.y() == Approx(which == "all fixed" ? 0 : -9.81 * 0.05).epsilon(1e-3));
  }
}

// Would catch vertices of a cut without a share in the modes, which would stay behind, and modes
// that a compaction does not make anew.
TEST_CASE("coarse correction: new vertices move with those that they come of", "[unit]") {
  const Scene scene = make_bar(neo_hookean(2e4F, 0.45F), {16, 4, 4});
  Solver solver(scene, corrected(3, 20)), many(scene, vertex_options(1, 60, 20));
  const Index before = solver.vertex_count();
  for (Solver* each : {&solver, &many}) {
    each->tissue().apply(testing::part_vertex(*each, 40, 1));
    run(*each, 200);
  }
  REQUIRE(solver.vertex_count() > before);
  const auto vertices = inspect(solver).coarse_space.vertices();
  REQUIRE(vertices.size() == static_cast<std::size_t>(solver.vertex_count()));
  CHECK(vertices.back().takes_part());
  CHECK(farthest(solver, many) < 0.01F * static_cast<float>(kSoftEdge));

  Compaction compaction(solver);
  compaction.build();
  compaction.finish(solver);
  CHECK(inspect(solver).coarse_space.node_count() > 0);
  CHECK(run(solver, 3).non_finite_vertices == 0);
}

}  // namespace pbdsurg
