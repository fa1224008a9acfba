// SPDX-License-Identifier: Apache-2.0
// Vertices that edits fix and let go, and links whose rest lengths edits change.
#include <algorithm>
#include <array>
#include <limits>
#include <vector>

#include "pbdsurg/base/error.h"
#include "pbdsurg/tissue/tissue.h"
#include "pbdsurg/views/live_pieces.h"

#include "tests/support/catch.h"
#include "tests/support/inspect.h"
#include "tests/support/meshes.h"
#include "tests/support/small_steps.h"
#include "tests/support/vertex_method_cases.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::ContainsSubstring;
using testing::inspect;

constexpr float kStep = 5e-3F;
constexpr float kGravity = 9.81F;

SolverOptions options_of(SolverMethod method, Index copies = 1) {
  SolverOptions options = testing::small_steps({.method = method});
  if (method == SolverMethod::explicit_steps) {
    options.substeps = kAutomatic;
    options.iterations = kAutomatic;
  }
  options.damping = 0;
  options.copies = copies;
  options.executor = executor::serial();
  return options;
}

SolverMethod any_method() {
  return GENERATE(SolverMethod::projection, SolverMethod::vertex_block,
                  SolverMethod::explicit_steps);
}

std::vector<Index> vertices_where(const Solver& solver, double up_to_x) {
  std::vector<Index> vertices;
  for (Index v = 0; v < solver.vertex_count(); ++v) {
    if (solver.tissue().rest_positions()[v].x() < up_to_x) {
      vertices.push_back(v);
    }
  }
  return vertices;
}

void run(Solver& solver, double seconds) {
  for (int i = 0; i < static_cast<int>(seconds / kStep + 0.5); ++i) {
    REQUIRE(solver.step(kStep).non_finite_vertices == 0);
  }
}

// A bar of tissue that is held at its start.
Scene make_bar() {
  return testing::make_bar(testing::neo_hookean(2e4F, 0.45F), {6, 2, 2});
}

float largest_distance(const std::vector<Eigen::Vector3f>& a,
                       const std::vector<Eigen::Vector3f>& b) {
  float largest = 0;
  for (std::size_t v = 0; v < a.size(); ++v) {
    largest = std::max(largest, (a[v] - b[v]).norm());
  }
  return largest;
}

}  // namespace

// Would catch tissue that stays where it was held, or starts with a speed of its own, and sweeps
// that give a free piece momentum as if it were held still.
TEST_CASE("fixing: a bar that is let go falls as a stone does", "[unit]") {
  const SolverMethod method = any_method();
  Solver solver(make_bar(), options_of(method, 2));
  const std::vector<Index> held = vertices_where(solver, 0.5 * testing::kSoftEdge);
  REQUIRE(held.size() == 9);
  run(solver, 0.05);
  const auto mean = [&](const std::vector<Eigen::Vector3f>& values) {
    Eigen::Vector3d sum = Eigen::Vector3d::Zero();
    double mass = 0;
    for (std::size_t v = 0; v < values.size(); ++v) {
      const double own = solver.tissue().masses()[v];
      sum += own * values[v].cast<double>();
      mass += own;
    }
    return Eigen::Vector3d(sum / mass);
  };
  const Eigen::Vector3d place = mean(solver.positions(1)), speed = mean(solver.velocities(1));
  solver.tissue().apply({.unfix_vertices = held});
  for (const Index v : held) {
    CHECK(!solver.tissue().is_fixed(v));
    CHECK(solver.velocities(1)[v].isZero(0));
  }
  constexpr double kTime = 0.1;
  run(solver, kTime);
  const Eigen::Vector3d fallen = mean(solver.positions(1)) - place;
  const double by_gravity = -kGravity * kTime * kTime / 2;
  const double expected = speed.y() * kTime + by_gravity;
  CHECK(fallen.y() == Approx(expected).margin(0.02 * -by_gravity));
  CHECK(mean(solver.velocities(1)).y() == Approx(speed.y() - kGravity * kTime).epsilon(0.01));
  CHECK(std::abs(fallen.x() - speed.x() * kTime) < 0.01 * -by_gravity);
}

// Would catch a vertex that a copy moves on, or that drifts, and one that starts again with the
// speed that it had when it was stopped.
TEST_CASE("fixing: what is fixed in mid-flight stays there until it is let go", "[unit]") {
  const SolverMethod method = any_method();
  Scene scene;
  scene.add_body("block", testing::make_box({2, 2, 2}, testing::kSoftEdge, 0.1),
                 testing::neo_hookean(2e4F, 0.45F));
  Solver solver(scene, options_of(method, 2));
  run(solver, 0.05);
  const std::array<Index, 3> stopped{0, 5, 13};
  const std::vector<Eigen::Vector3f> before = solver.positions(1);
  solver.tissue().apply({.fix_vertices = {stopped.begin(), stopped.end()}});
  run(solver, 0.1);
  for (const Index v : stopped) {
    CHECK(solver.tissue().is_fixed(v));
    CHECK(solver.positions(1)[v] == before[v]);
    CHECK(solver.velocities(1)[v].isZero(0));
  }
  CHECK(largest_distance(solver.positions(1), before) > 1e-5F);
  solver.tissue().apply({.unfix_vertices = {5}});
  CHECK(solver.velocities(1)[5].isZero(0));
  run(solver, 0.01);
  CHECK(solver.positions(1)[5] != before[5]);
  CHECK(solver.positions(1)[0] == before[0]);
}

