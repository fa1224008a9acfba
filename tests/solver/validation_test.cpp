// SPDX-License-Identifier: Apache-2.0
// Chains of springs, whose statics and dynamics are known in closed form.
#include <cmath>
#include <numbers>

#include "pbdsurg/solver/solver.h"

#include "tests/support/catch.h"
#include "tests/support/small_steps.h"

namespace pbdsurg {
namespace {

using testing::Approx;

constexpr int kCount = 5;             // moving masses
constexpr double kMass = 2e-3;        // kg
constexpr float kCompliance = 5e-3F;  // m/N
constexpr double kLength = 1e-2;      // m, of each spring

// Masses 1..kCount hang below fixed mass 0, one spring between neighbours.
Scene make_chain() {
  Scene scene;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i <= kCount; ++i) {
    points.push_back({0, -kLength * i, 0});
  }
  const Index body = scene.add_particles("chain", points, kMass);
  scene.fix_vertices(body, std::vector<Index>{0});
  for (Index i = 0; i < kCount; ++i) {
    scene.add_link({i, i + 1, static_cast<float>(kLength), {1, kCompliance}});
  }
  return scene;
}

}  // namespace

// Would catch a compliance with a wrong power of the time step or of the iterations.
TEST_CASE("validation: a chain of springs sags as computed, whatever the step", "[validation]") {
  const int substeps = GENERATE(10, 40);
  const int iterations = GENERATE(1, 8);
  Solver solver(make_chain(), testing::small_steps(
                                  {.substeps = substeps, .iterations = iterations, .damping = 10}));

  for (int i = 0; i < 1000; ++i) {
    solver.step(5e-3F);
  }

  // spring i carries the kCount - i masses below it
  const double sag = kMass * 9.81 * kCompliance * kCount * (kCount + 1) / 2;
  const double measured = -kLength * kCount - solver.positions()[kCount].y();
  // One sweep a substep leaves an error of the order of inverse mass times h^2 over the compliance.
  // The one percent is single precision: gravity moves a mass by g h^2 = 0.15 um in the shortest
  // substep, and coordinates of 5 cm have a spacing of 0.004 um.
  const double h = 5e-3 / substeps;
  const double left = iterations == 1 ? h * h / (kMass * kCompliance) : 0;
  CHECK(measured == Approx(sag).epsilon(0.01 + left));
}

TEST_CASE("validation: a chain of springs swings with its period", "[validation]") {
  Scene scene = make_chain();
  scene.set_gravity(Eigen::Vector3f::Zero());
  Solver solver(scene, testing::small_steps({.substeps = 20, .iterations = 4}));
  // first longitudinal mode of a fixed-free chain
  const double wave_number = std::numbers::pi / (2 * kCount + 1);
  auto x = solver.positions();
  for (int i = 1; i <= kCount; ++i) {
    x[i].y() -= static_cast<float>(1e-3 * std::sin(wave_number * i));
  }
  solver.write_positions(x);

  const double omega = 2 * std::sqrt(1 / (kCompliance * kMass)) * std::sin(wave_number / 2);
  const double period = 2 * std::numbers::pi / omega;
  const double dt = period / 100;
  std::vector<double> crossings;  // downward through rest, with linear interpolation
  double before = solver.positions()[kCount].y() + kLength * kCount;
  for (int i = 1; crossings.size() < 4 && i < 1000; ++i) {
    solver.step(static_cast<float>(dt));
    const double now = solver.positions()[kCount].y() + kLength * kCount;
    if (before < 0 && now >= 0) {
      crossings.push_back(dt * (i - now / (now - before)));
    }
    before = now;
  }

  REQUIRE(crossings.size() == 4);
  CHECK((crossings[3] - crossings[0]) / 3 == Approx(period).epsilon(0.005));
}

}  // namespace pbdsurg
