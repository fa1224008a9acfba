// SPDX-License-Identifier: Apache-2.0
#include "lib/solver/methods/passing.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <vector>

#include "pbdsurg/base/random.h"
#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/meshes.h"
#include "tests/support/sheet_meshes.h"
#include "tests/support/soft_block.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::at;
using FloatVector = Vec3<float>;

constexpr float kRadius = 0.5e-3F;
constexpr ToolSurface kAll{ContactFeatures::all, 0};

// Corners around the origin in the plane of x and y, seen from above, that go by a way.
FeatureCorners make_triangle(const FloatVector& way) {
  FeatureCorners corners;
  corners.count = 3;
  const FloatVector places[3] = {{-5e-3F, -5e-3F, 0}, {5e-3F, -5e-3F, 0}, {0, 5e-3F, 0}};
  for (int k = 0; k < 3; ++k) {
    corners.places[k] = k;
    corners.start[k] = places[k];
    corners.end[k] = places[k] + way;
  }
  return corners;
}

SweptCapsule make_rod(const FloatVector& start, const FloatVector& end, const FloatVector& way) {
  const PlacedCapsule before{start, kRadius, end};
  return {before, before.moved(way)};
}

std::array<bool, 3> passing_corners(const SweptCapsule& capsule, const FeatureCorners& corners) {
  const Passing passing(capsule, corners);
  return {passing.has(0), passing.has(1), passing.has(2)};
}

constexpr std::array kNone{false, false, false}, kEvery{true, true, true};

// A free square tube, and a rod in it that is much longer: thrust to one side, to the other, and
// back.
class Tube {
 public:
  Tube(const SolverOptions& options, std::uint64_t shot)
      : scene_(make_scene()), solver_(scene_, options), shot_(shot) {
    const Capsule rod{{0, 0, -1}, {0, 0, 1}, kRadius};
    tool_ = solver_.add_tool({&rod, 1}, at(Eigen::Vector3f::Zero()), kAll);
  }

  // Calls visit() after each step.
  template <class Visit>
  void thrust(float step, const Visit& visit) {
    testing::for_each_thrust(11, shot_, step, [&](const Eigen::Vector3f& place) {
      place_ = place;
      solver_.move_tool(tool_, at(place));
      solver_.step(step);
      visit();
    });
  }

  [[nodiscard]] bool holds_rod() const { return testing::is_around(solver_.positions(), place_); }
  [[nodiscard]] const Solver& solver() const { return solver_; }
  [[nodiscard]] ToolId tool() const { return tool_; }
  [[nodiscard]] std::span<const double> masses() const { return scene_.masses(); }

 private:
  static Scene make_scene() {
    const testing::SheetMesh mesh = testing::make_square_tube(10e-3, 60e-3);
    Scene scene;
    scene.add_sheet("tube", mesh.positions, mesh.triangles, {});
    scene.set_gravity(Eigen::Vector3f::Zero());
    return scene;
  }

  Scene scene_;
  Solver solver_;
  std::uint64_t shot_;
  Eigen::Vector3f place_ = Eigen::Vector3f::Zero();
  ToolId tool_{};
};

}  // namespace

// Would catch an edge that an axis sweeps through, or corners that are taken along though they have
// nothing to do with it.
TEST_CASE("passing: an axis passes a triangle through an edge", "[unit]") {
  const FeatureCorners triangle = make_triangle({0, 0, 0});
  // across the edge of the first two corners, from outside
  const SweptCapsule across = make_rod({0, -6e-3F, -20e-3F}, {0, -6e-3F, 20e-3F}, {0, 2e-3F, 0});
  CHECK(passing_corners(across, triangle) == std::array{true, true, false});
  CHECK(passing_corners(make_rod({0, -6e-3F, -20e-3F}, {0, -6e-3F, 20e-3F}, {0, 0.5e-3F, 0}),
                        triangle) == kNone);
  // what counts is how they move against each other
  CHECK(passing_corners(make_rod({0, -6e-3F, -20e-3F}, {0, -6e-3F, 20e-3F}, {0, 0, 0}),
                        make_triangle({0, -2e-3F, 0})) == std::array{true, true, false});
  CHECK(passing_corners(across, make_triangle({0, 2e-3F, 0})) == kNone);
  // flat through all of it: by two edges
  CHECK(passing_corners(make_rod({-20e-3F, 0, 1e-3F}, {20e-3F, 0, 1e-3F}, {0, 0, -2e-3F}),
                        triangle) == kEvery);
}

TEST_CASE("passing: a tip passes a triangle", "[unit]") {
  const FeatureCorners triangle = make_triangle({0, 0, 0});
  const auto tip = [](float x, float way) {
    return make_rod({x, 0, 1e-3F}, {x, 0, 50e-3F}, {0, 0, way});
  };
  CHECK(passing_corners(tip(0, -2e-3F), triangle) == kEvery);
  CHECK(passing_corners(tip(0, -0.5e-3F), triangle) == kNone);
  CHECK(passing_corners(tip(4e-3F, -2e-3F), triangle) == kNone);  // beside it
}