// Would catch anything that is decided at the start for those that were fixed then: colours, rows,
// masses, pieces.
TEST_CASE("fixing: tissue moves as if it had been fixed, or free, from the start",
          "[equivalence]") {
  const SolverMethod method = any_method();
  Scene scene = make_bar();
  Scene both = make_bar();
  const auto is_end = [](const Eigen::Vector3d& x) { return x.x() > 5.5 * testing::kSoftEdge; };
  both.fix_where(0, is_end);
  std::vector<Index> end;
  for (Index v = 0; v < scene.vertex_count(); ++v) {
    if (is_end(scene.positions()[v])) {
      end.push_back(v);
    }
  }
  const bool fixes = GENERATE(true, false);
  Solver edited(fixes ? scene : both, options_of(method));
  Solver expected(fixes ? both : scene, options_of(method));
  edited.tissue().apply(fixes ? TopologyEdit{.fix_vertices = end}
                              : TopologyEdit{.unfix_vertices = end});
  run(edited, 0.1);
  run(expected, 0.1);
  if (method == SolverMethod::vertex_block) {  // in colours of their own
    const float sag = largest_distance(expected.positions(),
                                       std::vector<Eigen::Vector3f>(Solver(scene).positions()));
    CHECK(largest_distance(edited.positions(), expected.positions()) < 0.02F * sag);
  } else if (method == SolverMethod::projection) {
    CHECK(edited.state_hash() == expected.state_hash());
  } else {
    CHECK(largest_distance(edited.positions(), expected.positions()) < 1e-5F);
  }
}

// Would catch pieces that are held by what was let go, or not by what was fixed, when tissue parts.
TEST_CASE("fixing: pieces know what holds them", "[unit]") {
  Solver solver(make_bar(), options_of(SolverMethod::vertex_block));
  LivePieces pieces(solver.tissue());
  solver.tissue().add_follower(pieces);
  CHECK(pieces.is_anchored(0));
  const std::vector<Index> held = vertices_where(solver, 0.5 * testing::kSoftEdge);
  solver.tissue().apply({.unfix_vertices = held});
  CHECK(!pieces.is_anchored(0));
  solver.tissue().undo();
  CHECK(pieces.is_anchored(0));
  solver.tissue().apply({.unfix_vertices = held});
  const Index last = solver.vertex_count() - 1;
  // a slice of tetrahedra goes, and the far end is fixed by the same edit
  TopologyEdit edit{.fix_vertices = {last}};
  for (Index t = 0; t < static_cast<Index>(solver.tissue().tets().size()); ++t) {
    double x = 0;
    for (const Index v : solver.tissue().tets()[t]) {
      x += solver.tissue().rest_positions()[v].x() / 4;
    }
    if (x > 2 * testing::kSoftEdge && x < 4 * testing::kSoftEdge) {
      edit.remove_tets.push_back(t);
    }
  }
  solver.tissue().apply(edit);
  const Index of_end = pieces.piece_of(solver.tissue().tets_at(last).front());
  const Index of_start = pieces.piece_of(solver.tissue().tets_at(held.front()).front());
  REQUIRE(of_end != of_start);
  CHECK(pieces.is_anchored(of_end));
  CHECK(!pieces.is_anchored(of_start));
  run(solver, 0.05);
  CHECK(solver.positions()[held.front()].y() <
        static_cast<float>(solver.tissue().rest_positions()[held.front()].y()) - 0.01F);
}

