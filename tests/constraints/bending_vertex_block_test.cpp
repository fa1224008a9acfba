// SPDX-License-Identifier: Apache-2.0
// Hinges in vertex blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

#include "pbdsurg/base/random.h"
#include "pbdsurg/constraints/bending.h"
#include "pbdsurg/constraints/vertex_block.h"

#include "tests/support/bending_hinge.h"
#include "tests/support/catch.h"
#include "tests/support/constraint_checks.h"

namespace pbdsurg {
namespace {

using testing::Approx;
using testing::Hinge;
using testing::random_point;
using testing::turn_of;

// A hinge seen from one of its vertices: that vertex first or third.
std::array<int, 4> seen_from(int vertex) {
  return vertex % 2 == 0 ? std::array<int, 4>{0, 1, 2, 3} : std::array<int, 4>{1, 0, 3, 2};
}

VertexEnergy<double> hinge_energy(const Vec3<double> (&x)[4], int vertex, double stiffness,
                                  double rest) {
  const std::array<int, 4> order = seen_from(vertex);
  const Vec3<double> seen[4] = {x[order[0]], x[order[1]], x[order[2]], x[order[3]]};
  VertexEnergy<double> energy;
  energy.add_hinge(stiffness, rest, seen, vertex >= 2);
  return energy;
}

}  // namespace

TEST_CASE("bending in vertex blocks: the force is minus the gradient of the energy", "[property]") {
  const double edge = GENERATE(1.0, 1e-4);
  const double rest = turn_of(GENERATE(-1.0, 0.0, 2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double stiffness = 3e-6;
  const Hinge hinge(edge, GENERATE(-2.0, 0.1, 1.0));
  const Vec3<double> force = hinge_energy(hinge.x, vertex, stiffness, rest).force;
  const double step = 1e-5 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    const double difference = std::pow(high.value(rest), 2) - std::pow(low.value(rest), 2);
    CHECK(force.*axis ==
          Approx(-stiffness / 2 * difference / (2 * step)).margin(1e-7 * stiffness / edge));
  }
}

TEST_CASE("bending in vertex blocks: at rest the Hessian is that of the energy", "[property]") {
  const double edge = 1e-3;
  const Hinge hinge(edge, GENERATE(0.0, 0.7, -2.0));
  const int vertex = GENERATE(0, 1, 2, 3);
  const double rest = hinge.value();
  const VertexEnergy<double> energy = hinge_energy(hinge.x, vertex, 1, rest);
  const double step = 1e-6 * edge;
  for (double Vec3<double>::*axis : {&Vec3<double>::x, &Vec3<double>::y, &Vec3<double>::z}) {
    Hinge low = hinge, high = hinge;
    low.x[vertex].*axis -= step;
    high.x[vertex].*axis += step;
    Vec3<double> unit;
    unit.*axis = 1;
    const Vec3<double> column = (1 / (2 * step)) * (hinge_energy(low.x, vertex, 1, rest).force -
                                                    hinge_energy(high.x, vertex, 1, rest).force);
    const Vec3<double> difference = energy * unit - column;
    CHECK(std::sqrt(dot(difference, difference)) < 1e-4 / (edge * edge));
  }
}

// Would catch a step that overshoots where the gradient vanishes: folded, or far from rest.
TEST_CASE("bending in vertex blocks: no step makes the energy grow, from any shape", "[property]") {
  const double inertia = GENERATE(1e-9, 1e-3, 1.0);  // times stiffness / size^2
  const double relaxation = GENERATE(1.0, 1.9);
  double largest = 0;
  int grown = 0;
  for (std::uint64_t seed = 1; seed <= 5000; ++seed) {
    Vec3<double> x[4];
    for (int i = 0; i < 4; ++i) {
      x[i] = random_point(1, seed, i);
    }
    const double rest = 8 * random_unit(seed, 10) - 4;
    for (int vertex = 0; vertex < 4; ++vertex) {
      VertexEnergy<double> energy = hinge_energy(x, vertex, 1, rest);
      energy.add_pull(inertia, {0, 0, 0});
      const Vec3<double> move = relaxation * VertexFactor<double>(energy).solve(energy.force);
      Vec3<double> moved[4] = {x[0], x[1], x[2], x[3]};
      moved[vertex] = x[vertex] + move;
      const double before = std::pow(BendingConstraint::value(x, rest), 2);
      const double after =
          std::pow(BendingConstraint::value(moved, rest), 2) + inertia * dot(move, move);
      grown += after > before * (1 + 1e-9) ? 1 : 0;
      largest = std::max(largest, std::sqrt(dot(move, move)));
    }
  }
  CHECK(grown == 0);
  CHECK(largest < 10);
}

}  // namespace pbdsurg