// Would catch a plate that a vertex goes through, which no side of it meets.
TEST_CASE("passing: a vertex passes a plate", "[unit]") {
  const PlacedCapsule before{
      {-20e-3F, -20e-3F, 1e-3F}, kRadius, {20e-3F, -20e-3F, 1e-3F}, {0, 40e-3F, 0}};
  FeatureCorners corners = make_triangle({0, 0, 0});
  corners.end[2] = corners.end[2] + FloatVector{0, 0, 2e-3F};
  CHECK(passing_corners({before, before}, corners) == std::array{false, false, true});
  corners.end[2] = corners.start[2] + FloatVector{0, 0, 0.5e-3F};
  CHECK(passing_corners({before, before}, corners) == kNone);
}

// Would catch a sheet that has an inside.
TEST_CASE("passing: it does not matter from which side", "[unit]") {
  const FeatureCorners triangle = make_triangle({0, 0, 0});
  const float way = GENERATE(-2e-3F, 2e-3F);
  const float z = -0.5F * way;
  CHECK(passing_corners(make_rod({-20e-3F, 0, z}, {20e-3F, 0, z}, {0, 0, way}), triangle) ==
        kEvery);
  CHECK(passing_corners(make_rod({0, 0, z}, {0, 0, z}, {0, 0, way}), triangle) == kEvery);
}

// Would catch a ball that starts with its centre just in a surface, and takes it along when it
// leaves.
TEST_CASE("passing: a tip that leaves a surface takes nothing along", "[unit]") {
  const float x = GENERATE(0.0F, 3e-3F);
  const float way = GENERATE(-4e-3F, 4e-3F);
  CHECK(passing_corners(make_rod({x, 0, 0}, {x, 0, 0}, {0, 0, way}), make_triangle({0, 0, 0})) ==
        kNone);
}

// Would catch a link of particles whose second end is there twice, and counts as a triangle.
TEST_CASE("passing: a link is passed as an edge", "[unit]") {
  FeatureCorners link = make_triangle({0, 0, 0});
  link.places[2] = link.places[1];
  link.start[2] = link.start[1];
  link.end[2] = link.end[1];
  const SweptCapsule across = make_rod({0, -6e-3F, -20e-3F}, {0, -6e-3F, 20e-3F}, {0, 2e-3F, 0});
  CHECK(passing_corners(across, link) == kEvery);  // the second end is there twice
  const SweptCapsule tip = make_rod({0, -4e-3F, 1e-3F}, {0, -4e-3F, 50e-3F}, {0, 0, -2e-3F});
  CHECK(passing_corners(tip, link) == kNone);
}

// Would catch walls that sweeps throw through a rod, and folds whose contacts are against each
// other. With no room for a contact, nothing else stops what passes.
TEST_CASE("passing: rods that are thrust about in a free tube stay in it", "[validation]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const TimeIntegration integration =
      GENERATE(TimeIntegration::implicit_euler, TimeIntegration::bdf2);
  const float step = GENERATE(1e-3F, 5e-3F, 16e-3F);
  const Index capacity = GENERATE(4096, 0);
  CAPTURE(static_cast<int>(method), static_cast<int>(integration), step, capacity);
  const SolverOptions options{.method = method,
                              .integration = integration,
                              .contact_capacity = capacity,
                              .executor = executor::serial()};
  for (std::uint64_t shot = 0; shot < 25; ++shot) {
    CAPTURE(shot);
    Tube tube(options, shot);
    bool is_inside = true;
    tube.thrust(step, [&] { is_inside = is_inside && tube.holds_rod(); });
    CHECK(is_inside);
  }
}

// Would catch a push that tissue takes and the tool does not feel.
TEST_CASE("passing: the tool feels what it takes along", "[validation]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  CAPTURE(static_cast<int>(method));
  constexpr float kStep = 2e-3F;
  const SolverOptions options{.method = method,
                              .integration = TimeIntegration::implicit_euler,
                              .contact_capacity = 0,
                              .executor = executor::serial()};
  for (std::uint64_t shot = 0; shot < 5; ++shot) {
    CAPTURE(shot);
    Tube tube(options, shot);
    const Solver& solver = tube.solver();
    const auto momentum = [&] {
      Eigen::Vector3d sum = Eigen::Vector3d::Zero();
      const std::vector<Eigen::Vector3f> velocities = solver.velocities();
      for (std::size_t v = 0; v < velocities.size(); ++v) {
        sum += tube.masses()[v] * velocities[v].cast<double>();
      }
      return sum;
    };
    Eigen::Vector3d before = Eigen::Vector3d::Zero();
    double exchanged = 0, lost = 0;
    tube.thrust(kStep, [&] {
      const Eigen::Vector3d now = momentum();
      const Eigen::Vector3d felt = kStep * solver.tool_force(tube.tool()).cast<double>();
      exchanged += felt.norm();
      lost = std::max(lost, (now - before + felt).norm());
      before = now;
    });
    CHECK(exchanged > 1e-3);  // kg m/s, of 2.4 g
    CHECK(lost < 1e-4 * exchanged);
  }
}