// Would catch a link that goes on with the length that it had, by its spring or by its phases of a
// stiff one.
TEST_CASE("fixing: a suture that is drawn in lifts what hangs on it", "[unit]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const float compliance = GENERATE(0.0F, 1e-2F);
  constexpr double kMass = 0.01;  // kg
  const std::vector<Eigen::Vector3d> places{{0, 0, 0}, {0, -0.02, 0}};
  Scene scene;
  scene.add_particles("thread", places, kMass);
  scene.add_link({0, 1, 0.02F, {1, compliance}});
  scene.fix_vertices(0, std::array<Index, 1>{0});
  Solver solver(scene, options_of(method));
  const auto settle = [&](int steps) {
    for (int i = 0; i < steps; ++i) {
      solver.step(kStep);
      std::vector<Eigen::Vector3f> slow = solver.velocities();
      for (Eigen::Vector3f& v : slow) {
        v *= 0.9F;
      }
      solver.write_velocities(slow);
    }
    return -solver.positions()[1].y();
  };
  const float extension = compliance * static_cast<float>(kMass) * kGravity;
  CHECK(settle(400) == Approx(0.02F + extension).epsilon(0.01));
  constexpr float kPull = 5e-4F;  // m, at a time: a jerk would throw the weight over its hold
  for (int pull = 1; pull <= 30; ++pull) {
    solver.tissue().apply({.link_lengths = {{0, 0.02F - static_cast<float>(pull) * kPull}}});
    settle(10);
  }
  CHECK(solver.tissue().links()[0].rest_length == Approx(0.005));
  CHECK(settle(400) == Approx(0.005F + extension).epsilon(0.01));
  solver.tissue().undo();
  CHECK(solver.tissue().links()[0].rest_length == Approx(0.005F + kPull));
  CHECK(settle(400) == Approx(0.005F + kPull + extension).epsilon(0.01));
}

// Would catch a link that was a spring as long as its end was fixed, and is too stiff for one now.
TEST_CASE("fixing: links of what is let go are stiff where they must be", "[unit]") {
  const std::vector<Eigen::Vector3d> places{{0, 0, 0}, {0, -0.02, 0}};
  Scene scene;
  scene.add_particles("thread", places, 1e-4);
  scene.add_link({0, 1, 0.02F, {1, 1e-6F}});
  scene.fix_vertices(0, std::array<Index, 1>{0});
  Solver solver(scene, options_of(SolverMethod::vertex_block));
  const auto& stiff = inspect(solver).sets.of<StiffLinkConstraint>();
  CHECK(!stiff.is_alive(0));
  solver.tissue().apply({.unfix_vertices = {0}});
  CHECK(stiff.is_alive(0));
  CHECK(inspect(solver).vertex_blocks.springs()[0].stiffness == 0);
  std::vector<Eigen::Vector3f> apart = solver.positions();
  apart[1].y() -= 0.001F;
  solver.write_positions(apart);
  solver.step(kStep);
  CHECK((solver.positions()[0] - solver.positions()[1]).norm() < 0.02002F);
  solver.tissue().undo();
  CHECK(!stiff.is_alive(0));
  CHECK(inspect(solver).vertex_blocks.springs()[0].stiffness > 0);
}

// Would catch an edit that is half applied, and one that no rule stops.
TEST_CASE("fixing: says what it refuses, and changes nothing", "[unit]") {
  Scene scene = make_bar();
  scene.add_particles("thread", std::vector<Eigen::Vector3d>{{0, 0, 0.1}, {0, 0.02, 0.1}}, 1e-4);
  const Index thread = scene.body(1).first_vertex;
  scene.add_link({thread, thread + 1, 0.02F, {}});
  Solver solver(scene, options_of(SolverMethod::projection));
  const Index count = solver.vertex_count();
  const auto refuse = [&](const TopologyEdit& edit, const std::string& what) {
    CHECK_THROWS_WITH(solver.tissue().apply(edit), ContainsSubstring(what));
    CHECK(solver.tissue().version() == 0);
  };
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const Index held = vertices_where(solver, 1e-4).front();
  refuse({.fix_vertices = {count}}, "vertex " + std::to_string(count) + " does not exist");
  refuse({.unfix_vertices = {-1}}, "vertex -1 does not exist");
  refuse({.fix_vertices = {held}}, "is fixed already");
  refuse({.unfix_vertices = {thread}}, "is not fixed");
  refuse({.fix_vertices = {thread, thread}}, "is listed twice");
  refuse({.link_lengths = {{0, -1e-3F}}}, "link 0: the new rest length is -0.001");
  refuse({.link_lengths = {{0, nan}}}, "must be finite");
  refuse({.link_lengths = {{1, 1e-3F}}}, "link 1 does not exist");
  refuse({.link_lengths = {{0, 1e-3F}, {0, 2e-3F}}}, "link 0 is listed twice");
  refuse({.remove_links = {0}, .link_lengths = {{0, 1e-3F}}}, "is removed by one edit");
  refuse({.remove_bodies = {1}, .fix_vertices = {thread}}, "has no tissue left to be fixed");
  const auto at = solver.tissue().tets_at(held);
  refuse({.remove_tets = {at.begin(), at.end()}, .unfix_vertices = {held}},
         "has no tissue left to be let go");
  solver.tissue().apply({.remove_links = {0}});
  CHECK_THROWS_WITH(solver.tissue().apply({.link_lengths = {{0, 1e-3F}}}),
                    ContainsSubstring("link 0 was removed before"));
}

}  // namespace pbdsurg