// Would catch a barrier that is missing, or what a worker's scratch has of another copy.
TEST_CASE("passing: any number of threads takes the same along", "[unit]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Index capacity = GENERATE(4096, 0);
  CAPTURE(static_cast<int>(method), capacity);
  const auto end_of = [&](const Executor& executor) {
    Tube tube({.method = method,
               .contact_capacity = capacity,
               .executor = executor,
               .math = MathMode::strict},
              5);
    tube.thrust(5e-3F, [] {});
    return tube.solver().positions();
  };
  const std::vector<Eigen::Vector3f> expected = end_of(executor::serial());
  for (const int threads : {1, 2, 4}) {
    CAPTURE(threads);
    CHECK(end_of(executor::threads(threads)) == expected);
  }
  for (int run = 0; run < 10; ++run) {  // threads that leave their team when it takes too long
    CHECK(end_of(executor::threads()) == expected);
  }
}

// Would catch a stop that strains what is beside it, more in each substep: a rod that lies deep in
// a sheet whose rim is fixed. With no room for a contact, nothing else holds it.
TEST_CASE("passing: a sheet that a rod is pressed into comes to rest", "[validation]") {
  const SolverMethod method = GENERATE(SolverMethod::projection, SolverMethod::vertex_block);
  const Index capacity = GENERATE(4096, 0);
  CAPTURE(static_cast<int>(method), capacity);
  constexpr float kDeep = 8e-3F;
  const testing::SheetMesh mesh = testing::make_sheet({8, 8}, 5e-3);
  Scene scene;
  const BodyId sheet = scene.add_sheet("sheet", mesh.positions, mesh.triangles, {});
  scene.fix_vertices(sheet, testing::rim_of_sheet({8, 8}));
  SolverOptions options{.method = method, .contact_capacity = capacity};
  options.damping = 20;
  Solver solver(scene, options);
  const Capsule rod{{-8e-3F, 0, 0}, {8e-3F, 0, 0}, kRadius};
  const auto pose = [](float depth) { return at({20e-3F, 21e-3F, 1e-3F - depth}); };
  const ToolId tool = solver.add_tool({&rod, 1}, pose(0), kAll);
  float fastest = 0;
  for (int i = 1; i <= 400; ++i) {
    solver.move_tool(tool, pose(kDeep * std::min(1.0F, 0.01F * static_cast<float>(i))));
    REQUIRE(solver.step(5e-3F).non_finite_vertices == 0);
    for (const Eigen::Vector3f& velocity : solver.velocities()) {
      fastest = i > 300 ? std::max(fastest, velocity.norm()) : fastest;
    }
  }
  CHECK(fastest < 0.2F);  // m/s
  CHECK(solver.tool_force(tool).z() > 0);
}

// Would catch a tool that drags fixed vertices along.
TEST_CASE("passing: what is fixed stays where it is", "[unit]") {
  const testing::SheetMesh mesh = testing::make_sheet({2, 2}, 5e-3);
  Scene scene;
  const BodyId sheet = scene.add_sheet("sheet", mesh.positions, mesh.triangles, {});
  scene.set_gravity(Eigen::Vector3f::Zero());
  const std::vector<Index> rim = testing::rim_of_sheet({2, 2});
  scene.fix_vertices(sheet, rim);
  Solver solver(scene, {.contact_capacity = 0, .executor = executor::serial()});
  const Capsule ball{{0, 0, 0}, {0, 0, 50e-3F}, kRadius};
  const ToolId tool = solver.add_tool({&ball, 1}, at({5.5e-3F, 5.2e-3F, 3e-3F}), kAll);
  for (int i = 0; i < 20; ++i) {
    solver.move_tool(tool, at({5.5e-3F, 5.2e-3F, 3e-3F - 0.4e-3F * static_cast<float>(i)}));
    solver.step(5e-3F);
  }
  const std::vector<Eigen::Vector3f> x = solver.positions();
  for (const Index v : rim) {
    CHECK(x[v] == mesh.positions[static_cast<std::size_t>(v)].cast<float>());
  }
  CHECK(x[4].z() < 0);  // the one in the middle went along, as far as a single corner keeps a tip
}

}  // namespace pbdsurg
